//! The proposal of the calibrator in `f64`.

use std::fmt;

use stereo_selfcal::{Doubt, Extrinsics, Proposal, Scalar, StandardDeviations, State};

use crate::data::in_f64;

/// A proposal in `f64`, whatever the scalar of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Proposed extrinsics.
    pub extrinsics: Extrinsics<f64>,
    /// Reported standard deviations, rad.
    pub sd: StandardDeviations<f64>,
    /// State of the calibrator.
    pub state: State,
    /// Doubt about the estimate.
    pub doubt: Option<Doubt>,
    /// Whether pairs have determined the baseline direction.
    pub baseline_observed: bool,
}

impl Estimate {
    /// Conversion of a proposal.
    #[must_use]
    pub fn of<T: Scalar>(proposal: &Proposal<T>) -> Self {
        Self {
            extrinsics: in_f64(&proposal.extrinsics),
            sd: StandardDeviations {
                rotation: proposal.sd.rotation.to_f64(),
                translation: proposal.sd.translation.to_f64(),
            },
            state: proposal.state,
            doubt: proposal.doubt,
            baseline_observed: proposal.baseline_observed,
        }
    }
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.state)?;
        match self.doubt {
            None => Ok(()),
            Some(Doubt::Baseline) => f.write_str(", image halves disagree: t held"),
            Some(Doubt::Everything) => f.write_str(", image halves disagree: not applied"),
            Some(Doubt::Axis) => f.write_str(", axis uncertain"),
            Some(other) => write!(f, ", {other:?}"),
        }
    }
}
