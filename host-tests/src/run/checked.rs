//! What a vehicle knows after a pair: what is in use, and whether it may arm.

use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Band, Calibrator, Camera, Cameras, Cause, Extrinsics, Health, Lens, Reasons, Scalar, State,
};

use crate::data::in_f64;

/// State of the calibrator after a pair, in `f64` whatever the scalar of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checked {
    /// State of the calibrator.
    pub state: State,
    /// Extrinsics in use, after the estimate was applied, if it was.
    pub in_use: Extrinsics<f64>,
    /// Correction of the cameras that they belong to.
    pub correction: LensCorrection<f64>,
    /// Error of the extrinsics in use; `None` without a reference.
    pub error: Option<Deviation<f64>>,
    /// The likeliest mistake in rig file or matcher, after the pair.
    pub cause: Option<Cause>,
    /// The health over the pair, before the estimate was applied; `None` where there is none.
    pub health: Option<Checks>,
}

/// A health in `f64`, as far as it is not in the estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checks {
    /// Reasons not to rely on it; they answer an arming check.
    pub reasons: Reasons,
    /// Verdict on what was in use.
    pub band: Band,
    /// Deviation of the yaw in use, rad: depth is off by `Z^2 / b` times this.
    pub yaw_sd: f64,
    /// Matches that fit the estimate.
    pub fit: u32,
    /// RMS row offset of what was in use, px.
    pub in_use_px: f64,
    /// RMS row offset of the estimate, px.
    pub proposed_px: f64,
}

impl Checked {
    /// What a calibrator says.
    ///
    /// * `given`: its cameras as given.
    /// * `truth`: that of the pair, where it is known.
    #[must_use]
    pub fn of<T: Scalar, const N: usize>(
        calibrator: &Calibrator<T, N>,
        given: &Cameras<T>,
        health: Option<&Health<T>>,
        truth: Option<&Extrinsics<f64>>,
    ) -> Self {
        let in_use = in_f64(&calibrator.in_use().extrinsics);
        let error = truth.map(|truth| Deviation::between(&in_use, truth));
        let checks = |health: &Health<T>| Checks {
            reasons: health.reasons,
            band: health.band,
            yaw_sd: health.yaw.to_f64(),
            fit: health.fit_proposed,
            in_use_px: health.in_use_px.to_f64(),
            proposed_px: health.proposed_px.to_f64(),
        };
        let correction = correction(given, calibrator);
        let cause = calibrator.health().map_or_else(|none| none.cause(), |health| health.cause);
        let state = calibrator.state();
        Self { state, in_use, correction, error, cause, health: health.map(checks) }
    }

    /// Whether the health says yes to arming.
    #[must_use]
    pub fn is_armed(&self) -> bool {
        self.health.is_some_and(|health| health.reasons.may_arm())
    }

    /// What speaks against arming, or against the estimate; nothing where all is well.
    #[must_use]
    pub fn reasons(&self) -> Vec<String> {
        let mut all: Vec<_> = match self.health {
            Some(Checks { reasons, .. }) => {
                reasons.iter().map(|reason| reason.to_string()).collect()
            }
            None => vec!["no estimate, or no match that fits it".into()],
        };
        all.extend(self.cause.map(|cause| format!("likely cause: {cause}")));
        all
    }
}

/// What the cameras in use have beyond the given ones: nothing, to the bit, where they are as given.
fn correction<T: Scalar, const N: usize>(
    given: &Cameras<T>,
    calibrator: &Calibrator<T, N>,
) -> LensCorrection<f64> {
    let used = calibrator.in_use();
    let [given, used] = [&given.right, &used.cameras.right];
    let focal = |camera: &Camera<T>| camera.intrinsics().focal[0].to_f64();
    LensCorrection { focal: focal(used) / focal(given) - 1.0, k1: k1(used) - k1(given) }
}

fn k1<T: Scalar>(camera: &Camera<T>) -> f64 {
    match camera.lens() {
        Lens::Pinhole => 0.0,
        Lens::RadialTangential(lens) => lens.coefficients()[0].to_f64(),
        Lens::Fisheye(lens) => lens.coefficients()[0].to_f64(),
        Lens::Rational(lens) => lens.coefficients()[0].to_f64(),
    }
}
