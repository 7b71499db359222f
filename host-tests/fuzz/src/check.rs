//! Properties of the calibrator's output.

use nalgebra::Matrix3;
use stereo_selfcal::geometry::LensCorrection;
use stereo_selfcal::outcome::{Finding, LensEstimate};
use stereo_selfcal::{Extrinsics, FactoryCalibration, PairReport, Proposal, State, Verdict};

use super::Target;

pub(super) fn check_extrinsics(extrinsics: &Extrinsics<f32>) {
    let r = extrinsics.rotation().matrix();
    assert!((r.transpose() * r - Matrix3::identity()).amax() < 1e-5, "{r}");
    assert!((extrinsics.translation().norm() - 1.0).abs() < 1e-5);
}

pub(super) fn check_estimate(estimate: &Proposal<f32>) {
    check_extrinsics(&estimate.extrinsics);
    check_extrinsics(&estimate.applicable);
    check_correction(estimate.correction);
    check_correction(estimate.applicable_correction);
    for sd in [estimate.sd, estimate.sd_lens] {
        assert!(sd.rotation.is_finite() && sd.translation.is_finite(), "{estimate:?}");
    }
    for covariance in [estimate.covariance, estimate.covariance_lens] {
        assert!(covariance.iter().all(|c| c.is_finite()), "{estimate:?}");
        assert!(covariance.diagonal().iter().all(|c| *c > 0.0), "{estimate:?}");
    }
    for Finding { value, sd } in estimate.lens.as_ref().into_iter().flat_map(findings) {
        assert!(value.is_finite() && sd.is_finite() && sd >= 0.0, "{estimate:?}");
    }
}

fn findings(lens: &LensEstimate<f32>) -> [Finding<f32>; 5] {
    [lens.focal, lens.k1, lens.k1_mean, lens.p1, lens.principal_x_px]
}

fn check_correction(correction: LensCorrection<f32>) {
    assert!(correction.focal.is_finite() && correction.k1.is_finite(), "{correction:?}");
}

/// Checks that the extrinsics in use are valid, and that the left camera in use is as given.
pub(super) fn check_in_use(calibrator: &Target, factory: &FactoryCalibration<f32>) {
    let in_use = calibrator.in_use();
    check_extrinsics(&in_use.extrinsics);
    assert_eq!(in_use.cameras.left, factory.cameras.left);
}

/// Checks the calibrator after [`stereo_selfcal::Fused::LensCorrected`]: the estimate restarts with the corrected
/// cameras, and the batch keeps no ray of the old ones.
pub(super) fn check_begun_again(calibrator: &Target) {
    assert!(calibrator.proposal().is_none() && calibrator.details().is_none());
    assert_eq!(calibrator.state(), State::Acquiring);
    assert!(calibrator.batch().matches().is_empty());
}

/// Checks that a verdict has no number out of its range, and gives a reason where it forbids arming.
pub(super) fn check_verdict(verdict: &Verdict<f32>) {
    assert!(verdict.rows_px >= 0.0 && verdict.depth_px >= 0.0, "{verdict}");
    let shares = [verdict.coverage, verdict.image_coverage];
    assert!(shares.iter().all(|share| (0.0..=1.0).contains(share)), "{verdict}");
    assert!(verdict.may_arm || !verdict.reasons.is_empty(), "{verdict}");
    assert!(!verdict.may_arm || verdict.depth_ok, "{verdict}");
}

pub(super) fn check_report(report: &PairReport<f32>, most: u16) {
    check_extrinsics(&report.extrinsics);
    assert!(report.passes <= most && report.usable >= 12, "{report:?}");
    let numbers = [
        report.cost_before,
        report.cost_after,
        report.rms_px_before,
        report.rms_px_after,
        report.noise_px,
    ];
    assert!(numbers.iter().all(|x| x.is_finite() && *x >= 0.0), "{report:?}");
    assert!(report.information.matrix().iter().all(|x| x.is_finite()), "{report:?}");
}
