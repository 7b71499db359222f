//! The proposal of the calibrator in `f64`.

use std::fmt;

use serde::Serialize;
use stereo_selfcal::{Doubt, Extrinsics, Finding, Proposal, Scalar, StandardDeviations, State};

use crate::data::in_f64;

/// A proposal in `f64`, whatever the scalar of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Proposed extrinsics.
    pub extrinsics: Extrinsics<f64>,
    /// Reported standard deviations, rad, with the lens as given.
    pub sd: StandardDeviations<f64>,
    /// The same with the lens uncertain.
    pub sd_lens: StandardDeviations<f64>,
    /// Whether the baseline direction is observed.
    pub baseline_observed: bool,
    /// What the pairs show of the lens.
    pub lens: Option<Lens>,
    /// State of the calibrator.
    pub state: State,
    /// Doubt about the estimate.
    pub doubt: Option<Doubt>,
}

/// Errors of the given lens models, right camera less left one, but for the mean.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Lens {
    /// Focal length, relative.
    pub focal: Value,
    /// Radial coefficient.
    pub k1: Value,
    /// Radial coefficient, mean of both cameras.
    pub k1_mean: Value,
    /// Tangential coefficient.
    pub p1: Value,
    /// Principal column, px.
    pub principal_x_px: Value,
}

/// A parameter with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Value {
    /// Estimate.
    pub value: f64,
    /// Standard deviation.
    pub sd: f64,
}

impl Value {
    fn of<T: Scalar>(found: &Finding<T>) -> Self {
        Self { value: found.value.to_f64(), sd: found.sd.to_f64() }
    }
}

impl Estimate {
    /// Conversion of a proposal.
    #[must_use]
    pub fn of<T: Scalar>(proposal: &Proposal<T>) -> Self {
        Self {
            extrinsics: in_f64(&proposal.extrinsics),
            sd: deviations(&proposal.sd),
            sd_lens: deviations(&proposal.sd_lens),
            baseline_observed: proposal.baseline_observed,
            lens: proposal.lens.as_ref().map(|lens| Lens {
                focal: Value::of(&lens.focal),
                k1: Value::of(&lens.k1),
                k1_mean: Value::of(&lens.k1_mean),
                p1: Value::of(&lens.p1),
                principal_x_px: Value::of(&lens.principal_x_px),
            }),
            state: proposal.state,
            doubt: proposal.doubt,
        }
    }
}

fn deviations<T: Scalar>(sd: &StandardDeviations<T>) -> StandardDeviations<f64> {
    StandardDeviations { rotation: sd.rotation.to_f64(), translation: sd.translation.to_f64() }
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.state)?;
        match self.doubt {
            None => Ok(()),
            // With a lens prior the disagreement only widens the deviations.
            Some(Doubt::Baseline | Doubt::Everything) if self.lens.is_some() => {
                f.write_str(", image halves disagree")
            }
            Some(Doubt::Baseline) => f.write_str(", image halves disagree: t held"),
            Some(Doubt::Everything) => f.write_str(", image halves disagree: not applied"),
            Some(Doubt::Axis) => f.write_str(", axis uncertain"),
            Some(other) => write!(f, ", {other:?}"),
        }
    }
}
