//! What a run of the calibrator came to, pair by pair, against the truth of the data set.

use std::fmt;

use anyhow::{Result, bail};
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Extrinsics, Fused, Health, PairError, PairReport, Proposal, Refusal, Scalar, Stop,
};

use super::checked::Checked;
use super::estimate::Estimate;
use super::refused::CountByReason;
use super::totals::Totals;
use crate::data::in_f64;

/// Outcome of one pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Fused: how.
    Accepted(Fused),
    /// Solved, but not fused.
    Refused(Refusal),
    /// Not solved.
    Failed(PairError),
}

/// One pair of a run, in `f64` whatever the scalar of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Correspondences the data set has for this pair.
    pub offered: usize,
    /// Correspondences that the calibrator took.
    pub taken: usize,
    /// Correspondences refused by reason, where the run has noted it.
    pub refused: CountByReason,
    /// Its outcome.
    pub verdict: Verdict,
    /// The solved pair; the robust preset tracks it from the running estimate.
    pub solved: Option<Solved>,
    /// The pair solved alone, where the run has noted it.
    pub alone: Option<Alone>,
    /// Error of the running estimate after this pair.
    pub running: Option<Deviation<f64>>,
    /// The running estimate after this pair.
    pub estimate: Option<Estimate>,
    /// What a vehicle knows after this pair, where the run has noted it.
    pub checked: Option<Checked>,
}

/// One pair solved alone, from the factory extrinsics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alone {
    /// Its extrinsics; `None` if it is not solved, or not fused.
    pub extrinsics: Option<Extrinsics<f64>>,
    /// Their error.
    pub error: Option<Deviation<f64>>,
}

/// The solution of one pair in the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// Its extrinsics.
    pub extrinsics: Extrinsics<f64>,
    /// Their error; `None` without a reference.
    pub error: Option<Deviation<f64>>,
    /// Passes taken.
    pub passes: u16,
    /// Whether the limit of passes was reached.
    pub at_pass_limit: bool,
    /// RMS row offset of the screened correspondences at the start, px.
    pub rms_px_before: f64,
    /// The same at the solution, px.
    pub rms_px_after: f64,
}

/// A run being evaluated.
#[derive(Debug, Clone)]
pub struct RunLog {
    /// True extrinsics of the latest pair; `None` where no reference is known.
    truth: Option<Extrinsics<f64>>,
    /// True extrinsics of each pair; empty where the rig does not move.
    truths: Vec<Extrinsics<f64>>,
    factory: Extrinsics<f64>,
    /// All pairs, or the latest where earlier ones are forgotten.
    steps: Vec<Step>,
    /// Whether only the latest pair is kept.
    brief: bool,
    /// Pairs no longer in `steps`.
    forgotten: Totals,
    fused: Option<Estimate>,
}

impl RunLog {
    /// The log of a run that starts at `factory`, on data whose truth is `truth`.
    #[must_use]
    pub fn new(truth: Extrinsics<f64>, factory: Extrinsics<f64>) -> Self {
        Self { truth: Some(truth), ..Self::without_reference(factory) }
    }

    /// The log of a run on data without a reference: it has no errors.
    #[must_use]
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

    /// The same log with only the latest pair in [`RunLog::steps`], so that a run may be of any length.
    #[must_use]
    pub fn briefly(self) -> Self {
        Self { brief: true, ..self }
    }

    fn error(&self, found: &Extrinsics<f64>) -> Option<Deviation<f64>> {
        self.truth.as_ref().map(|truth| Deviation::between(found, truth))
    }

    /// The same for a rig that moves: pair `i`, and the estimate after it, against `truths[i]`, pairs
    /// beyond the last against the last.
    #[must_use]
    pub fn with_truths(self, truths: Vec<Extrinsics<f64>>) -> Self {
        Self { truths, ..self }
    }

    /// Records one pair.
    ///
    /// * `offered`, `taken`: correspondences in the data set and in the batch.
    /// * `outcome`: what solving and fusing returned.
    /// * `fused`: the estimate after this pair.
    pub fn record<T: Scalar>(
        &mut self,
        [offered, taken]: [usize; 2],
        outcome: Result<(PairReport<T>, Result<Fused, Refusal>), PairError>,
        fused: Option<&Proposal<T>>,
    ) -> &Step {
        if self.brief {
            self.steps.drain(..).for_each(|step| self.forgotten.add(&step));
        }
        let number = self.forgotten.pairs + self.steps.len();
        self.truth = self.truths.get(number).copied().or(self.truth);
        self.fused = fused.map(Estimate::of);
        let running = self.fused.and_then(|f| self.error(&f.extrinsics));
        let (verdict, solved) = match outcome {
            Err(error) => (Verdict::Failed(error), None),
            Ok((report, fusing)) => {
                let verdict = fusing.map_or_else(Verdict::Refused, Verdict::Accepted);
                (verdict, Some(self.solved(&report)))
            }
        };
        let estimate = self.fused;
        let (alone, checked) = (None, None);
        self.steps.push(Step {
            offered,
            taken,
            refused: CountByReason::new(),
            verdict,
            solved,
            alone,
            running,
            estimate,
            checked,
        });
        &self.steps[self.steps.len() - 1]
    }

    /// Notes which correspondences of the pair recorded last were refused.
    pub fn note_refused(&mut self, refused: CountByReason) {
        if let Some(step) = self.steps.last_mut() {
            step.refused = refused;
        }
    }

    /// Notes what the pair recorded last comes to alone.
    pub fn note_alone(&mut self, extrinsics: Option<Extrinsics<f64>>) {
        let error = extrinsics.and_then(|found| self.error(&found));
        if let Some(step) = self.steps.last_mut() {
            step.alone = Some(Alone { extrinsics, error });
        }
    }

    /// Notes what a vehicle knows after the pair recorded last.
    ///
    /// * `health`: over that pair, before the estimate was applied.
    pub fn check<T: Scalar, const N: usize>(
        &mut self,
        calibrator: &Calibrator<T, N>,
        health: Option<&Health<T>>,
    ) {
        let checked = Checked::of(calibrator, health, self.truth.as_ref());
        if let Some(step) = self.steps.last_mut() {
            step.checked = Some(checked);
        }
    }

    fn solved<T: Scalar>(&self, report: &PairReport<T>) -> Solved {
        let extrinsics = in_f64(&report.extrinsics);
        Solved {
            extrinsics,
            error: self.error(&extrinsics),
            passes: report.passes,
            at_pass_limit: report.stop == Stop::PassesSpent,
            rms_px_before: report.rms_px_before.to_f64(),
            rms_px_after: report.rms_px_after.to_f64(),
        }
    }

    /// The pairs so far; the latest of a brief log.
    #[must_use]
    pub fn steps(&self) -> &[Step] {
        &self.steps
    }

    /// Sums over all pairs so far.
    pub(super) fn totals(&self) -> Totals {
        let mut totals = self.forgotten.clone();
        self.steps.iter().for_each(|step| totals.add(step));
        totals
    }

    /// Where the run started.
    #[must_use]
    pub fn factory(&self) -> &Extrinsics<f64> {
        &self.factory
    }

    /// True extrinsics of the latest pair; `None` where no reference is known.
    #[must_use]
    pub fn truth(&self) -> Option<&Extrinsics<f64>> {
        self.truth.as_ref()
    }

    /// The estimate so far.
    #[must_use]
    pub fn fused(&self) -> Option<&Estimate> {
        self.fused.as_ref()
    }

    /// Whether the estimate has begun again with a corrected lens.
    #[must_use]
    pub fn has_begun_again(&self) -> bool {
        self.totals().began_again
    }

    /// The estimate at the end.
    ///
    /// # Errors
    /// Says why there is none.
    pub fn try_fused(&self) -> Result<&Estimate> {
        match &self.fused {
            Some(fused) => Ok(fused),
            None if self.has_begun_again() => {
                bail!("the estimate began again with a corrected lens, and no pair was fused since")
            }
            None => bail!("none of the {} pairs could be fused", self.totals().pairs),
        }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Accepted(Fused::Added) => f.write_str("fused"),
            Self::Accepted(Fused::Repeated) => f.write_str("same scene again"),
            Self::Accepted(Fused::KeptApart) => f.write_str("kept apart"),
            Self::Accepted(Fused::Renewed) => f.write_str("fused, older pairs dropped"),
            Self::Accepted(Fused::TookOver) => f.write_str("the pairs kept apart took over"),
            Self::Accepted(other) => other.fmt(f),
            Self::Refused(why) => write!(f, "refused: {why}"),
            Self::Failed(why) => write!(f, "not solved: {why}"),
        }
    }
}

impl Step {
    /// Error of the pair: alone, where the run has noted it, otherwise as solved in the run.
    #[must_use]
    pub fn pair_error(&self) -> Option<Deviation<f64>> {
        match self.alone {
            Some(alone) => alone.error,
            None => self.solved.and_then(|solved| solved.error),
        }
    }

    /// Estimate of the pair: alone, where the run has noted it, otherwise as solved in the run.
    #[must_use]
    pub fn pair_extrinsics(&self) -> Option<Extrinsics<f64>> {
        match self.alone {
            Some(alone) => alone.extrinsics,
            None => self.solved.map(|solved| solved.extrinsics),
        }
    }

    /// Heading over the lines of [`Step`]'s `Display`: px and passes are those of the run, the pair's errors
    /// those of [`Step::pair_error`]. Passes end in `+` where the limit cut them off.
    pub const HEADING: &str = "matches  rows px before>after  passes   pair e_t  e_theta deg   \
                               running e_t  e_theta deg   verdict";
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:>7}  ", self.taken)?;
        match &self.solved {
            Some(s) => write!(
                f,
                "{:>9.3} > {:>9.3}  {:>5}{}   ",
                s.rms_px_before,
                s.rms_px_after,
                s.passes,
                if s.at_pass_limit { '+' } else { ' ' },
            )?,
            None => write!(f, "{:>21}  {:>6}   ", "-", "-")?,
        }
        match &self.pair_error() {
            Some(e) => write!(
                f,
                "{:>8.3}  {:>11.3}   ",
                e.translation.to_degrees(),
                e.rotation.to_degrees()
            )?,
            None => write!(f, "{:>8}  {:>11}   ", "-", "-")?,
        }
        match &self.running {
            Some(e) => write!(
                f,
                "{:>11.3}  {:>11.3}   ",
                e.translation.to_degrees(),
                e.rotation.to_degrees()
            )?,
            None => write!(f, "{:>11}  {:>11}   ", "-", "-")?,
        }
        write!(f, "{}", self.verdict)?;
        if self.taken < self.offered {
            write!(f, " ({} of {} matches not taken)", self.offered - self.taken, self.offered)?;
        }
        Ok(())
    }
}
