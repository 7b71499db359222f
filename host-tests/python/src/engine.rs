//! The core's calibrator of any capacity, and the results of a pair.

use stereo_selfcal::batch::RayPair;
use stereo_selfcal::depth::{MotionError, Tracks, Witnessed};
use stereo_selfcal::link::{Decoder, FrameHeader, FrameRefusal, Tracking};
use stereo_selfcal::outcome::Details;
use stereo_selfcal::{
    Calibrator, Cameras, Config, Correspondence, FactoryCalibration, Fused, PairReport, Proposal,
    Rejection, State, Verdict,
};

/// All results of one pair.
#[derive(Debug)]
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
    pub(crate) details: Option<Details<f32>>,
    pub(crate) verdict: Verdict<f32>,
    /// Step of the grid that the rows lie on, px, stated or found: mean over the matches.
    pub(crate) grid_step: f32,
    pub(crate) state: State,
    pub(crate) generation: u32,
}

/// A calibrator of one capacity, and the receiver of its frames.
#[derive(Debug, Clone)]
pub(crate) struct Held<const N: usize> {
    pub(crate) calibrator: Box<Calibrator<f32, N>>,
    /// The cameras of the factory calibration.
    cameras: Cameras<f32>,
    pub(crate) decoder: Decoder,
    /// Tracks of the frames, if they are to tell motion.
    tracks: Option<Box<Tracks<f32, N>>>,
}

/// Defines the capacities.
macro_rules! capacities {
    ($($name:ident = $capacity:literal),+) => {
        /// A calibrator of any capacity.
        #[derive(Debug, Clone)]
        pub(crate) enum Engine { $($name(Held<$capacity>)),+ }

        impl Engine {
            pub(crate) const CAPACITIES: &[i64] = &[$($capacity),+];

            /// `None` if the capacity is not available.
            pub(crate) fn new(
                capacity: i64, config: Config, made: &FactoryCalibration<f32>, motion: bool,
            ) -> Option<Self> {
                match capacity {
                    $($capacity => Some(Self::$name(Held::new(config, made, motion))),)+
                    _ => None,
                }
            }
        }
    };
}
capacities!(N64 = 64, N256 = 256, N1024 = 1024, N2048 = 2048);

/// Evaluates a call for the calibrator of an engine, of any capacity.
macro_rules! each {
    ($engine:expr, $held:ident => $call:expr) => {
        match $engine {
            $crate::engine::Engine::N64($held) => $call,
            $crate::engine::Engine::N256($held) => $call,
            $crate::engine::Engine::N1024($held) => $call,
            $crate::engine::Engine::N2048($held) => $call,
        }
    };
}
pub(crate) use each;

fn mean_grid_step<const N: usize>(calibrator: &Calibrator<f32, N>) -> f32 {
    let pairs = calibrator.batch().matches();
    // A batch has at most 2^14 matches.
    let count = u16::try_from(pairs.len()).unwrap_or(u16::MAX);
    pairs.iter().map(RayPair::grid_step).sum::<f32>() / f32::from(count.max(1))
}

impl<const N: usize> Held<N> {
    fn new(config: Config, made: &FactoryCalibration<f32>, motion: bool) -> Self {
        let calibrator = Box::new(Calibrator::new(config, made));
        let tracks = motion.then(Box::default);
        Self { calibrator, cameras: made.cameras, decoder: Decoder::new(), tracks }
    }

    /// Calls the calibrator; an error leaves it as it was.
    pub(crate) fn attempt<T, E>(
        &mut self,
        call: impl FnOnce(&mut Self) -> Result<T, E>,
    ) -> Result<T, E> {
        let before = self.clone();
        call(self).inspect_err(|_| *self = before)
    }

    /// Solves and fuses the batch.
    fn take(&mut self, offered: usize, frame: Option<FrameHeader>) -> Outcome {
        let calibrator = &mut self.calibrator;
        let batch = calibrator.batch();
        let refused = batch.refused().try_into().unwrap_or(usize::MAX);
        let matches = [offered, batch.matches().len(), refused];
        let solved = calibrator.solve_pair();
        let tracks = self.tracks.as_deref_mut();
        let tracks = tracks.filter(|tracks| frame.is_some() && !tracks.quads().is_empty());
        let motion = tracks.map(|tracks| calibrator.push_tracks(tracks));
        Outcome {
            frame,
            matches,
            report: solved.pair,
            fused: solved.fused,
            motion,
            proposal: calibrator.proposal(),
            details: calibrator.details(),
            verdict: *calibrator.verdict(),
            grid_step: mean_grid_step(calibrator),
            state: calibrator.state(),
            generation: calibrator.in_use().generation,
        }
    }

    /// Solves and fuses a pair.
    pub(crate) fn fuse(&mut self, pair: &[Correspondence<f32>]) -> Outcome {
        self.calibrator.discard_pair();
        for correspondence in pair {
            // The batch counts the matches that it refuses.
            let _ = self.calibrator.push(correspondence);
        }
        self.take(pair.len(), None)
    }

    /// Solves and fuses each frame that ends in these bytes.
    ///
    /// # Errors
    /// A frame of other images; the state is unchanged.
    pub(crate) fn feed(&mut self, mut bytes: &[u8]) -> Result<Vec<Outcome>, FrameRefusal> {
        self.attempt(|held| {
            let mut outcomes = Vec::new();
            loop {
                let tracks = held.tracks.as_deref_mut();
                let mut sink = Tracking { calibrator: &mut *held.calibrator, tracks };
                let Some(received) = held.decoder.feed(&mut bytes, &mut sink)? else {
                    return Ok(outcomes);
                };
                let header = received.header;
                outcomes.push(held.take(header.count.into(), Some(header)));
            }
        })
    }

    /// Adds tracked matches; those without rays are left out.
    pub(crate) fn push_motion(
        &mut self,
        [before, after]: &[Vec<Correspondence<f32>>; 2],
    ) -> Result<Witnessed, MotionError> {
        let cameras = &self.cameras;
        let rays = |(before, after)| Some([cameras.rays(before).ok()?, cameras.rays(after).ok()?]);
        let tracked: Vec<_> = before.iter().zip(after).filter_map(rays).collect();
        self.calibrator.push_motion(&tracked)
    }
}
