//! Source of images, rig and matcher: the common arguments of `images` and `check`.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use super::rig::RigArgs;
use super::rig_files::RigFiles;
use crate::live::Live;
use anyhow::{Context, Result, ensure};
use clap::{Args, ValueEnum};
use image::metadata::Orientation;
use images::matcher::Matcher;
use images::matcher::MatcherConfig;
use images::moments::fits;
use images::pipeline::{First, Selection, first};
use images::rig::{Cut, FoundRig, RigRequest};
use images::session::{self, Request, Session};
use images::source::{Frame, Source, Wanted};
use rigs::data::{Meta, Turn, TurnedCamera, TurnedView};
use rigs::formats::Unknowns;

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

/// Images and their rig.
#[derive(Debug, Args)]
pub(crate) struct SourceArgs {
    /// A folder, an MCAP file (*.mcap), a ROS 1 bag (*.bag), or the left and the right folder, file or quoted pattern.
    /// Or images of the project: chess, motorcycle, aloe. Or a folder or pattern of pictures with both cameras side by
    /// side.
    #[arg(required = true, num_args = 1..=2, value_name = "SOURCE")]
    source: Vec<PathBuf>,

    #[command(flatten)]
    rigs: RigFiles,

    #[command(flatten)]
    lacks: RigArgs,

    /// Guess the calibration from this focal length, px. Without it the focal length of the EXIF data is used.
    #[arg(long, value_name = "PX", conflicts_with = "rig")]
    focal: Option<f64>,

    /// Topic of the left images of a bag, if several are possible.
    #[arg(long, value_name = "TOPIC")]
    left_topic: Option<String>,

    /// Topic of the right images.
    #[arg(long, value_name = "TOPIC")]
    right_topic: Option<String>,

    /// Each picture has both cameras side by side, the left one in the left half. By default this holds for pictures as
    /// wide as two.
    #[arg(long)]
    side_by_side: bool,

    /// Origin of images whose size differs from the rig's: scaled, cropped from the middle (centre), or cropped at X,Y
    /// [default: scaled if they have the same shape, unless many more matches fit a crop from the middle].
    #[arg(long, value_parser = cut, value_name = "scaled|centre|X,Y")]
    cut: Option<Cut>,

    /// Whether image files are turned by their EXIF orientation [default: upright, unless the rig belongs to the images
    /// as stored].
    #[arg(long, value_enum)]
    exif: Option<Exif>,

    /// Largest difference of the time stamps of a pair, s.
    #[arg(long, default_value_t = 0.005, value_name = "S")]
    tolerance: f64,

    /// Take every so many pairs.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = at_least_one)]
    every: usize,

    /// Take at most so many pairs.
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pairs: Option<usize>,

    /// Largest turn of the cameras since the rig was calibrated, degrees: half the band that is searched around the
    /// expected rows.
    #[arg(long, default_value_t = MatcherConfig::default().prior_deg, value_name = "D")]
    prior: f64,

    /// Start from a wrong calibration: the right camera of the rig is turned up by this angle, degrees, at most by the
    /// prior. If several rigs are given, the first is turned. Shows on images of a good rig how a knock is found.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    knock: Option<f64>,

    /// Corners sought in each image.
    #[arg(long, default_value_t = MatcherConfig::default().keypoints, value_name = "N", value_parser = at_least_one)]
    keypoints: usize,
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| format!("`{text}` is not a number from 1"))
}

fn cut(text: &str) -> Result<Cut, String> {
    let place = || {
        let (x, y) = text.split_once(',')?;
        Some(Cut::At([x.trim().parse().ok()?, y.trim().parse().ok()?]))
    };
    match text {
        "scaled" => Ok(Cut::Scaled),
        "centre" | "center" => Ok(Cut::Centre),
        _ => place().ok_or_else(|| "scaled, centre or X,Y is needed".into()),
    }
}

/// Treatment of the EXIF orientation.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Exif {
    /// Turned by the EXIF orientation, as most programs show them and OpenCV reads them.
    Upright,
    /// As stored.
    Stored,
}

/// Ratio of the matches that fit a rig for cropped images to those that fit a rig for scaled images, above which images
/// count as cropped.
const CLEARLY: f64 = 1.2;

/// A finished run.
pub(crate) struct Ran {
    pub(crate) rig: FoundRig,
    pub(crate) session: Session,
    source: Source,
    /// The first left image.
    frame: Frame,
}

impl SourceArgs {
    /// The files of each given rig.
    pub(crate) fn rigs(&self) -> &[Vec<PathBuf>] {
        &self.rigs.0
    }

    /// The request for a rig from these files, with the user's options.
    fn request(&self, source: &Source, files: Vec<PathBuf>) -> RigRequest {
        let given = self.lacks.unknowns();
        RigRequest {
            files,
            unknowns: Unknowns { cameras: given.cameras.or(source.cameras), ..given },
            focal_px: self.focal,
            cut: self.cut.unwrap_or_default(),
        }
    }

    /// Another rig of the images of a run.
    pub(crate) fn other_rig(&self, ran: &Ran, files: &[PathBuf]) -> Result<Meta> {
        let sizes = ran.session.set.meta.sizes();
        let name =
            || files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>().join(" ");
        let request = self.request(&ran.source, files.to_vec());
        let rig = request
            .find(&ran.source.rig, sizes, &ran.frame)
            .with_context(|| format!("the rig {}", name()))?;
        for note in &rig.notes {
            eprintln!("note: {}: {note}", name());
        }
        Ok(rig.meta)
    }

    /// Runs the calibrator over the images, from the first of the rigs.
    ///
    /// * `frames`: file for the matches as frames of the link.
    /// * `out`: folder for rig and matches as a data set.
    /// * `quiet`: of the pairs, prints only the skipped ones.
    pub(crate) fn run(
        &self,
        frames: Option<&Path>,
        out: Option<&Path>,
        quiet: bool,
    ) -> Result<Ran> {
        ensure!((0.1..=20.0).contains(&self.prior), "the prior must be from 0.1 to 20 degrees");
        let knock = self.knock.unwrap_or(0.0);
        ensure!(
            knock.abs() <= self.prior,
            "--knock {knock}: a turn of up to {} degrees is searched for (--prior)",
            self.prior
        );
        // A second Ctrl-C ends the command at once.
        let _ = ctrlc::set_handler(|| {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
            eprintln!("stopping after the pairs in progress; press again to end at once");
        });
        let wanted = Wanted {
            left: self.left_topic.clone(),
            right: self.right_topic.clone(),
            side_by_side: self.side_by_side,
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
        let request = self.request(&source, self.rigs.0.first().cloned().unwrap_or_default());
        let rig = self.upright(&request, &mut source, &first).context("the rig")?;
        let mut rig = if_cut(rig, &source, matcher)?;
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
        let selection = Selection { every: self.every, most: self.pairs.unwrap_or(usize::MAX) };
        let count = source.count.map(|n| n.div_ceil(self.every).min(selection.most));
        let mut live = Live::new(count, quiet);
        let request = Request { source: &source, rig: &rig, matcher, selection, frames, out };
        let session = session::run(&request, &STOP, &mut live);
        live.finish();
        let [frame, _] = first.frames;
        Ok(Ran { session: session?, rig, source, frame })
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
    if as_cut as f64 > CLEARLY * scaled as f64 {
        rig.meta = *cut;
        let [w, h] = rig.meta.sizes()[0];
        rig.notes = vec![format!(
            "the rig belongs to larger images: taken as cropped from their middle to {w} x {h} px, since {as_cut} matches fit so, and {scaled} as \
             scaled (--cut scaled, or --cut X,Y, says otherwise)"
        )];
    }
    Ok(rig)
}
