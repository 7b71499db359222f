//! The core's calibrator behind one interface for all capacities. All calls of it are here.

use pyo3::PyResult;
use stereo_selfcal::link::{Counters, Decoder, FrameHeader, FrameRefusal};
use stereo_selfcal::{
    ApplyError, Calibration, Calibrator, Cameras, Config, Correspondence, Extrinsics, Fused,
    Health, LensTracking, MotionError, PairError, PairReport, Proposal, RangeError, RangeReading,
    Rejection, RestoreError, State, Witnessed,
};

use crate::errors::{raised, value};
use crate::rig::Rig;

/// Matches of a pair that a calibrator can be made for.
const CAPACITIES: [usize; 6] = [64, 128, 256, 512, 1024, 2048];

/// How a calibrator is made.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Settings {
    pub(crate) rig: Rig,
    pub(crate) capacity: usize,
    pub(crate) preset: String,
    pub(crate) lens: String,
    pub(crate) max_correction_rad: Option<f64>,
    pub(crate) memory_pairs: Option<u32>,
    pub(crate) max_angular_rate: Option<f64>,
    pub(crate) automatic_apply: bool,
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
    pub(crate) state: State,
    pub(crate) generation: u32,
}

/// A calibrator with its decoder.
pub(crate) trait Engine: Send {
    /// Solves and fuses a pair; the batch is kept. An error that the caller has to correct leaves all as it was.
    fn fuse(
        &mut self,
        pair: &[Correspondence<f32>],
        rad_per_s: Option<f32>,
    ) -> Result<Outcome, PairError>;
    /// Solves a pair as the only one.
    fn alone(&mut self, pair: &[Correspondence<f32>]) -> Outcome;
    /// Solves and fuses each frame that ends in these bytes. An error leaves all as it was.
    fn feed(&mut self, bytes: &[u8]) -> Result<Vec<Outcome>, FrameRefusal>;
    fn counters(&self) -> Counters;
    fn apply(&mut self) -> Result<Calibration<f32>, ApplyError>;
    fn undo(&mut self) -> Result<Calibration<f32>, ApplyError>;
    fn reset(&mut self);
    fn set_frozen(&mut self, frozen: bool);
    fn is_frozen(&self) -> bool;
    fn state(&self) -> State;
    fn generation(&self) -> u32;
    fn in_use(&self) -> Option<Calibration<f32>>;
    fn health(&self) -> Option<Health<f32>>;
    fn save(&self) -> PyResult<Vec<u8>>;
    fn load(&mut self, record: &[u8]) -> Result<(), RestoreError>;
    fn push_range(&mut self, reading: &RangeReading<f32>) -> Result<Witnessed, RangeError>;
    fn push_motion(
        &mut self,
        tracked: &[[Correspondence<f32>; 2]],
    ) -> Result<Witnessed, MotionError>;
    fn confirm_factory_yaw(&mut self) -> bool;
}

/// Settings that are checked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plan {
    config: Config,
    cameras: Cameras<f32>,
    start: Extrinsics<f32>,
    capacity: usize,
}

impl Settings {
    /// Checks all settings.
    ///
    /// # Errors
    /// Names the argument.
    pub(crate) fn plan(&self) -> PyResult<Plan> {
        let Self { rig, capacity, .. } = self;
        if !CAPACITIES.contains(capacity) {
            return Err(value(format!("capacity: one of {CAPACITIES:?}, not {capacity}")));
        }
        let (config, cameras, start) = (self.config()?, rig.cameras()?, rig.start()?);
        Ok(Plan { config, cameras, start, capacity: *capacity })
    }

    fn config(&self) -> PyResult<Config> {
        let config = match &*self.preset {
            "robust" => Config::robust(),
            "paper" => Config::paper(),
            other => return Err(value(format!("preset: 'robust' or 'paper', not {other:?}"))),
        };
        let mut config = self.rig.informed(match &*self.lens {
            "report" => config,
            "given" => config.without_lens_prior(),
            "compensate" => config.with_lens_tracking(LensTracking::Compensate),
            other => {
                return Err(value(format!(
                    "lens: 'report', 'given' or 'compensate', not {other:?}"
                )));
            }
        })?;
        if let Some(rad) = self.max_correction_rad {
            let set = config.with_max_correction_rad(rad as f32);
            config = set.map_err(raised("max_correction_rad"))?;
        }
        if let Some(pairs) = self.memory_pairs {
            config = config.with_memory_pairs(pairs).map_err(raised("memory_pairs"))?;
        }
        if let Some(rate) = self.max_angular_rate {
            let set = config.with_max_angular_rate(rate as f32);
            config = set.map_err(raised("max_angular_rate"))?;
        }
        Ok(config.with_automatic_apply(self.automatic_apply))
    }
}

impl Plan {
    /// A new calibrator.
    pub(crate) fn engine(&self) -> Box<dyn Engine> {
        match self.capacity {
            64 => Box::new(Held::<64>::new(self)),
            128 => Box::new(Held::<128>::new(self)),
            256 => Box::new(Held::<256>::new(self)),
            512 => Box::new(Held::<512>::new(self)),
            1024 => Box::new(Held::<1024>::new(self)),
            _ => Box::new(Held::<2048>::new(self)),
        }
    }
}

/// A calibrator of one capacity, and room for what it was before a call.
struct Held<const N: usize> {
    calibrator: Box<Calibrator<f32, N>>,
    before: Box<Calibrator<f32, N>>,
    decoder: Decoder,
}

impl<const N: usize> Held<N> {
    fn new(plan: &Plan) -> Self {
        let mut calibrator = Box::new(Calibrator::new(plan.config));
        calibrator.set_cameras(plan.cameras);
        calibrator.set_factory(plan.start);
        Self { before: calibrator.clone(), calibrator, decoder: Decoder::new() }
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
        Outcome {
            frame,
            matches,
            report: solved.ok(),
            fused,
            proposal: calibrator.proposal(),
            health: calibrator.health(),
            state: calibrator.state(),
            generation: calibrator.generation(),
        }
    }
}

impl<const N: usize> Engine for Held<N> {
    fn fuse(
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

    fn alone(&mut self, pair: &[Correspondence<f32>]) -> Outcome {
        self.calibrator.reset();
        self.push(pair);
        self.take(pair.len(), None)
    }

    fn feed(&mut self, mut bytes: &[u8]) -> Result<Vec<Outcome>, FrameRefusal> {
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

    fn counters(&self) -> Counters {
        *self.decoder.counters()
    }

    fn apply(&mut self) -> Result<Calibration<f32>, ApplyError> {
        self.calibrator.apply()
    }

    fn undo(&mut self) -> Result<Calibration<f32>, ApplyError> {
        self.calibrator.undo()
    }

    fn reset(&mut self) {
        self.calibrator.reset();
    }

    fn set_frozen(&mut self, frozen: bool) {
        self.calibrator.set_frozen(frozen);
    }

    fn is_frozen(&self) -> bool {
        self.calibrator.is_frozen()
    }

    fn state(&self) -> State {
        self.calibrator.state()
    }

    fn generation(&self) -> u32 {
        self.calibrator.generation()
    }

    fn in_use(&self) -> Option<Calibration<f32>> {
        self.calibrator.calibration_in_use()
    }

    fn health(&self) -> Option<Health<f32>> {
        self.calibrator.health()
    }

    fn save(&self) -> PyResult<Vec<u8>> {
        let mut buffer = vec![0; Calibrator::<f32, N>::SNAPSHOT_BYTES];
        Ok(self.calibrator.snapshot(&mut buffer).map_err(value)?.to_vec())
    }

    fn load(&mut self, record: &[u8]) -> Result<(), RestoreError> {
        self.calibrator.restore(record)
    }

    fn push_range(&mut self, reading: &RangeReading<f32>) -> Result<Witnessed, RangeError> {
        self.calibrator.push_range(reading)
    }

    fn push_motion(
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

    fn confirm_factory_yaw(&mut self) -> bool {
        self.calibrator.confirm_factory_yaw()
    }
}
