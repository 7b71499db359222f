//! Results of a run of the calibrator, pair by pair, against the truth of the data set.

use anyhow::{Result, bail};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::outcome::Details;
use stereo_selfcal::{Calibrator, Cameras, Extrinsics, Fused, PairReport, Rejection, Scalar};

use super::checked::Checked;
use super::estimate::Estimate;
use super::event_line::EventLine;
use super::refused::{CountByReason, WitnessCounts};
use super::step::{Alone, Solved, Step, Verdict};
use super::totals::Totals;
use rigs::data::in_f64;

/// Results of a run so far, and the truth that they are compared with.
#[derive(Debug, Clone)]
pub struct RunLog {
    /// True extrinsics of the latest pair; `None` without a known reference.
    truth: Option<Extrinsics<f64>>,
    /// True extrinsics of each pair; empty if the rig does not move.
    truths: Vec<Extrinsics<f64>>,
    factory: Extrinsics<f64>,
    /// All pairs, or the latest one if earlier ones are forgotten.
    steps: Vec<Step>,
    /// Whether `steps` keeps only the latest pair.
    brief: bool,
    /// Sums over the pairs that were removed from `steps`.
    forgotten: Totals,
    fused: Option<Estimate>,
}

impl RunLog {
    /// The log of a run that starts at `factory`, on data whose truth is `truth`.
    pub fn new(truth: Extrinsics<f64>, factory: Extrinsics<f64>) -> Self {
        Self { truth: Some(truth), ..Self::without_reference(factory) }
    }

    /// The log of a run on data without a reference: it has no errors.
    pub fn without_reference(factory: Extrinsics<f64>) -> Self {
        Self {
            truth: None,
            truths: Vec::new(),
            factory,
            steps: Vec::new(),
            brief: false,
            forgotten: Totals::default(),
            fused: None,
        }
    }

    /// The log with only the latest pair in [`RunLog::steps`], so that the memory does not grow with the run.
    pub fn briefly(self) -> Self {
        Self { brief: true, ..self }
    }

    fn error(&self, found: &Extrinsics<f64>) -> Option<Deviation<f64>> {
        self.truth.as_ref().map(|truth| Deviation::between(found, truth))
    }

    /// The log for a rig that moves: pair `i` and the estimate after it are compared with `truths[i]`. Pairs beyond the
    /// last truth are compared with the last truth.
    pub fn with_truths(self, truths: Vec<Extrinsics<f64>>) -> Self {
        Self { truths, ..self }
    }

    /// Records one pair, and returns its step.
    ///
    /// * `offered`, `taken`: numbers of correspondences in the data set and in the batch.
    /// * `outcome`: report of the solved pair and result of its fusion, or why the pair was not solved.
    /// * `fused`: the estimate after this pair.
    pub fn record<T: Scalar>(
        &mut self,
        [offered, taken]: [usize; 2],
        outcome: Result<(PairReport<T>, Result<Fused, Rejection>), Rejection>,
        fused: Option<Estimate>,
    ) -> &Step {
        if self.brief {
            self.steps.drain(..).for_each(|step| self.forgotten.add(&step));
        }
        let number = self.forgotten.pairs + self.steps.len();
        self.truth = self.truths.get(number).copied().or(self.truth);
        self.fused = fused;
        let running = self.fused.and_then(|f| self.error(&f.extrinsics));
        let (verdict, solved) = match outcome {
            Err(error) => (Verdict::Failed(error), None),
            Ok((report, fusing)) => {
                let verdict = fusing.map_or_else(Verdict::Refused, Verdict::Accepted);
                (verdict, Some(self.solved(&report)))
            }
        };
        self.steps.push(Step {
            offered,
            taken,
            refused: CountByReason::new(),
            witnessed: WitnessCounts::default(),
            verdict,
            solved,
            alone: None,
            running,
            estimate: self.fused,
            checked: None,
            event: None,
        });
        &self.steps[self.steps.len() - 1]
    }

    /// Number of pairs so far.
    pub(super) fn pairs(&self) -> usize {
        self.forgotten.pairs + self.steps.len()
    }

    /// Notes which correspondences of the pair recorded last were refused, and the results of its range readings and
    /// tracks.
    pub(super) fn note_counts(&mut self, refused: CountByReason, witnessed: WitnessCounts) {
        if let Some(step) = self.steps.last_mut() {
            (step.refused, step.witnessed) = (refused, witnessed);
        }
    }

    /// Notes the solution of the pair recorded last when it is solved alone; `None` if it has no solution.
    pub fn note_alone(&mut self, extrinsics: Option<Extrinsics<f64>>) {
        let error = extrinsics.and_then(|found| self.error(&found));
        if let Some(step) = self.steps.last_mut() {
            step.alone = Some(Alone { extrinsics, error });
        }
    }

    /// Notes the calibration in use and the verdict after the pair recorded last.
    ///
    /// * `given`: the calibrator's cameras before any correction.
    /// * `details`: of that pair, before the estimate was applied.
    pub fn check<T: Scalar, const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        given: &Cameras<T>,
        details: Option<&Details<T>>,
    ) {
        let checked = Checked::of(calibrator, given, details, self.truth.as_ref());
        if let Some(step) = self.steps.last_mut() {
            step.checked = Some(checked);
        }
    }

    /// Notes the change of the calibrator with the pair recorded last.
    pub(super) fn note_event(&mut self, event: EventLine) {
        if let Some(step) = self.steps.last_mut() {
            step.event = Some(event);
        }
    }

    fn solved<T: Scalar>(&self, report: &PairReport<T>) -> Solved {
        let extrinsics = in_f64(&report.extrinsics);
        Solved {
            extrinsics,
            error: self.error(&extrinsics),
            passes: report.passes,
            rms_px_before: report.rms_px_before.to_f64(),
            rms_px_after: report.rms_px_after.to_f64(),
        }
    }

    /// The pairs so far; only the latest pair if the log is brief ([`RunLog::briefly`]).
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Sums over all pairs so far.
    pub(super) fn totals(&self) -> Totals {
        let mut totals = self.forgotten.clone();
        self.steps.iter().for_each(|step| totals.add(step));
        totals
    }

    /// Extrinsics that the run starts from.
    pub fn factory(&self) -> &Extrinsics<f64> {
        &self.factory
    }

    /// True extrinsics of the latest pair; `None` without a known reference.
    pub fn truth(&self) -> Option<&Extrinsics<f64>> {
        self.truth.as_ref()
    }

    /// The estimate after the latest pair; `None` if there is no estimate then.
    pub fn fused(&self) -> Option<&Estimate> {
        self.fused.as_ref()
    }

    /// Whether the estimate has restarted with a corrected lens in any pair so far.
    pub fn has_begun_again(&self) -> bool {
        self.totals().began_again
    }

    /// The estimate at the end.
    ///
    /// # Errors
    /// Says why there is no estimate.
    pub fn try_fused(&self) -> Result<&Estimate> {
        match &self.fused {
            Some(fused) => Ok(fused),
            None if self.has_begun_again() => {
                bail!("the estimate restarted with a corrected lens, and no pair was fused since")
            }
            None => bail!("none of the {} pairs could be fused", self.totals().pairs),
        }
    }
}
