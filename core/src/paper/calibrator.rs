//! Facade of the published method: it takes pairs and returns extrinsics.

use super::{Central, FusedEstimate, HuberSolver, MeanDirection, Settings, gate};
use crate::batch::correspondence::Correspondence;
use crate::batch::{Batch, Pushed};
use crate::error::{PushError, Rejection};
use crate::geometry::cameras::Cameras;
use crate::geometry::extrinsics::Extrinsics;
use crate::outcome::pair_report::{Fused, Outcome, PairReport};
use crate::scalar::Scalar;

/// The published method: one stereo rig, up to `N` correspondences per pair.
///
/// Each pair is solved from the start extrinsics, and all pairs have the same weight in the mean. The only defence
/// against outliers is the Huber weight. [`crate::Calibrator`] has everything that a vehicle needs beyond: a verdict, a
/// calibration in use, records and witnesses.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::paper::{FusedEstimate, PaperCalibrator, Settings};
/// use stereo_selfcal::{Cameras, Correspondence, Extrinsics};
///
/// /// Returns `R*`, `t*` over some pairs.
/// fn estimate(
///     cameras: Cameras<f32>,
///     pairs: &[Vec<Correspondence<f32>>],
/// ) -> Option<FusedEstimate<f32>> {
///     let start = Extrinsics::SIDE_BY_SIDE;
///     let mut paper = PaperCalibrator::<f32, 256>::new(Settings::DEFAULT, cameras, start);
///     for pair in pairs {
///         let outcome = paper.take_pair(pair.iter().copied());
///         // A pair that is not fused leaves the estimate as it is.
///         log(&outcome);
///     }
///     paper.estimate()
/// }
/// # fn log(_: &dyn core::fmt::Display) {}
/// ```
#[derive(Debug, Clone)]
pub struct PaperCalibrator<T: Scalar, const N: usize> {
    settings: Settings,
    cameras: Cameras<T>,
    start: Extrinsics<T>,
    batch: Batch<T, N>,
    step: Step<T>,
    mean: MeanDirection<T>,
}

/// Progress of the pair in the batch.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "there is no heap to box it on")]
enum Step<T: Scalar> {
    /// Matches arrive.
    Collecting,
    /// The solver takes passes.
    Solving(HuberSolver<T>),
    /// The pair has an outcome.
    Ended,
}

impl<T: Scalar, const N: usize> PaperCalibrator<T, N> {
    /// Returns a calibrator without pairs.
    ///
    /// * `start`: extrinsics that each pair is solved from, and that the correction limit is measured from.
    #[must_use]
    #[inline(always)]
    pub const fn new(settings: Settings, cameras: Cameras<T>, start: Extrinsics<T>) -> Self {
        let mean = MeanDirection::new(settings.angle);
        Self { settings, cameras, start, batch: Batch::new(), step: Step::Collecting, mean }
    }

    /// Offers one correspondence to the batch; the first one after the end of a pair begins a new batch.
    ///
    /// # Errors
    /// [`PushError::Busy`]: a pair is being solved; nothing changes. Any other [`PushError`]: the correspondence is not
    /// in the batch, and [`Batch::refused`] counts it.
    pub fn push(&mut self, correspondence: &Correspondence<T>) -> Result<Pushed, PushError> {
        match self.step {
            Step::Collecting => {}
            Step::Ended => self.discard_pair(),
            Step::Solving(_) => return Err(PushError::Busy),
        }
        self.batch.push(&self.cameras, correspondence)
    }

    /// Takes one stereo pair: pushes its correspondences into a new batch, solves the pair and fuses the result.
    /// [`Batch::refused`] counts the refused correspondences. A pair that was being solved is abandoned.
    pub fn take_pair(
        &mut self,
        correspondences: impl IntoIterator<Item = Correspondence<T>>,
    ) -> Outcome<T> {
        self.discard_pair();
        for correspondence in correspondences {
            let _ = self.batch.push(&self.cameras, &correspondence);
        }
        self.solve_pair()
    }

    /// Solves the batch and fuses the result in one call: calls [`Self::advance_pair`] until the pair has ended.
    pub fn solve_pair(&mut self) -> Outcome<T> {
        // The solver ends by itself after `max_passes`; the evaluation follows.
        for _ in 0..=self.settings.max_passes {
            if let Some(outcome) = self.advance_pair() {
                return outcome;
            }
        }
        self.end(Err(Rejection::NotBegun))
    }

    /// Takes one pass of the pair; returns the outcome once the pair has ended. The first pass begins the pair with the
    /// correspondences pushed so far; the last one evaluates the solution, and the pair is fused. A rejected pair leaves
    /// the estimate unchanged.
    pub fn advance_pair(&mut self) -> Option<Outcome<T>> {
        if matches!(self.step, Step::Ended) {
            // A pair that has ended is not solved again.
            self.discard_pair();
        }
        let matches = self.batch.matches();
        match &mut self.step {
            Step::Solving(solver) if solver.is_done() => {
                let report = solver.report(matches);
                Some(self.end(report))
            }
            Step::Solving(solver) => {
                solver.advance(matches);
                None
            }
            Step::Collecting | Step::Ended => {
                let focal = self.cameras.mean_focal();
                match HuberSolver::begin(&self.settings, focal, &self.start, matches) {
                    Ok(solver) => {
                        self.step = Step::Solving(solver);
                        None
                    }
                    Err(why) => Some(self.end(Err(why))),
                }
            }
        }
    }

    /// Ends the pair, and fuses it if it has a solution.
    fn end(&mut self, report: Result<PairReport<T>, Rejection>) -> Outcome<T> {
        self.step = Step::Ended;
        let fused = report.and_then(|report| self.fuse(&report));
        Outcome { pair: report.ok(), fused }
    }

    /// Adds a pair to the mean.
    ///
    /// # Errors
    /// [`Rejection::TooUncertain`], [`Rejection::CorrectionLimit`]; the estimate is unchanged.
    fn fuse(&mut self, report: &PairReport<T>) -> Result<Fused, Rejection> {
        gate::admit(&self.settings, &self.start, report)?;
        // A copy takes the pair first, because the mean of pairs within the limit may exceed the limit.
        let mut mean = self.mean.clone();
        mean.add(report);
        if let Some(estimate) = mean.estimate() {
            gate::limit(&self.settings, &self.start, &estimate.extrinsics)?;
        }
        self.mean = mean;
        Ok(Fused::Added)
    }

    /// Abandons the pair and empties the batch.
    pub fn discard_pair(&mut self) {
        self.step = Step::Collecting;
        self.batch.clear();
    }

    /// Forgets the batch and all pairs.
    pub fn reset(&mut self) {
        self.discard_pair();
        // Assigned from a constant, because a value made here would pass through the stack.
        self.mean = match self.settings.angle {
            Central::Mean => const { MeanDirection::new(Central::Mean) },
            Central::Median => const { MeanDirection::new(Central::Median) },
        };
    }

    /// Returns the estimate over all fused pairs. `None` before the first pair, if the directions cancel, or if the
    /// mean cannot be rectified.
    pub fn estimate(&self) -> Option<FusedEstimate<T>> {
        self.mean.estimate()
    }

    /// Returns the batch that is being collected or solved, or the batch of the last pair.
    pub fn batch(&self) -> &Batch<T, N> {
        &self.batch
    }

    /// Returns whether the lengths are within their capacities. The C library checks this in each call.
    #[doc(hidden)]
    pub fn has_valid_lengths(&self) -> bool {
        self.batch.is_within()
    }
}
