//! Results of one pair of a run.

use std::fmt;

use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Extrinsics, Fused, Rejection, State};

use super::checked::Checked;
use super::estimate::Estimate;
use super::event_line::EventLine;
use super::refused::{CountByReason, WitnessCounts};

/// Outcome of one pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Fused, and how.
    Accepted(Fused),
    /// Solved, but not fused.
    Refused(Rejection),
    /// Not solved.
    Failed(Rejection),
}

/// One pair of a run, in `f64` for any scalar of the run.
#[derive(Debug, Clone, PartialEq)]
pub struct Step {
    /// Number of correspondences that the data set has for this pair.
    pub offered: usize,
    /// Number of correspondences in the batch: neither refused, nor left out of a full batch.
    pub taken: usize,
    /// Number of refused correspondences for each reason; empty if the run has not counted them.
    pub refused: CountByReason,
    /// Results of range readings and of tracked matches, if the run had any.
    pub witnessed: WitnessCounts,
    /// Outcome of the pair.
    pub verdict: Verdict,
    /// The solution of the pair in the run; `None` if it is not solved. The calibrator starts it from the running
    /// estimate if there is one; the published method starts it from the factory extrinsics.
    pub solved: Option<Solved>,
    /// The pair solved alone, if the run has noted it.
    pub alone: Option<Alone>,
    /// Error of the running estimate after this pair; `None` without an estimate or without a reference.
    pub running: Option<Deviation<f64>>,
    /// The running estimate after this pair.
    pub estimate: Option<Estimate>,
    /// Calibration in use and verdict after this pair, if the run has noted them.
    pub checked: Option<Checked>,
    /// The change of the calibrator with this pair, without a time; `None` if nothing has changed.
    pub event: Option<EventLine>,
}

/// One pair solved alone, from the factory extrinsics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alone {
    /// Its extrinsics; `None` if the pair is not solved, or not fused.
    pub extrinsics: Option<Extrinsics<f64>>,
    /// Error of the extrinsics; `None` without extrinsics or without a reference.
    pub error: Option<Deviation<f64>>,
}

/// The solution of one pair in the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Solved {
    /// Its extrinsics.
    pub extrinsics: Extrinsics<f64>,
    /// Error of the extrinsics; `None` without a reference.
    pub error: Option<Deviation<f64>>,
    /// Number of passes over the batch.
    pub passes: u16,
    /// RMS row offset of the screened correspondences at the start, px.
    pub rms_px_before: f64,
    /// RMS row offset of the same correspondences at the solution, px.
    pub rms_px_after: f64,
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
    /// Error of the pair: solved alone if the run has noted it, otherwise as solved in the run.
    pub fn pair_error(&self) -> Option<Deviation<f64>> {
        match self.alone {
            Some(alone) => alone.error,
            None => self.solved.and_then(|solved| solved.error),
        }
    }

    /// Estimate of the pair: solved alone if the run has noted it, otherwise as solved in the run.
    pub fn pair_extrinsics(&self) -> Option<Extrinsics<f64>> {
        match self.alone {
            Some(alone) => alone.extrinsics,
            None => self.solved.map(|solved| solved.extrinsics),
        }
    }

    /// State after this pair: of the calibrator, or of the estimate if the run has not noted it.
    pub fn state(&self) -> Option<State> {
        let estimate = self.estimate.map(|estimate| estimate.state);
        self.checked.map(|checked| checked.state).or(estimate)
    }

    /// Heading of the lines that `Display` writes. Row offsets and passes belong to the pair as solved in the run; the
    /// errors of the pair are [`Step::pair_error`].
    pub const HEADING: &str = "matches  rows px before>after  passes   pair e_t  e_theta deg   \
                               running e_t  e_theta deg   verdict";
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:>7}  ", self.taken)?;
        match &self.solved {
            Some(s) => write!(
                f,
                "{:>9.3} > {:>9.3}  {:>5}    ",
                s.rms_px_before, s.rms_px_after, s.passes,
            )?,
            None => write!(f, "{:>21}  {:>6}   ", "-", "-")?,
        }
        for (error, width) in [(self.pair_error(), 8), (self.running, 11)] {
            let degrees = |rad: f64| format!("{:.3}", rad.to_degrees());
            let [t, r] = error
                .map_or(["-".into(), "-".into()], |e| [e.translation, e.rotation].map(degrees));
            write!(f, "{t:>width$}  {r:>11}   ")?;
        }
        write!(f, "{}", self.verdict)?;
        if self.taken < self.offered {
            write!(f, " ({} of {} matches not taken)", self.offered - self.taken, self.offered)?;
        }
        Ok(())
    }
}
