//! The calibrator as a vehicle sees it after a pair: the calibration in use, and whether the vehicle may arm.

use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Band, Calibrator, Camera, Cameras, Cause, Extrinsics, Health, Lens, Reasons, Scalar, State,
};

use rigs::data::in_f64;

/// State of the calibrator after a pair, in `f64` for any scalar of the run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checked {
    /// State of the calibrator.
    pub state: State,
    /// Extrinsics in use, after an attempt to apply the estimate if the run applies it.
    pub in_use: Extrinsics<f64>,
    /// Correction of the cameras that the extrinsics in use belong to.
    pub correction: LensCorrection<f64>,
    /// Error of the extrinsics in use, rad; `None` without a reference.
    pub error: Option<Deviation<f64>>,
    /// The likeliest mistake in the rig file or the matcher, after the pair; `None` if pairs show none.
    pub cause: Option<Cause>,
    /// The health over the pair, before the estimate was applied; `None` if the calibrator has no health to report.
    pub health: Option<Checks>,
}

/// The parts of [`Health`] that a run records, in `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checks {
    /// Answer to an arming check.
    pub may_arm: bool,
    /// Reasons not to rely on the estimate.
    pub reasons: Reasons,
    /// Rating of the calibration in use.
    pub band: Band,
    /// Expected error of the yaw in use, rad ([`Health::yaw`]): the error of depth is `Z^2 / b` times this.
    pub yaw_sd: f64,
    /// Matches that fit the estimate.
    pub fit: u32,
    /// RMS row offset with the calibration in use, px.
    pub in_use_px: f64,
    /// RMS row offset with the estimate, px.
    pub proposed_px: f64,
}

impl Checked {
    /// The report of a calibrator.
    ///
    /// * `given`: the calibrator's cameras before any correction.
    /// * `health`: the health over the last pair, before the estimate was applied.
    /// * `truth`: truth of the pair, if known.
    pub fn of<T: Scalar, const N: usize>(
        calibrator: &Calibrator<T, N>,
        given: &Cameras<T>,
        health: Option<&Health<T>>,
        truth: Option<&Extrinsics<f64>>,
    ) -> Self {
        let in_use = in_f64(&calibrator.in_use().extrinsics);
        let error = truth.map(|truth| Deviation::between(&in_use, truth));
        let checks = |health: &Health<T>| Checks {
            may_arm: health.may_arm(),
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

    /// Whether the health permits arming.
    pub fn is_armed(&self) -> bool {
        self.health.is_some_and(|health| health.may_arm)
    }

    /// Reasons against arming or against the estimate, then the likely cause, in words; may be empty.
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

/// Difference of the right camera in use from the given one; exactly zero if the cameras in use are the given ones.
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
