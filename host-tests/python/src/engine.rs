//! The core's calibrator with its decoder, of any capacity, and what comes of a pair.

use pyo3::exceptions::PyOverflowError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stereo_selfcal::link::{Decoder, FrameHeader, FrameRefusal};
use stereo_selfcal::{
    Calibrator, Cause, Config, Correspondence, Fused, Health, LensTracking, MotionError, PairError,
    PairReport, Proposal, Rejection, RestoreError, State, Witnessed,
};

use crate::errors::{raised, value, wrong_type};
use crate::rig::Rig;

/// How a calibrator is made.
#[derive(Debug)]
pub(crate) struct Settings {
    pub(crate) rig: Rig,
    pub(crate) capacity: usize,
    pub(crate) preset: String,
    /// The other arguments, by name.
    pub(crate) options: Py<PyDict>,
}

/// All that comes of one pair.
#[derive(Debug, Clone)]
pub(crate) struct Outcome {
    /// The frame that it came in.
    pub(crate) frame: Option<FrameHeader>,
    /// Matches: all, those in the batch, those refused.
    pub(crate) matches: [usize; 3],
    pub(crate) report: Option<PairReport<f32>>,
    pub(crate) fused: Result<Fused, Rejection>,
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
        let config = match &*self.preset {
            "robust" => Config::robust(),
            "paper" => Config::paper(),
            other => return Err(value(format!("preset: 'robust' or 'paper', not {other:?}"))),
        };
        let mut config = self.rig.informed(config)?;
        for (name, given) in self.options.bind(py).iter() {
            config = with_option(config, name.extract()?, &given)?;
        }
        Engine::new(self.capacity, config, &self.rig)
    }
}

/// The configuration with an argument of `Calibrator`.
fn with_option(config: Config, name: &str, given: &Bound<'_, PyAny>) -> PyResult<Config> {
    if given.is_none() {
        return Ok(config);
    }
    let wrong = |why: PyErr| {
        let text = format!("{name}: {given}: {}", why.value(given.py()));
        if why.is_instance_of::<PyOverflowError>(given.py()) {
            value(text)
        } else {
            wrong_type(text)
        }
    };
    let number = || given.extract::<f64>().map(|x| x as f32).map_err(wrong);
    match name {
        "lens" => match given.extract().map_err(wrong)? {
            "report" => Ok(config),
            "given" => Ok(config.without_lens_prior()),
            "compensate" => Ok(config.with_lens_tracking(LensTracking::Compensate)),
            other => Err(value(format!("lens: 'report', 'given' or 'compensate', not {other:?}"))),
        },
        "max_correction_rad" => config.with_max_correction_rad(number()?).map_err(raised(name)),
        "max_angular_rate" => config.with_max_angular_rate(number()?).map_err(raised(name)),
        "memory_pairs" => {
            config.with_memory_pairs(given.extract().map_err(wrong)?).map_err(raised(name))
        }
        "automatic_apply" => Ok(config.with_automatic_apply(given.extract().map_err(wrong)?)),
        _ => Err(wrong_type(format!("{name}: no argument of Calibrator"))),
    }
}

/// A calibrator of one capacity, room for what it was before a call, and a decoder.
#[derive(Clone)]
pub(crate) struct Held<const N: usize> {
    pub(crate) calibrator: Box<Calibrator<f32, N>>,
    before: Box<Calibrator<f32, N>>,
    pub(crate) decoder: Decoder,
}

/// Defines the capacities.
macro_rules! capacities {
    ($($name:ident = $capacity:literal),+) => {
        /// A calibrator of any capacity.
        #[derive(Clone)]
        pub(crate) enum Engine { $($name(Held<$capacity>)),+ }

        impl Engine {
            /// # Errors
            /// Of another capacity.
            pub(crate) fn new(capacity: usize, config: Config, rig: &Rig) -> PyResult<Self> {
                match capacity {
                    $($capacity => Ok(Self::$name(Held::new(config, rig)?)),)+
                    _ => Err(value(format!("capacity: one of {:?}, not {capacity}", [$($capacity),+]))),
                }
            }
        }
    };
}
capacities!(N64 = 64, N128 = 128, N256 = 256, N512 = 512, N1024 = 1024, N2048 = 2048);

/// Evaluates a call for the calibrator of an engine, whatever its capacity.
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
    fn new(config: Config, rig: &Rig) -> PyResult<Self> {
        let mut calibrator = Box::new(Calibrator::new(config));
        calibrator.set_cameras(rig.cameras()?);
        calibrator.set_factory(rig.start()?);
        Ok(Self { before: calibrator.clone(), calibrator, decoder: Decoder::new() })
    }

    fn keep(&mut self) {
        self.before.clone_from(&self.calibrator);
    }

    fn back(&mut self) {
        self.calibrator.clone_from(&self.before);
    }

    fn push(&mut self, pair: &[Correspondence<f32>]) {
        self.calibrator.clear_pair();
        for correspondence in pair {
            // The batch counts those that it refuses.
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
        let fused = match solved {
            Ok(_) => calibrator.fuse().map_err(Rejection::Refused),
            Err(why) => Err(Rejection::Unsolved(why)),
        };
        let (health, state) = (calibrator.health(), calibrator.state());
        // Of a locked estimate that took the pair, the health has all that there is.
        let is_known = state == State::Locked && fused.is_ok();
        let of_health = health.as_ref().and_then(|health| health.cause);
        let cause = if is_known { of_health } else { calibrator.likely_cause().or(of_health) };
        Outcome {
            frame,
            matches,
            report: solved.ok(),
            fused,
            proposal: calibrator.proposal(),
            health,
            cause,
            state,
            generation: calibrator.generation(),
        }
    }

    /// Solves and fuses a pair; the batch is kept.
    ///
    /// # Errors
    /// What the caller has to correct; all is as it was.
    pub(crate) fn fuse(
        &mut self,
        pair: &[Correspondence<f32>],
        rad_per_s: Option<f32>,
    ) -> Result<Outcome, PairError> {
        self.keep();
        self.push(pair);
        if let Some(rate) = rad_per_s {
            self.calibrator.set_angular_rate(rate);
        }
        let outcome = self.take(pair.len(), None);
        match outcome.fused {
            // No pair of this rig: arguments are exchanged, or the rig is another one.
            Err(Rejection::Unsolved(why @ (PairError::Behind | PairError::Columns))) => {
                self.back();
                Err(why)
            }
            _ => Ok(outcome),
        }
    }

    /// Solves a pair as the only one.
    pub(crate) fn alone(&mut self, pair: &[Correspondence<f32>]) -> Outcome {
        self.calibrator.reset();
        self.push(pair);
        self.take(pair.len(), None)
    }

    /// Solves and fuses each frame that ends in these bytes.
    ///
    /// # Errors
    /// A frame of other images; all is as it was.
    pub(crate) fn feed(&mut self, mut bytes: &[u8]) -> Result<Vec<Outcome>, FrameRefusal> {
        self.keep();
        let decoder = self.decoder.clone();
        let mut outcomes = Vec::new();
        loop {
            match self.decoder.feed(&mut bytes, &mut *self.calibrator) {
                Ok(None) => return Ok(outcomes),
                Ok(Some(received)) => {
                    let header = received.header;
                    outcomes.push(self.take(header.count.into(), Some(header)));
                }
                Err(why) => {
                    self.back();
                    self.decoder = decoder;
                    return Err(why);
                }
            }
        }
    }

    /// The record of a firmware.
    pub(crate) fn save(&self) -> PyResult<Vec<u8>> {
        let record = self.calibrator.snapshot().map(Vec::from);
        record.ok_or_else(|| value("the calibrator has no cameras"))
    }

    /// Restores a record of [`Self::save`].
    ///
    /// # Errors
    /// All is as it was.
    pub(crate) fn load(&mut self, record: &[u8]) -> Result<(), RestoreError> {
        self.keep();
        self.calibrator.restore(record).inspect_err(|_| self.back())
    }

    /// Adds tracked matches; those without rays are left out.
    pub(crate) fn push_motion(
        &mut self,
        tracked: &[[Correspondence<f32>; 2]],
    ) -> Result<Witnessed, MotionError> {
        let cameras = *self.calibrator.cameras().ok_or(MotionError::NotLocked)?;
        let rays = |[before, after]: &[Correspondence<f32>; 2]| {
            Some([cameras.rays(before).ok()?, cameras.rays(after).ok()?])
        };
        let tracked: Vec<_> = tracked.iter().filter_map(rays).collect();
        self.calibrator.push_motion(&tracked)
    }
}
