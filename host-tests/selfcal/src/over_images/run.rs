//! A run over images: finds the rig, matches every pair, and runs the calibrator.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result, ensure};
use image::metadata::Orientation;
use images::matcher::{Matcher, MatcherConfig};
use images::moments::fits;
use images::pipeline::{First, Selection, first};
use images::rig::{FoundRig, RigRequest};
use images::session::{self, Request, Session};
use images::source::{Frame, Source, Wanted};
use rigs::data::{Meta, Turn, TurnedCamera, TurnedView};

use super::args::{Exif, SourceArgs};
use super::live::Live;

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

/// Ratio, in percent, of the matches that fit a rig for cropped images to those that fit a rig for scaled images, above
/// which images count as cropped.
const CLEARLY: usize = 120;

/// A finished run.
pub(crate) struct Ran {
    pub(crate) rig: FoundRig,
    pub(crate) session: Session,
    source: Source,
    /// The first left image.
    frame: Frame,
}

impl SourceArgs {
    /// Another rig of the images of a run.
    pub(crate) fn other_rig(&self, ran: &Ran, files: &[PathBuf]) -> Result<Meta> {
        let sizes = ran.session.set.meta.sizes();
        let request = self.request(&ran.source, files.to_vec());
        let rig = request
            .find(&ran.source.rig, sizes, &ran.frame)
            .with_context(|| format!("the rig {}", name(files)))?;
        for note in &rig.notes {
            eprintln!("note: {}: {note}", name(files));
        }
        Ok(rig.meta)
    }

    /// Runs the calibrator over the images, from the first of the rigs.
    ///
    /// * `frames`: file for the matches as frames of the link.
    /// * `out`: folder for rig and matches as a data set.
    /// * `quiet`: prints no line for a pair; a terminal shows the progress.
    pub(crate) fn run(
        &self,
        frames: Option<&Path>,
        out: Option<&Path>,
        quiet: bool,
    ) -> Result<Ran> {
        self.check()?;
        stop_at_ctrl_c();
        let wanted = Wanted {
            left: self.left_topic.clone(),
            right: self.right_topic.clone(),
            side_by_side: self.side_by_side,
            window: [self.start, self.end],
        };
        let mut source = Source::open(&self.source, &wanted, self.tolerance)?;
        if let Some(choice) = source.choice() {
            eprintln!("{choice}");
        }
        let first = first(&source)?;
        let matcher = MatcherConfig {
            prior_deg: self.prior,
            keypoints: self.keypoints,
            ..MatcherConfig::default()
        };
        let rig = self.starting_rig(&mut source, &first, matcher)?;
        let selection = Selection { every: self.every, most: self.pairs.unwrap_or(usize::MAX) };
        let count = source.count.map(|n| n.div_ceil(self.every).min(selection.most));
        let mut live = Live::new(count, quiet);
        let request = Request { source: &source, rig: &rig, matcher, selection, frames, out };
        let session = session::run(&request, &STOP, &mut live);
        live.finish();
        let [frame, _] = first.frames;
        Ok(Ran { session: session?, rig, source, frame })
    }

    fn check(&self) -> Result<()> {
        ensure!((0.1..=20.0).contains(&self.prior), "the prior must be from 0.1 to 20 degrees");
        let is_empty = self.start.zip(self.end).is_some_and(|(start, end)| start >= end);
        ensure!(!is_empty, "--start must be before --end");
        let (knock, most) = (self.knock.unwrap_or(0.0), self.prior);
        ensure!(
            knock.abs() <= most,
            "--knock {knock}: a turn of up to {most} degrees is searched for (--prior)"
        );
        Ok(())
    }

    /// The rig that the run starts from: the first of the rigs, turned by the knock.
    fn starting_rig(
        &self,
        source: &mut Source,
        first: &First,
        matcher: MatcherConfig,
    ) -> Result<FoundRig> {
        let request = self.request(source, self.rigs.0.first().cloned().unwrap_or_default());
        let rig = self.upright(&request, source, first).context("the rig")?;
        let mut rig = if_cut(rig, source, matcher)?;
        if let Some(degrees) = self.knock {
            let turn = Turn::new(&rig.meta, TurnedView::Top, degrees, TurnedCamera::Right)?;
            rig.meta = turn.meta(&rig.meta);
            rig.notes.push(format!(
                "the right camera of the rig is turned up by {degrees} degrees (--knock)"
            ));
        }
        for note in &rig.notes {
            eprintln!("note: {note}");
        }
        Ok(rig)
    }

    /// The rig. Decides whether the images of each side are turned by their EXIF orientation, and sets it in `source`.
    fn upright(
        &self,
        request: &RigRequest,
        source: &mut Source,
        first: &First,
    ) -> Result<FoundRig> {
        let asks = first.turns.map(|turn| turn != Orientation::NoTransforms);
        let find = |source: &Source, upright: [bool; 2]| {
            request.find(&source.rig, first.sizes_if(upright), &first.frames[0])
        };
        if asks == [false; 2] {
            source.upright = [self.exif != Some(Exif::Stored); 2];
            return find(source, [false; 2]);
        }
        let [l, r] = asks;
        let ways = match self.exif {
            Some(Exif::Upright) => vec![asks],
            Some(Exif::Stored) => vec![[false; 2]],
            None => vec![asks, [false; 2], [l, false], [false, r]],
        };
        let mut refused = None;
        for upright in ways {
            match find(source, upright) {
                Ok(mut rig) => {
                    // A side whose first image has no EXIF turn counts as upright.
                    source.upright = [0, 1].map(|side| upright[side] || !asks[side]);
                    rig.notes.push(turned_in_words(first, upright, asks));
                    return Ok(rig);
                }
                Err(why) => refused = refused.or(Some(why)),
            }
        }
        Err(refused.context("a way to read the images")?)
    }
}

/// The files of a rig in one line.
pub(crate) fn name(files: &[PathBuf]) -> String {
    files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(" ")
}

/// Lets a run end after the pairs in progress at the first Ctrl-C; the second one ends the command at once.
fn stop_at_ctrl_c() {
    // Without a handler, Ctrl-C ends the command as usual.
    let _ = ctrlc::set_handler(|| {
        if STOP.load(Ordering::Relaxed) {
            std::process::exit(130);
        }
        // Said first: the run may end at once when it sees the flag.
        eprintln!("stopping after the pairs in progress; press again to end at once");
        STOP.store(true, Ordering::Relaxed);
    });
}

fn turned_in_words(first: &First, upright: [bool; 2], asks: [bool; 2]) -> String {
    let side = |side: usize| {
        let turn = first.turns[side].to_exif();
        let done = match (asks[side], upright[side]) {
            (false, _) => "none",
            (true, true) => "turned upright",
            (true, false) => "left as stored",
        };
        format!("{} {turn}, {done}", ["left", "right"][side])
    };
    format!("EXIF orientation: {}; {} (--exif says otherwise)", side(0), side(1))
}

/// The rig of images cropped from the middle, if clearly more matches fit it than the rig of scaled images.
fn if_cut(mut rig: FoundRig, source: &Source, config: MatcherConfig) -> Result<FoundRig> {
    let Some(cut) = rig.if_cut.take() else { return Ok(rig) };
    let matchers = [Matcher::of(&rig.meta, config)?, Matcher::of(&cut, config)?];
    let [scaled, as_cut] = fits(source, matchers.each_ref())?;
    if 100 * as_cut > CLEARLY * scaled {
        rig.meta = *cut;
        let [w, h] = rig.meta.sizes()[0];
        rig.notes = vec![format!(
            "the rig belongs to larger images: taken as cropped from their middle to {w} x {h} px, since {as_cut} matches fit so, and {scaled} as \
             scaled (--cut scaled, or --cut X,Y, says otherwise)"
        )];
    }
    Ok(rig)
}
