//! Replay: feeds a data set to the calibrator as on a controller.

use anyhow::{Result, bail};
use stereo_selfcal::depth::RangeReading;
use stereo_selfcal::outcome::Event;
use stereo_selfcal::paper::Settings;
use stereo_selfcal::{
    Calibrator, Cameras, Config, Extrinsics, FactoryCalibration, Outcome, Rejection, Scalar,
};
use strum::{Display, EnumMessage, EnumString, VariantArray};

use super::alone::PairSolver;
use super::estimate::Estimate;
use super::event_line::EventLine;
use super::factory::{self, Start};
use super::log::RunLog;
use super::published::Published;
use super::refused::{self, CountByReason, WitnessCounts};
use super::replayed::{Apply, Replayed};
use super::step::Step;
use rigs::data::ranges::{self, Ranges};
use rigs::data::tracked::{self, Track};
use rigs::data::{Dataset, Match, Meta, in_f64};

/// Capacity of a calibrator, correspondences a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Display, EnumMessage, EnumString, VariantArray)]
pub enum Capacity {
    /// The capacity on a vehicle.
    #[strum(serialize = "256")]
    N256,
    /// More than any pair of the shipped sets has.
    #[strum(serialize = "2048")]
    N2048,
}

/// Method of a run, with its parameters.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Method {
    /// The calibrator.
    Robust(Config),
    /// The published method.
    Paper(Settings),
}

impl From<Config> for Method {
    fn from(config: Config) -> Self {
        Self::Robust(config)
    }
}

impl From<Settings> for Method {
    fn from(settings: Settings) -> Self {
        Self::Paper(settings)
    }
}

/// Number type of a run. This crate compiles the estimator for both types. A generic run would be compiled again in
/// every crate that uses it.
pub trait ReplayScalar: Scalar {
    /// Constructor of a calibrator of a capacity. The calibrator selects matches from longer pairs.
    ///
    /// # Errors
    /// If the type has no such capacity.
    #[doc(hidden)]
    fn replayed(capacity: Capacity) -> Result<NewReplayed<Self>>;
}

/// Makes the calibrator of a run, and the solver of its pairs alone.
type NewReplayed<T> = fn(Method, &FactoryCalibration<T>) -> Box<dyn Replayed>;

impl ReplayScalar for f32 {
    fn replayed(capacity: Capacity) -> Result<NewReplayed<Self>> {
        Ok(match capacity {
            Capacity::N256 => boxed::<Self, 256>,
            Capacity::N2048 => boxed::<Self, 2048>,
        })
    }
}

impl ReplayScalar for f64 {
    fn replayed(capacity: Capacity) -> Result<NewReplayed<Self>> {
        match capacity {
            Capacity::N256 => {
                bail!("--capacity 256 is for --scalar f32, the number type of a vehicle")
            }
            Capacity::N2048 => Ok(boxed::<Self, 2048>),
        }
    }
}

/// The calibrator of a run, and the solver of its pairs alone.
#[derive(Debug)]
struct Solvers<T: Scalar, const N: usize> {
    calibrator: Box<Calibrator<T, N>>,
    /// The cameras before any correction.
    cameras: Cameras<T>,
    alone: PairSolver<T, N>,
    /// The last change of the calibrator.
    last: Event<T>,
}

fn boxed<T: Scalar, const N: usize>(
    method: Method,
    made: &FactoryCalibration<T>,
) -> Box<dyn Replayed> {
    match method {
        Method::Robust(config) => Box::new(Solvers::<T, N>::new(config, made)),
        Method::Paper(settings) => Box::new(Published::<T, N>::new(settings, made)),
    }
}

impl<T: Scalar, const N: usize> Solvers<T, N> {
    fn new(config: Config, made: &FactoryCalibration<T>) -> Self {
        let calibrator = Box::new(Calibrator::new(config, made));
        let alone = PairSolver::new(config, made);
        Self { calibrator, cameras: made.cameras, alone, last: Event::START }
    }

    /// Notes what has changed with the pair recorded last.
    fn note_event(&mut self, log: &mut RunLog) {
        let pair = u32::try_from(log.pairs()).unwrap_or(u32::MAX).saturating_sub(1);
        let (verdict, generation) =
            (self.calibrator.verdict(), self.calibrator.in_use().generation);
        if let Some(event) = self.last.next(0, pair, verdict, generation) {
            log.note_event(EventLine::of(&event, None));
            self.last = event;
        }
    }
}

impl<T: Scalar, const N: usize> Replayed for Solvers<T, N> {
    fn take(
        &mut self,
        pair: &[Match],
        with: (&[RangeReading<f64>], &[Track]),
        apply: Apply,
        log: &mut RunLog,
    ) {
        replay_pair((&mut self.calibrator, &self.cameras), pair, with, apply, log);
        self.note_event(log);
        log.note_alone(self.alone.solve(pair));
    }
}

/// A run in progress, which takes one pair at a time.
#[derive(Debug)]
pub struct Running {
    replayed: Box<dyn Replayed>,
    apply: Apply,
    ranges: Ranges,
    tracks: Vec<Vec<Track>>,
    log: RunLog,
}

impl Running {
    /// A run over pairs of a rig. The estimates are compared with the extrinsics of the rig, if it has any.
    ///
    /// # Errors
    /// If the rig is not valid, or the number type has no such capacity.
    pub fn new<T: ReplayScalar>(
        rig: &Meta,
        method: impl Into<Method>,
        start: Start<T>,
        capacity: Capacity,
        apply: Apply,
    ) -> Result<Self> {
        let factory = in_f64(&start.extrinsics());
        let replayed = T::replayed(capacity)?(method.into(), &factory::of(rig, start)?);
        let log = if rig.has_reference() {
            RunLog::new(rig.extrinsics()?, factory)
        } else {
            RunLog::without_reference(factory)
        };
        Ok(Self { replayed, apply, ranges: Ranges::new(), tracks: Vec::new(), log })
    }

    /// Solves and fuses the next pair, and returns its step.
    pub fn push(&mut self, pair: &[Match]) -> Option<&Step> {
        let number = self.log.pairs();
        let ranges = self.ranges.remove(&number).unwrap_or_default();
        let tracks = self.tracks.get(number).map(Vec::as_slice).unwrap_or_default();
        self.replayed.take(pair, (&ranges, tracks), self.apply, &mut self.log);
        self.log.steps().last()
    }

    /// The log so far.
    pub fn log(&self) -> &RunLog {
        &self.log
    }
}

/// The input of a run.
pub struct Feed<'a> {
    /// The rig of the pairs.
    pub rig: &'a Meta,
    /// True extrinsics of each pair; empty if the rig does not move.
    pub truths: Vec<Extrinsics<f64>>,
    /// The pairs, read one at a time.
    pub pairs: Box<dyn Iterator<Item = Result<Vec<Match>>> + 'a>,
    /// Readings of the distance to points of the pairs.
    pub ranges: Ranges,
    /// Matches tracked from each pair to a later one; may be empty.
    pub tracks: Vec<Vec<Track>>,
    /// Whether the log keeps only the latest pair.
    pub brief: bool,
}

impl<'a> Feed<'a> {
    /// The pairs of a data set, without range readings and tracks. The log keeps all pairs.
    ///
    /// # Errors
    /// If the rig of a pair is not valid.
    pub fn of(set: &'a Dataset) -> Result<Self> {
        let pairs = Box::new(set.pairs.iter().cloned().map(Ok));
        Ok(Self {
            rig: &set.meta,
            truths: set.truths()?,
            pairs,
            ranges: Ranges::new(),
            tracks: Vec::new(),
            brief: false,
        })
    }
}

/// Replays every pair of a data set, with [`Capacity::N2048`]; nothing is applied.
///
/// # Errors
/// If the data set's rig is not valid.
pub fn replay<T: ReplayScalar>(
    set: &Dataset,
    method: impl Into<Method>,
    start: Start<T>,
    each: impl FnMut(&Step),
) -> Result<RunLog> {
    replay_pairs(Feed::of(set)?, method, start, Capacity::N2048, Apply::Never, each)
}

/// Replays pairs through a calibrator.
///
/// * `apply`: when the estimate is applied.
/// * `each`: called after each pair.
///
/// # Errors
/// As [`Running::new`], or if a pair cannot be read.
pub fn replay_pairs<T: ReplayScalar>(
    feed: Feed<'_>,
    method: impl Into<Method>,
    start: Start<T>,
    capacity: Capacity,
    apply: Apply,
    mut each: impl FnMut(&Step),
) -> Result<RunLog> {
    let mut running = Running::new(feed.rig, method, start, capacity, apply)?;
    running.log = running.log.with_truths(feed.truths);
    (running.ranges, running.tracks) = (feed.ranges, feed.tracks);
    if feed.brief {
        running.log = running.log.briefly();
    }
    for pair in feed.pairs {
        if let Some(step) = running.push(&pair?) {
            each(step);
        }
    }
    Ok(running.log)
}

fn replay_pair<T: Scalar, const N: usize>(
    (calibrator, cameras): (&mut Calibrator<T, N>, &Cameras<T>),
    pair: &[Match],
    (readings, tracks): (&[RangeReading<f64>], &[Track]),
    apply: Apply,
    log: &mut RunLog,
) {
    let mut refused = CountByReason::new();
    for m in pair {
        if let Err(why) = calibrator.push(&m.correspondence()) {
            *refused.entry(refused::of_match(why)).or_default() += 1;
        }
    }
    let taken = calibrator.batch().matches().len();
    let Outcome { pair: report, fused } = calibrator.solve_pair();
    let outcome = report.map(|report| (report, fused)).ok_or(fused.err());
    let outcome = outcome.map_err(|why| why.unwrap_or(Rejection::NotBegun));
    let mut witnessed = WitnessCounts::default();
    for reading in readings {
        let outcome = calibrator.push_range(&ranges::in_scalar(reading));
        refused::note(&mut witnessed.ranges, &outcome);
    }
    if !tracks.is_empty() {
        let outcome = calibrator.push_motion(&tracked::rays_of(cameras, tracks));
        refused::note(&mut witnessed.motion, &outcome);
    }
    let details = calibrator.details();
    if apply == Apply::Each {
        // `apply` refuses an estimate that is not locked, or is in doubt; the verdict gives the reason.
        let _ = calibrator.apply();
    }
    let proposal = calibrator.proposal();
    log.record([pair.len(), taken], outcome, proposal.as_ref().map(Estimate::of));
    log.note_counts(refused, witnessed);
    log.check(calibrator, cameras, details.as_ref());
}
