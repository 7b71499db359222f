//! The calibrator as a vehicle sees it after a pair: the calibration in use, and whether the vehicle may arm.

use std::fmt;

use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::outcome::Details;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Cause, Extrinsics, Lens, Reasons, Scalar, State, Verdict,
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
    /// The verdict on the calibration in use, before the estimate was applied.
    pub judged: Judged,
    /// Step of the grid that the rows of the pair lie on, px, stated or found: mean over its matches; 0 for continuous
    /// rows.
    pub grid_step_px: f64,
    /// The details over the pair, before the estimate was applied; `None` without an estimate or a match that fits it.
    pub details: Option<Checks>,
}

/// The core's [`Verdict`] in `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "each answers a question of its own")]
pub struct Judged {
    /// Row offset of the calibration in use beyond that of the pair's own pose, px RMS.
    pub rows_px: f64,
    /// Expected error of the disparities with the calibration in use, px RMS.
    pub depth_px: f64,
    /// Share of the matches that fit the calibration in use, among those that fit the pair's own pose.
    pub coverage: f64,
    /// Share of the image with matches that fit the pair's own pose.
    pub image_coverage: f64,
    /// Whether `rows_px` is within its limit.
    pub rows_ok: bool,
    /// Whether `depth_px` is within its limit.
    pub depth_ok: bool,
    /// Answer to an arming check.
    pub may_arm: bool,
    /// Whether applying the estimate is worthwhile.
    pub should_apply: bool,
    /// Reasons not to rely on the calibration in use.
    pub reasons: Reasons,
    /// The likeliest mistake in the rig file or the matcher; `None` if pairs show none.
    pub cause: Option<Cause>,
}

impl Judged {
    pub(super) fn of<T: Scalar>(verdict: &Verdict<T>) -> Self {
        Self {
            rows_px: verdict.rows_px.to_f64(),
            depth_px: verdict.depth_px.to_f64(),
            coverage: verdict.coverage.to_f64(),
            image_coverage: verdict.image_coverage.to_f64(),
            rows_ok: verdict.rows_ok,
            depth_ok: verdict.depth_ok,
            may_arm: verdict.may_arm,
            should_apply: verdict.should_apply,
            reasons: verdict.reasons,
            cause: verdict.cause,
        }
    }
}

impl fmt::Display for Judged {
    /// Writes `rows 0.4 px, depth 1.0 px, coverage 0.96: may arm`, as the core does.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows_px, depth_px, coverage, may_arm, .. } = self;
        let arming = if *may_arm { "may arm" } else { "must not arm" };
        write!(f, "rows {rows_px:.1} px, depth {depth_px:.1} px, coverage {coverage:.2}: {arming}")
    }
}

/// The parts of [`Details`] that a run records, in `f64`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checks {
    /// Expected error of the yaw in use, rad ([`Details::yaw`]): the error of depth is `Z^2 / b` times this.
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
    /// * `details`: of the last pair, before the estimate was applied.
    /// * `truth`: truth of the pair, if known.
    pub fn of<T: Scalar, const N: usize>(
        calibrator: &Calibrator<T, N>,
        given: &Cameras<T>,
        details: Option<&Details<T>>,
        truth: Option<&Extrinsics<f64>>,
    ) -> Self {
        let in_use = in_f64(&calibrator.in_use().extrinsics);
        let error = truth.map(|truth| Deviation::between(&in_use, truth));
        let checks = |details: &Details<T>| Checks {
            yaw_sd: details.yaw.to_f64(),
            fit: details.fit_proposed,
            in_use_px: details.in_use_px.to_f64(),
            proposed_px: details.proposed_px.to_f64(),
        };
        Self {
            state: calibrator.state(),
            in_use,
            correction: correction(given, calibrator),
            error,
            judged: Judged::of(calibrator.verdict()),
            grid_step_px: mean_grid_step(calibrator),
            details: details.map(checks),
        }
    }

    /// Whether the vehicle may arm.
    pub fn is_armed(&self) -> bool {
        self.judged.may_arm
    }

    /// Reasons against arming or against the estimate, then the likely cause, in words; may be empty.
    pub fn reasons(&self) -> Vec<String> {
        let Judged { reasons, cause, .. } = self.judged;
        let reasons = reasons.iter().map(|reason| reason.to_string());
        reasons.chain(cause.map(|cause| format!("likely cause: {cause}"))).collect()
    }
}

fn mean_grid_step<T: Scalar, const N: usize>(calibrator: &Calibrator<T, N>) -> f64 {
    let pairs = calibrator.batch().matches();
    let sum: f64 = pairs.iter().map(|pair| pair.grid_step().to_f64()).sum();
    // A batch has at most 2^14 matches.
    let count = u32::try_from(pairs.len()).unwrap_or(u32::MAX);
    sum / f64::from(count.max(1))
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
