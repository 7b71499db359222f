//! A run over a source: matches into the calibrator, and all that comes out of it.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result, bail, ensure};
use host_tests::data::{Dataset, Match};
use host_tests::run::{Apply, CAPACITY, RunLog, Running, Step};
use host_tests::wire::Sender;
use stereo_selfcal::{Config, Extrinsics};

use crate::matcher::{Matcher, MatcherConfig};
use crate::moments::Shift;
use crate::pipeline::{self, Done, Selection, Skip};
use crate::rig::FoundRig;
use crate::source::{Frame, Source};

/// Pairs after which a source whose pairs are all exchanged is given up.
const ENOUGH_EXCHANGED: usize = 5;

/// What a run needs.
#[derive(Debug)]
pub struct Request<'a> {
    /// Where the pairs come from.
    pub source: &'a Source,
    /// Their rig.
    pub rig: &'a FoundRig,
    /// The matcher's parameters.
    pub matcher: MatcherConfig,
    /// Which pairs.
    pub selection: Selection,
    /// Where the frames of a matcher go.
    pub frames: Option<&'a Path>,
}

/// What a run came to.
#[derive(Debug)]
pub struct Session {
    /// The rig and the matches of all pairs.
    pub set: Dataset,
    /// What the calibrator made of them.
    pub log: RunLog,
    /// Skipped, by reason.
    pub skipped: HashMap<Skip, usize>,
    /// The pair with the most matches: its number, and its images.
    pub best: Option<(usize, [Frame; 2])>,
    /// Matches that no frame could carry.
    pub left_out: usize,
    /// Whether left and right are of different moments, if that was looked into.
    pub shift: Option<Shift>,
    /// Whether it was ended before the source was.
    pub stopped: bool,
}

/// Hears of a run as it goes.
pub trait Listener {
    /// After each pair.
    fn pair(&mut self, number: usize, step: &Step);
    /// Of what was skipped.
    fn skipped(&mut self, why: &str);
}

/// Encodes pairs as frames, if asked for.
struct Frames(Option<(Sender, BufWriter<File>, PathBuf)>);

impl Frames {
    fn open(path: Option<&Path>, size: [u16; 2]) -> Result<Self> {
        let Some(path) = path else { return Ok(Self(None)) };
        ensure!(!path.exists(), "{} exists: nothing is overwritten", path.display());
        let file =
            File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self(Some((Sender::new(size, [0.0])?, BufWriter::new(file), path.to_owned()))))
    }

    /// Matches that a frame could not carry.
    fn write(&mut self, sequence: usize, pair: &[Match]) -> Result<usize> {
        let Some((sender, file, path)) = &mut self.0 else { return Ok(0) };
        let (bytes, left_out) = sender.frame(u32::try_from(sequence)?, pair);
        let written = file.write_all(&bytes);
        written.with_context(|| format!("cannot write {}", path.display()))?;
        Ok(left_out)
    }

    fn finish(self) -> Result<()> {
        let Some((_, mut file, path)) = self.0 else { return Ok(()) };
        file.flush().with_context(|| format!("cannot write {}", path.display()))
    }
}

/// Runs the calibrator over a source, from the rig's extrinsics.
///
/// * `stop`: ends the run; what is done is kept.
///
/// # Errors
/// If the rig is not valid, nothing can be read, or left and right are exchanged throughout.
pub fn run(
    request: &Request<'_>,
    stop: &AtomicBool,
    listener: &mut dyn Listener,
) -> Result<Session> {
    let Request { source, rig, selection, .. } = request;
    let meta = &rig.meta;
    let size = [meta.width, meta.height];
    let matcher = Matcher::new(meta.cameras()?, &meta.extrinsics()?, request.matcher);
    let start: Extrinsics<f32> = meta.extrinsics()?;
    let mut running = Running::<f32, CAPACITY>::new(meta, Config::robust(), start, Apply::Never)?;
    let mut frames = Frames::open(request.frames, size)?;
    let mut session = Session {
        set: Dataset {
            name: source.name.clone(),
            meta: meta.clone(),
            pairs: Vec::new(),
            rigs: Vec::new(),
        },
        log: running.log().clone(),
        skipped: HashMap::new(),
        best: None,
        left_out: 0,
        shift: None,
        stopped: false,
    };
    let mut failed = None;
    let mut most = 0;
    pipeline::run(source, &matcher, size, *selection, stop, |done| {
        let (images, matched) = match done {
            Done::Matched { frames, matched } => (frames, matched),
            Done::Skipped { kind, why } => {
                *session.skipped.entry(kind).or_default() += 1;
                listener.skipped(&why);
                return session.verdict_on_order();
            }
        };
        let number = session.set.pairs.len();
        match frames.write(number, &matched.matches) {
            Ok(left_out) => session.left_out += left_out,
            Err(why) => {
                failed = Some(why);
                return ControlFlow::Break(());
            }
        }
        if matched.matches.len() > most || session.best.is_none() {
            most = matched.matches.len();
            session.best = Some((number, images));
        }
        if let Some(step) = running.push(&matched.matches) {
            listener.pair(number, step);
        }
        session.set.pairs.push(matched.matches);
        ControlFlow::Continue(())
    })?;
    frames.finish()?;
    if let Some(why) = failed {
        return Err(why);
    }
    session.log = running.log().clone();
    session.stopped = stop.load(std::sync::atomic::Ordering::Relaxed);
    session.checked(&matcher, source)
}

impl Session {
    /// `Break` if all pairs so far have left and right exchanged.
    fn verdict_on_order(&self) -> ControlFlow<()> {
        let exchanged = self.count(Skip::Exchanged);
        let hopeless = self.set.pairs.is_empty() && exchanged >= ENOUGH_EXCHANGED;
        if hopeless { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// How many were skipped for a reason.
    #[must_use]
    pub fn count(&self, kind: Skip) -> usize {
        self.skipped.get(&kind).copied().unwrap_or(0)
    }

    /// What was skipped, in words; empty if nothing.
    #[must_use]
    pub fn skipped_in_words(&self) -> String {
        let all = Skip::ALL.into_iter().map(|kind| (self.count(kind), kind.words()));
        let words = all.filter(|(count, _)| *count > 0).map(|(n, words)| format!("{n} {words}"));
        words.collect::<Vec<_>>().join(", ")
    }

    fn checked(mut self, matcher: &Matcher, source: &Source) -> Result<Self> {
        if self.set.pairs.is_empty() {
            if self.count(Skip::Exchanged) > 0 {
                bail!(
                    "left and right are exchanged in all {} pairs: most disparities are negative. Give the right \
                     images as left, or the rig of this order",
                    self.count(Skip::Exchanged)
                );
            }
            bail!("no pair of {} could be matched: {}", source.name, self.skipped_in_words());
        }
        if !self.stopped {
            self.shift = Shift::look(source, matcher)?;
        }
        Ok(self)
    }
}
