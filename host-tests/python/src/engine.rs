//! The core's calibrator with its decoder, of any capacity, and the results of a pair.

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stereo_selfcal::depth::{MotionError, Tracks, Witnessed};
use stereo_selfcal::link::{Decoder, FrameHeader, FrameRefusal, Tracking};
use stereo_selfcal::{
    ApplyError, Calibrator, Cameras, Cause, Config, Correspondence, FactoryCalibration, Fused,
    Health, LensTracking, NoHealth, PairReport, Proposal, Rejection, RestoreError, State,
};

use crate::errors::{raised, value, wrong_type};
use crate::rig::Rig;

/// Arguments of a calibrator.
#[derive(Debug)]
pub(crate) struct Settings {
    pub(crate) rig: Rig,
    pub(crate) capacity: usize,
    pub(crate) preset: String,
    /// The other arguments, by name.
    pub(crate) options: Py<PyDict>,
}

/// All results of one pair.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    /// The frame of the pair.
    pub(crate) frame: Option<FrameHeader>,
    /// Numbers of matches: all, in the batch, refused.
    pub(crate) matches: [usize; 3],
    pub(crate) report: Option<PairReport<f32>>,
    pub(crate) fused: Result<Fused, Rejection>,
    /// Effect of the tracks that the frame shares with an earlier one; `None` if it shares none.
    pub(crate) motion: Option<Result<Witnessed, MotionError>>,
    pub(crate) proposal: Option<Proposal<f32>>,
    pub(crate) health: Option<Health<f32>>,
    pub(crate) cause: Option<Cause>,
    pub(crate) state: State,
    pub(crate) generation: u32,
}

impl Settings {
    /// A new calibrator.
    ///
    /// # Errors
    /// Names the argument.
    pub(crate) fn engine(&self, py: Python<'_>) -> PyResult<Engine> {
        let mut config = match &*self.preset {
            "robust" => Config::robust(),
            "paper" => Config::paper(),
            other => return Err(value(format!("preset: 'robust' or 'paper', not {other:?}"))),
        };
        let mut motion = false;
        for (name, given) in self.options.bind(py).iter() {
            match name.extract()? {
                "motion" => {
                    motion = given.extract().map_err(|why| wrong("motion", &given, &why))?;
                }
                name => config = with_option(config, name, &given)?,
            }
        }
        Engine::new(self.capacity, config, &self.rig.made()?, motion)
    }
}

/// An argument that is of another type, or out of the range of its type.
fn wrong(name: &str, given: &Bound<'_, PyAny>, why: &PyErr) -> PyErr {
    let text = format!("{name}: {given}: {}", why.value(given.py()));
    let is_number = why.is_instance_of::<PyOverflowError>(given.py());
    if is_number { value(text) } else { wrong_type(text) }
}

/// The configuration changed by an argument of `Calibrator`.
fn with_option(config: Config, name: &str, given: &Bound<'_, PyAny>) -> PyResult<Config> {
    if given.is_none() {
        return Ok(config);
    }
    let wrong = |why: PyErr| wrong(name, given, &why);
    let number = || given.extract::<f64>().map(|x| x as f32).map_err(wrong);
    match name {
        "lens" => match given.extract().map_err(wrong)? {
            "report" => Ok(config),
            "given" => Ok(config.without_lens_prior()),
            "compensate" => Ok(config.with_lens_tracking(LensTracking::Compensate)),
            other => Err(value(format!("lens: 'report', 'given' or 'compensate', not {other:?}"))),
        },
        "max_correction_rad" => config.with_max_correction_rad(number()?).map_err(raised(name)),
        "memory_pairs" => {
            config.with_memory_pairs(given.extract().map_err(wrong)?).map_err(raised(name))
        }
        _ => Err(wrong_type(format!("{name}: not an argument of Calibrator"))),
    }
}

/// A calibrator of one capacity, a copy of its state before a call, and a decoder.
#[derive(Clone)]
pub(crate) struct Held<const N: usize> {
    pub(crate) calibrator: Box<Calibrator<f32, N>>,
    /// The cameras as given.
    cameras: Cameras<f32>,
    before: Box<Calibrator<f32, N>>,
    pub(crate) decoder: Decoder,
    /// Tracks of the frames, if they are to tell motion.
    tracks: Option<Box<Tracks<f32, N>>>,
}

/// Defines the capacities.
macro_rules! capacities {
    ($($name:ident = $capacity:literal),+) => {
        /// A calibrator of any capacity.
        #[derive(Clone)]
        pub(crate) enum Engine { $($name(Held<$capacity>)),+ }

        impl Engine {
            /// # Errors
            /// If the capacity is not available.
            pub(crate) fn new(
                capacity: usize,
                config: Config,
                made: &FactoryCalibration<f32>,
                motion: bool,
            ) -> PyResult<Self> {
                match capacity {
                    $($capacity => Ok(Self::$name(Held::new(config, made, motion))),)+
                    _ => Err(value(format!("capacity: one of {:?}, not {capacity}", [$($capacity),+]))),
                }
            }
        }
    };
}
capacities!(N64 = 64, N128 = 128, N256 = 256, N512 = 512, N1024 = 1024, N2048 = 2048);

/// Evaluates a call for the calibrator of an engine, of any capacity.
macro_rules! each {
    ($engine:expr, $held:ident => $call:expr) => {
        match $engine {
            $crate::engine::Engine::N64($held) => $call,
            $crate::engine::Engine::N128($held) => $call,
            $crate::engine::Engine::N256($held) => $call,
            $crate::engine::Engine::N512($held) => $call,
            $crate::engine::Engine::N1024($held) => $call,
            $crate::engine::Engine::N2048($held) => $call,
        }
    };
}
pub(crate) use each;

impl<const N: usize> Held<N> {
    fn new(config: Config, made: &FactoryCalibration<f32>, motion: bool) -> Self {
        let calibrator = Box::new(Calibrator::new(config, made));
        let (cameras, before, decoder) = (made.cameras, calibrator.clone(), Decoder::new());
        Self { calibrator, cameras, before, decoder, tracks: motion.then(Box::default) }
    }

    fn keep(&mut self) {
        self.before.clone_from(&self.calibrator);
    }

    fn back(&mut self) {
        self.calibrator.clone_from(&self.before);
    }

    fn push(&mut self, pair: &[Correspondence<f32>]) {
        self.calibrator.discard_pair();
        for correspondence in pair {
            // The batch counts the matches that it refuses.
            let _ = self.calibrator.push(correspondence);
        }
    }

    /// Solves and fuses the batch.
    fn take(&mut self, offered: usize, frame: Option<FrameHeader>) -> Outcome {
        let calibrator = &mut self.calibrator;
        let batch = calibrator.batch();
        let refused = batch.refused().try_into().unwrap_or(usize::MAX);
        let matches = [offered, batch.pairs().len(), refused];
        let solved = calibrator.solve_pair();
        let tracks = self.tracks.as_deref_mut();
        let tracks = tracks.filter(|tracks| frame.is_some() && !tracks.quads().is_empty());
        let motion = tracks.map(|tracks| calibrator.push_witness(tracks));
        let health = calibrator.health();
        Outcome {
            frame,
            matches,
            report: solved.pair,
            fused: solved.fused,
            motion,
            proposal: calibrator.proposal(),
            cause: health.as_ref().map_or_else(NoHealth::cause, |health| health.cause),
            health: health.ok(),
            state: calibrator.state(),
            generation: calibrator.in_use().generation,
        }
    }

    /// Solves and fuses a pair; the batch is kept.
    ///
    /// # Errors
    /// The mistake of the caller; the state is unchanged.
    pub(crate) fn fuse(&mut self, pair: &[Correspondence<f32>]) -> Result<Outcome, Rejection> {
        self.keep();
        self.push(pair);
        let outcome = self.take(pair.len(), None);
        match outcome.fused {
            // The pair does not belong to this rig: arguments are exchanged, or the rig is another one.
            Err(why @ (Rejection::Behind | Rejection::Columns)) => {
                self.back();
                Err(why)
            }
            _ => Ok(outcome),
        }
    }

    /// Solves a pair alone.
    pub(crate) fn alone(&mut self, pair: &[Correspondence<f32>]) -> Outcome {
        self.calibrator.reset();
        self.push(pair);
        self.take(pair.len(), None)
    }

    /// Solves and fuses each frame that ends in these bytes.
    ///
    /// # Errors
    /// A frame of other images; the state is unchanged.
    pub(crate) fn feed(&mut self, mut bytes: &[u8]) -> Result<Vec<Outcome>, FrameRefusal> {
        self.keep();
        let before = (self.decoder.clone(), self.tracks.clone());
        let mut outcomes = Vec::new();
        loop {
            let tracks = self.tracks.as_deref_mut();
            let mut sink = Tracking { calibrator: &mut *self.calibrator, tracks };
            match self.decoder.feed(&mut bytes, &mut sink) {
                Ok(None) => return Ok(outcomes),
                Ok(Some(received)) => {
                    let header = received.header;
                    outcomes.push(self.take(header.count.into(), Some(header)));
                }
                Err(why) => {
                    self.back();
                    (self.decoder, self.tracks) = before;
                    return Err(why);
                }
            }
        }
    }

    /// Whether estimate and calibration in use are frozen; a record given to `load` may freeze them.
    pub(crate) fn is_frozen(&mut self) -> bool {
        // A frozen calibrator refuses to undo before any other reason.
        self.keep();
        self.before.undo() == Err(ApplyError::Frozen)
    }

    /// Restores a record of a firmware.
    ///
    /// # Errors
    /// The state is unchanged.
    pub(crate) fn load(&mut self, record: &[u8]) -> Result<(), RestoreError> {
        self.keep();
        self.calibrator.restore(record).inspect_err(|_| self.back())
    }

    /// Adds tracked matches; those without rays are left out.
    pub(crate) fn push_motion(
        &mut self,
        tracked: &[[Correspondence<f32>; 2]],
    ) -> Result<Witnessed, MotionError> {
        let cameras = &self.cameras;
        let rays = |[before, after]: &[Correspondence<f32>; 2]| {
            Some([cameras.rays(before).ok()?, cameras.rays(after).ok()?])
        };
        let tracked: Vec<_> = tracked.iter().filter_map(rays).collect();
        self.calibrator.push_witness(&tracked[..])
    }
}
