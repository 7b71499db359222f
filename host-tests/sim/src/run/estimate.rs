//! The estimate of a run in `f64`.

use std::fmt;

use anyhow::Result;
use serde::Serialize;
use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::outcome::{Finding, LensEstimate, StandardDeviations, Vibration};
use stereo_selfcal::paper::FusedEstimate;
use stereo_selfcal::{Calibration, Extrinsics, Proposal, Reason, Reasons, Scalar, State};

use rigs::data::{Dataset, Meta, in_f64, rows};

/// A proposal in `f64`, for any scalar of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Proposed extrinsics.
    pub extrinsics: Extrinsics<f64>,
    /// Correction of the cameras that the extrinsics belong to.
    pub correction: LensCorrection<f64>,
    /// Reported standard deviations, rad, with the lens as given.
    pub sd: StandardDeviations<f64>,
    /// Reported standard deviations, rad, with the lens uncertain.
    pub sd_lens: StandardDeviations<f64>,
    /// Whether the pairs have determined the baseline direction.
    pub baseline_observed: bool,
    /// Lens errors that the pairs show; `None` without a lens prior.
    pub lens: Option<Lens>,
    /// Apparent yaw of the lens, rad.
    pub lens_yaw: Finding<f64>,
    /// Standard deviation of the yaw of the mount, with the lens uncertain, rad. The published method has no covariance,
    /// and it is `sd.rotation`.
    pub yaw_sd: f64,
    /// Motion of the rig about the estimate, rad RMS.
    pub vibration: Vibration<f64>,
    /// State of the calibrator.
    pub state: State,
    /// The strongest reason against the estimate that comes from the matches.
    pub doubt: Option<Reason>,
    /// Whether the axis of the rotation is noise, in the published method.
    pub axis_is_noise: bool,
}

/// [`LensEstimate`] in `f64`. Code outside the core cannot construct a `LensEstimate`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Lens {
    /// Relative error of the focal length, right minus left.
    pub focal: Finding<f64>,
    /// Error of the radial coefficient `k1`, right minus left.
    pub k1: Finding<f64>,
    /// Error of the radial coefficient `k1`, mean of both cameras.
    pub k1_mean: Finding<f64>,
    /// Error of the tangential coefficient `p1`, right minus left.
    pub p1: Finding<f64>,
    /// Error of the column of the principal point, right minus left, px.
    pub principal_x_px: Finding<f64>,
}

impl<T: Scalar> From<LensEstimate<T>> for Lens {
    fn from(lens: LensEstimate<T>) -> Self {
        Self {
            focal: finding(lens.focal),
            k1: finding(lens.k1),
            k1_mean: finding(lens.k1_mean),
            p1: finding(lens.p1),
            principal_x_px: finding(lens.principal_x_px),
        }
    }
}

impl Estimate {
    /// Conversion of a proposal.
    pub fn of<T: Scalar>(proposal: &Proposal<T>) -> Self {
        let yaw_sd = proposal.covariance_lens.m22.sqrt();
        let LensCorrection { focal, k1 } = proposal.correction;
        Self {
            extrinsics: in_f64(&proposal.extrinsics),
            correction: LensCorrection { focal: focal.to_f64(), k1: k1.to_f64() },
            sd: deviations(&proposal.sd),
            sd_lens: deviations(&proposal.sd_lens),
            baseline_observed: proposal.baseline_observed,
            lens: proposal.lens.map(Lens::from),
            lens_yaw: finding(proposal.lens_yaw),
            yaw_sd: yaw_sd.to_f64(),
            vibration: Vibration {
                rotation: proposal.vibration.rotation.to_f64(),
                baseline: proposal.vibration.baseline.to_f64(),
            },
            state: proposal.state,
            doubt: doubt(proposal.reasons()),
            axis_is_noise: false,
        }
    }

    /// Conversion of an estimate of the published method, which takes the lens models as exact.
    pub fn published<T: Scalar>(estimate: &FusedEstimate<T>) -> Self {
        let sd = deviations(&estimate.sd);
        Self {
            extrinsics: in_f64(&estimate.extrinsics),
            correction: LensCorrection::NONE,
            sd,
            sd_lens: sd,
            baseline_observed: true,
            lens: None,
            lens_yaw: Finding { value: 0.0, sd: 0.0 },
            yaw_sd: sd.rotation,
            vibration: Vibration::NONE,
            state: State::Locked,
            doubt: None,
            axis_is_noise: !estimate.axis_is_meaningful,
        }
    }

    /// Whether anything speaks against the estimate beyond its deviations.
    pub fn is_doubtful(&self) -> bool {
        self.doubt.is_some() || self.axis_is_noise
    }

    /// The extrinsics with the corrected cameras of a data set.
    ///
    /// # Errors
    /// If the cameras are not valid.
    pub fn calibration(&self, set: &Dataset) -> Result<Calibration<f64>> {
        set.meta.calibration(&self.extrinsics, &self.correction)
    }

    /// The rig `of` with the estimated extrinsics, the corrected cameras, and the apparent yaw of the lenses
    /// ([`Meta::LENS_YAW`]), unless it is exactly 0.
    pub fn rig(&self, of: &Meta) -> Meta {
        let r = rows(self.extrinsics.rotation().matrix());
        let t = self.extrinsics.translation().into_inner().into();
        let mut meta = Meta { r, t, ..of.corrected(&self.correction) };
        meta.other.remove(Meta::LENS_YAW);
        if self.lens_yaw.value != 0.0 {
            meta.other.insert(Meta::LENS_YAW.into(), self.lens_yaw.value.into());
        }
        meta
    }
}

/// The strongest of the reasons against an estimate that come from the matches.
pub fn doubt(reasons: Reasons) -> Option<Reason> {
    let doubts = [Reason::SecondMode, Reason::Biased, Reason::ImageHalves];
    doubts.into_iter().find(|reason| reasons.contains(*reason))
}

fn finding<T: Scalar>(found: Finding<T>) -> Finding<f64> {
    Finding { value: found.value.to_f64(), sd: found.sd.to_f64() }
}

/// A correction in words: `right focal length +0.098 %, k1 -0.00012`.
pub(crate) fn in_words(correction: &LensCorrection<f64>) -> String {
    let LensCorrection { focal, k1 } = correction;
    format!("right focal length {:+.3} %, k1 {k1:+.5}", 100.0 * focal)
}

fn deviations<T: Scalar>(sd: &StandardDeviations<T>) -> StandardDeviations<f64> {
    StandardDeviations { rotation: sd.rotation.to_f64(), translation: sd.translation.to_f64() }
}

impl fmt::Display for Estimate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.state)?;
        match self.doubt {
            None if self.axis_is_noise => f.write_str(", axis uncertain"),
            None => Ok(()),
            // With a lens prior the disagreement only widens the deviations.
            Some(Reason::ImageHalves) if self.lens.is_some() => {
                f.write_str(", image halves disagree")
            }
            Some(Reason::ImageHalves) => f.write_str(", image halves disagree: t held"),
            Some(Reason::Biased) => f.write_str(", image halves disagree: not applied"),
            Some(Reason::SecondMode) => f.write_str(", second crowd of matches: not applied"),
            Some(other) => write!(f, ", {other:?}"),
        }
    }
}
