//! One pair in the published method: its stop, its report, and its solution pass by pass.

use super::{published, with};
use crate::api::scene::{cameras, correspondences, rig};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::outcome::Stop;
use stereo_selfcal::paper::{HuberSolver, Settings};
use stereo_selfcal::{Correspondence, Extrinsics, PairReport, PushError, Rejection, Scalar};

const ROTATION: [f64; 3] = [3.0, -2.5, 4.0];
const BASELINE: [f64; 2] = [4.0, -3.0];

fn solved<T: Scalar>(noise_px: f64) -> PairReport<T> {
    let mut calibrator = published::<T>();
    for c in correspondences(&rig(ROTATION, BASELINE), 256, noise_px, 1) {
        calibrator.push(&c).unwrap();
    }
    calibrator.solve_pair().pair.unwrap()
}

#[test]
fn exact_correspondences_give_the_exact_rig() {
    let report = solved::<f64>(0.0);
    let error = Deviation::between(&report.extrinsics, &rig(ROTATION, BASELINE));
    assert!(error.translation < 1e-9 && error.rotation < 1e-9, "{error:?}");
    assert_eq!(report.stop, Stop::Converged);
    let error = Deviation::between(&solved::<f32>(0.0).extrinsics, &rig(ROTATION, BASELINE));
    assert!(error.translation < 2e-5 && error.rotation < 1e-5, "{error:?}");
}

#[test]
fn a_pair_that_is_5_degrees_off_about_all_axes_converges_in_few_passes() {
    let report = solved::<f32>(0.5);
    assert_eq!(report.stop, Stop::Converged);
    assert!(report.passes <= 12, "{}", report.passes);
    assert!(report.cost_after < report.cost_before);
    assert!(report.rms_px_before > 50.0 && report.rms_px_after < 0.6, "{report:?}");
    // Uniform noise of +-0.5 px on two rows.
    assert!((report.noise_px / (0.5 * (2.0_f32 / 3.0).sqrt()) - 1.0).abs() < 0.15);
    assert_eq!([report.usable, report.skipped, report.screened], [256, 0, 256]);
}

#[test]
fn pass_by_pass_gives_the_same_bits_as_one_call() {
    let mut calibrator = published::<f32>();
    for c in correspondences(&rig(ROTATION, BASELINE), 256, 0.5, 1) {
        calibrator.push(&c).unwrap();
    }
    let whole = calibrator.clone().solve_pair();
    assert!(whole.fused.is_ok());
    let stepped = (0..104).find_map(|_| calibrator.advance_pair()).unwrap();
    assert_eq!(stepped, whole);
    // A pair counts once.
    let none = Rejection::TooFew { usable: 0, needed: 12 };
    assert_eq!(calibrator.advance_pair().unwrap().fused, Err(none));
}

#[test]
fn a_pair_that_is_being_solved_can_be_abandoned_and_leaves_no_trace() {
    let batch = |seed| correspondences::<f32>(&rig(ROTATION, BASELINE), 256, 0.5, seed);
    let mut calibrators = [0, 1].map(|_| published::<f32>());
    let [abandoned, fresh] = &mut calibrators;
    for c in batch(1) {
        abandoned.push(&c).unwrap();
    }
    assert_eq!(abandoned.advance_pair(), None);
    assert_eq!(abandoned.push(&batch(1)[0]), Err(PushError::Busy));
    abandoned.discard_pair();
    let [report, expected] = [abandoned, fresh].map(|calibrator| {
        for c in batch(2) {
            calibrator.push(&c).unwrap();
        }
        calibrator.solve_pair()
    });
    assert_eq!(report, expected);
}

#[test]
fn passes_are_bounded_and_what_they_reach_is_reported() {
    let settings = Settings::DEFAULT.with_max_passes(3).unwrap();
    let mut calibrator = with::<f32>(settings);
    for c in correspondences(&rig(ROTATION, BASELINE), 256, 0.5, 1) {
        calibrator.push(&c).unwrap();
    }
    let report = calibrator.solve_pair().pair.unwrap();
    assert_eq!((report.stop, report.passes), (Stop::PassesSpent, 3));
    assert!(report.cost_after < report.cost_before);
}

/// Mean over 200 trials of the squared errors over the predicted variances. If the predictions are right, it is 1 up to
/// the scatter of the trials.
fn mean_square_of_errors_over_predictions(
    truth: &Extrinsics<f32>,
    scene: impl Fn(u64) -> Vec<Correspondence<f32>>,
) -> f32 {
    let mut calibrator = published::<f32>();
    let [mut sum, trials] = [0.0, 200.0];
    for seed in 0..200 {
        for c in scene(seed) {
            calibrator.push(&c).unwrap();
        }
        let report = calibrator.solve_pair().pair.unwrap();
        calibrator.discard_pair();
        let sd = report.information.standard_deviations().unwrap();
        let error = Deviation::between(&report.extrinsics, truth);
        sum += (error.translation / sd.translation).powi(2) / 2.0;
        sum += (error.rotation / sd.rotation).powi(2) / 2.0;
    }
    sum / trials
}

#[test]
fn predicted_deviations_cover_the_errors() {
    let truth = rig(ROTATION, BASELINE);
    let chi2 = mean_square_of_errors_over_predictions(&rig(ROTATION, BASELINE), |seed| {
        correspondences(&truth, 256, 0.5, seed)
    });
    assert!((chi2 - 1.0).abs() < 0.2, "{chi2}");
}

/// A pair in which the right row of every third match is wrong by up to 4 px in either direction: mostly beyond the
/// Huber threshold, and without a bias.
fn with_wrong_rows(n: usize, seed: u64) -> Vec<Correspondence<f32>> {
    let mut all = correspondences::<f32>(&rig(ROTATION, BASELINE), n, 0.5, seed);
    for (i, c) in all.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
        let phase = f32::from(u16::try_from(i * 37 % 101).unwrap()) / 50.0 - 1.0;
        c.right[1] = (c.right[1] + 4.0 * phase).clamp(0.0, 1199.0);
    }
    all
}

#[test]
fn the_cost_never_rises_from_starts_that_are_far_off_among_outliers() {
    let cameras = cameras::<f32>();
    let start = rig([-20.0, 25.0, -30.0], [-20.0, 25.0]);
    let mut rejected = 0;
    for seed in 0..200 {
        let mut matches = with_wrong_rows(40, seed);
        // Every second match has the right point of another match.
        for i in (0..38).step_by(2) {
            let other = matches[i + 2].right;
            matches[i].right = other;
        }
        let pairs: Vec<_> = matches.iter().map(|c| cameras.rays(c).unwrap()).collect();
        let focal = cameras.mean_focal();
        let Ok(mut solver) = HuberSolver::begin(&Settings::DEFAULT, focal, &start, &pairs) else {
            continue;
        };
        let mut cost = f32::INFINITY;
        while solver.advance(&pairs).is_none() {
            let Ok(report) = solver.report(&pairs) else { continue };
            assert!(report.cost_after <= cost * (1.0 + 1e-5), "{cost} {}", report.cost_after);
            rejected += u32::from(report.cost_after == cost);
            cost = report.cost_after;
        }
    }
    assert!(rejected > 30, "only {rejected} steps were rejected: the scenes are too easy");
}

#[test]
fn predicted_deviations_cover_the_errors_where_a_third_of_the_rows_is_wrong() {
    let truth = rig::<f32>(ROTATION, BASELINE);
    let chi2 = mean_square_of_errors_over_predictions(&truth, |seed| with_wrong_rows(256, seed));
    assert!((chi2 - 1.0).abs() < 0.25, "{chi2}");
}

#[test]
fn the_noise_of_a_few_correspondences_is_estimated_without_bias() {
    let mut calibrator = published::<f32>();
    let [mut sum, trials] = [0.0, 500.0];
    for seed in 0..500 {
        for c in correspondences(&rig(ROTATION, BASELINE), 16, 0.5, seed) {
            calibrator.push(&c).unwrap();
        }
        if let Some(report) = calibrator.solve_pair().pair {
            sum += report.noise_px * report.noise_px;
        }
        calibrator.discard_pair();
    }
    // Uniform noise of +-0.5 px on two rows has variance 1/6. The rectification magnifies the noise near the image
    // border slightly.
    assert!((sum / trials * 6.0 - 1.0).abs() < 0.15, "{}", sum / trials * 6.0);
}
