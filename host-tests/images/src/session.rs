//! A run over a source: matches the pairs, passes the matches to the calibrator, and keeps the results.

use std::collections::HashMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use anyhow::{Context, Result, bail, ensure};
use rigs::data::{Dataset, Match, PairsFolder};
use sim::run::{Apply, Capacity, KeptPairs, RunLog, Running, Start, Step};
use sim::wire::Sender;
use stereo_selfcal::Config;

use crate::matcher::{Matcher, MatcherConfig};
use crate::moments::Shift;
use crate::pipeline::{self, Done, Selection, Skip};
use crate::rig::FoundRig;
use crate::source::{Frame, Source};

/// Number of pairs with left and right exchanged after which a run ends, if it has no other pairs.
const ENOUGH_EXCHANGED: usize = 5;

/// Inputs of a run.
#[derive(Debug)]
pub struct Request<'a> {
    /// Source of the pairs.
    pub source: &'a Source,
    /// Rig of the pairs.
    pub rig: &'a FoundRig,
    /// The matcher's parameters.
    pub matcher: MatcherConfig,
    /// Selected pairs.
    pub selection: Selection,
    /// File for the matches as frames of the link.
    pub frames: Option<&'a Path>,
    /// Folder for rig and matches as a data set, pair by pair.
    pub out: Option<&'a Path>,
}

/// Results of a run.
#[derive(Debug)]
pub struct Session {
    /// The rig, and the matches of all pairs, or of every 2nd, 4th, ... pair of a long run.
    pub set: Dataset,
    /// Number of pairs matched.
    pub pairs: usize,
    /// Log of the calibrator.
    pub log: RunLog,
    /// Number of skipped items by reason.
    pub skipped: HashMap<Skip, usize>,
    /// The pair with the most matches.
    pub best: Option<BestPair>,
    /// Number of matches that do not fit a frame of the link; 0 if no frames are written.
    pub left_out: usize,
    /// The shift between left and right images, if the test found that they show different moments.
    pub shift: Option<Shift>,
    /// Whether the user ended the run.
    pub stopped: bool,
}

/// The pair for the pictures.
#[derive(Debug)]
pub struct BestPair {
    /// Its number, from 0.
    pub number: usize,
    /// Its images.
    pub frames: [Frame; 2],
    /// Its matches.
    pub matches: Vec<Match>,
}

/// Listener to a run.
pub trait Listener {
    /// Called after each pair.
    fn pair(&mut self, number: usize, step: &Step);
    /// Called for each skipped item.
    fn skipped(&mut self, why: &str);
}

/// Writes pairs as frames of the link, if requested.
struct Frames(Option<(Sender, BufWriter<File>, PathBuf)>);

impl Frames {
    fn open(path: Option<&Path>, size: [u16; 2]) -> Result<Self> {
        let Some(path) = path else { return Ok(Self(None)) };
        ensure!(!path.exists(), "{} exists: nothing is overwritten", path.display());
        let file =
            File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self(Some((Sender::new(size, [0.0])?, BufWriter::new(file), path.to_owned()))))
    }

    /// Writes a pair; returns the number of matches that do not fit a frame.
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
/// * `stop`: ends the run and keeps the pairs done.
///
/// # Errors
/// If the rig is not valid, no pair can be matched, left and right are exchanged in all pairs, or a file cannot be
/// written.
pub fn run(
    request: &Request<'_>,
    stop: &AtomicBool,
    listener: &mut dyn Listener,
) -> Result<Session> {
    let Request { source, rig, selection, .. } = request;
    let meta = &rig.meta;
    let matcher = Matcher::of(meta, request.matcher)?;
    let mut run = Run::begin(request)?;
    pipeline::run(source, &matcher, meta.sizes(), *selection, stop, |done| match done {
        Done::Matched { frames, matched } => run.take(frames, matched.matches, listener),
        Done::Skipped { kind, why } => {
            *run.session.skipped.entry(kind).or_default() += 1;
            listener.skipped(&why);
            run.session.verdict_on_order()
        }
    })?;
    let mut session = run.end()?;
    session.stopped = stop.load(std::sync::atomic::Ordering::Relaxed);
    session.checked(&matcher, source)
}

/// A run in progress.
struct Run {
    running: Running,
    frames: Frames,
    /// Folder for the matches on arrival, so that an interrupted run loses none.
    out: Option<PathBuf>,
    /// The folder `out`, which is created with the first pair, so that a run without pairs leaves no folder.
    folder: Option<PairsFolder>,
    /// Pairs for the figures at the end.
    kept: KeptPairs,
    session: Session,
    /// Error that ended the run.
    failed: Option<anyhow::Error>,
}

impl Run {
    fn begin(request: &Request<'_>) -> Result<Self> {
        let meta = &request.rig.meta;
        // Guessed intrinsics give no depth, so that rows alone decide.
        let (start, config) = if request.rig.guessed {
            (Start::Guess, Config::robust().with_depth_limit_px(f32::INFINITY)?)
        } else {
            (Start::Calibration(meta.extrinsics::<f32>()?), Config::robust())
        };
        let running = Running::new(meta, config, start, Capacity::N2048, Apply::Never)?;
        let set = Dataset {
            name: request.source.name.clone(),
            meta: meta.clone(),
            pairs: Vec::new(),
            rigs: Vec::new(),
        };
        let session = Session {
            set,
            pairs: 0,
            log: running.log().clone(),
            skipped: HashMap::new(),
            best: None,
            left_out: 0,
            shift: None,
            stopped: false,
        };
        let frames = Frames::open(request.frames, [meta.width, meta.height])?;
        let out = request.out.map(Path::to_owned);
        let kept = KeptPairs::default();
        Ok(Self { running, frames, out, folder: None, kept, session, failed: None })
    }

    /// Takes the matches of the next pair. `Break` if they cannot be written.
    fn take(
        &mut self,
        frames: [Frame; 2],
        matches: Vec<Match>,
        listener: &mut dyn Listener,
    ) -> ControlFlow<()> {
        let number = self.session.pairs;
        if let Err(why) = self.write(number, &matches) {
            self.failed = Some(why);
            return ControlFlow::Break(());
        }
        if let Some(step) = self.running.push(&matches) {
            listener.pair(number, step);
        }
        self.kept.offer(&matches);
        self.session.pairs += 1;
        let best = self.session.best.as_ref();
        if best.is_none_or(|best| matches.len() > best.matches.len()) {
            self.session.best = Some(BestPair { number, frames, matches });
        }
        ControlFlow::Continue(())
    }

    fn write(&mut self, number: usize, matches: &[Match]) -> Result<()> {
        self.session.left_out += self.frames.write(number, matches)?;
        if let (Some(dir), None) = (&self.out, &self.folder) {
            self.folder = Some(PairsFolder::begin(dir, &self.session.set.meta)?);
        }
        self.folder.as_mut().map_or(Ok(()), |folder| folder.push(matches))
    }

    fn end(mut self) -> Result<Session> {
        self.frames.finish()?;
        if let Some(why) = self.failed {
            return Err(why);
        }
        self.session.log = self.running.log().clone();
        self.session.set.pairs = self.kept.into_pairs();
        Ok(self.session)
    }
}

impl Session {
    /// `Break` if no pair was matched, and left and right are exchanged in [`ENOUGH_EXCHANGED`] pairs.
    fn verdict_on_order(&self) -> ControlFlow<()> {
        let exchanged = self.count(Skip::Exchanged);
        let hopeless = self.pairs == 0 && exchanged >= ENOUGH_EXCHANGED;
        if hopeless { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Number of items skipped for a reason.
    pub fn count(&self, kind: Skip) -> usize {
        self.skipped.get(&kind).copied().unwrap_or(0)
    }

    /// The skipped items in words; may be empty.
    pub fn skipped_in_words(&self) -> String {
        let all = Skip::ALL.into_iter().map(|kind| (self.count(kind), kind.words()));
        let words = all.filter(|(count, _)| *count > 0).map(|(n, words)| format!("{n} {words}"));
        words.collect::<Vec<_>>().join(", ")
    }

    /// The session with the test for different moments.
    ///
    /// # Errors
    /// If no pair was matched.
    fn checked(mut self, matcher: &Matcher, source: &Source) -> Result<Self> {
        if self.pairs == 0 {
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
