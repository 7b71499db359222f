//! Bad input leads to a typed refusal or a counted skip, and the state stays as it was, bit for bit.

use crate::api::presets::{calibrator, robust};
use crate::api::scene::{cameras, correspondences, rig, take};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::batch::Pushed;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::{Side, UndistortError};
use stereo_selfcal::paper::Settings;
use stereo_selfcal::{
    Calibrator, Camera, Config, Correspondence, Extrinsics, FactoryCalibration, Intrinsics, Lens,
    PushError, Rejection, State,
};

type Tested = Calibrator<f32, 256>;

/// Batch, estimate and calibration in use as text, with all digits of the numbers.
fn state(c: &Tested) -> String {
    format!(
        "{:?} {:?} {:?} {}",
        c.batch().pairs(),
        c.proposal(),
        &c.in_use().extrinsics,
        c.in_use().generation
    )
}

fn filled(n: usize) -> Tested {
    let mut calibrator = calibrator::<f32>();
    for c in correspondences(&rig([1.0, 2.0, -1.0], [2.0, 1.0]), n, 0.3, 7) {
        calibrator.push(&c).unwrap();
    }
    calibrator
}

/// A calibrator with one fused pair and an empty batch.
fn fused() -> Tested {
    let mut calibrator = filled(200);
    calibrator.solve_pair().fused.unwrap();
    calibrator.discard_pair();
    calibrator
}

fn at(left: [f32; 2], right: [f32; 2]) -> Correspondence<f32> {
    Correspondence { left, right, score: 1.0, grid_step: 0.0 }
}

#[test]
fn impossible_correspondences_are_refused_and_change_nothing() {
    let mut calibrator = filled(20);
    let before = state(&calibrator);
    let good = at([900.0, 500.0], [880.0, 500.0]);
    let pixel = |side, why| PushError::Pixel(side, why);
    let cases = [
        (at([f32::NAN, 5.0], good.right), pixel(Side::Left, UndistortError::NotFinite)),
        (at(good.left, [5.0, f32::INFINITY]), pixel(Side::Right, UndistortError::NotFinite)),
        (at([1e30, 5.0], good.right), pixel(Side::Left, UndistortError::OutsideImage)),
        (at(good.left, [5.0, -3e38]), pixel(Side::Right, UndistortError::OutsideImage)),
        (Correspondence { score: f32::NAN, ..good }, PushError::Score),
        (Correspondence { score: 1.5, ..good }, PushError::Score),
        (Correspondence { score: -0.1, ..good }, PushError::Score),
        (Correspondence { grid_step: f32::NAN, ..good }, PushError::GridStep),
        (Correspondence { grid_step: 1e9, ..good }, PushError::GridStep),
    ];
    for (i, (bad, why)) in (1..).zip(cases) {
        assert_eq!(calibrator.push(&bad), Err(why));
        assert_eq!(calibrator.batch().refused(), i);
    }
    assert_eq!(state(&calibrator), before);
    assert_eq!(calibrator.push(&good), Ok(Pushed::Kept));
}

#[test]
fn no_correspondence_enters_while_a_pair_is_being_solved() {
    let mut calibrator = filled(100);
    assert_eq!(calibrator.advance_pair(), None);
    assert_eq!(calibrator.push(&at([9.0, 9.0], [5.0, 9.0])), Err(PushError::Busy));
    calibrator.discard_pair();
    assert_eq!(calibrator.push(&at([9.0, 9.0], [5.0, 9.0])), Ok(Pushed::Kept));
}

/// Checks that the solver refuses the matches, and that this does not change the estimate and the calibration in use.
fn refuses_pair(matches: impl IntoIterator<Item = Correspondence<f32>>, expected: Rejection) {
    let mut calibrator = fused();
    for c in matches {
        calibrator.push(&c).unwrap();
    }
    let before = state(&calibrator);
    assert_eq!(calibrator.solve_pair().fused, Err(expected));
    assert_eq!(state(&calibrator), before);
    calibrator.discard_pair();
    assert_eq!(state(&calibrator), state(&fused()));
}

#[test]
fn too_few_correspondences_are_refused() {
    let few = |n| correspondences(&Extrinsics::SIDE_BY_SIDE, n, 0.3, 3);
    refuses_pair([], Rejection::TooFew { usable: 0, needed: 12 });
    refuses_pair(few(11), Rejection::TooFew { usable: 11, needed: 12 });
    assert!(filled(12).solve_pair().pair.is_some());
}

#[test]
fn one_point_many_times_is_unobservable() {
    let c = at([1100.0, 300.0], [1050.0, 310.0]);
    refuses_pair(core::iter::repeat_n(c, 200), Rejection::Unobservable);
}

#[test]
fn points_on_one_line_are_unobservable() {
    // Columns, rows and disparities change linearly along the line.
    let line = (0..200_u8).map(|i| {
        let s = f32::from(i);
        at([400.0 + 4.0 * s, 200.0 + 3.0 * s], [360.0 + 3.8 * s, 202.0 + 3.0 * s])
    });
    refuses_pair(line, Rejection::Unobservable);
}

#[test]
fn points_at_infinity_are_never_fused_by_the_paper_preset_with_or_without_noise() {
    let mut scene = correspondences::<f32>(&Extrinsics::SIDE_BY_SIDE, 200, 0.0, 3);
    for c in &mut scene {
        c.right = c.left;
    }
    refuses_pair(scene.clone(), Rejection::RowsNotMeasured);
    // The disparities consist of noise only.
    let mut calibrator = calibrator::<f32>();
    for seed in 0..50 {
        // The noise of some pairs looks like a baseline far from the factory extrinsics.
        let refused = matches!(
            take(&mut calibrator, &noisy_infinity(seed)),
            Err(Rejection::CorrectionLimit | Rejection::Unobservable)
        );
        assert!(refused, "{seed}");
    }
    assert_eq!(calibrator.proposal(), None);
}

#[test]
fn points_at_infinity_alone_lock_the_rotation_and_leave_the_baseline_as_it_was() {
    let mut calibrator = robust::<f32>();
    let in_use = calibrator.in_use().extrinsics;
    for seed in 0..200 {
        take(&mut calibrator, &noisy_infinity(seed)).unwrap();
        let proposal = calibrator.proposal().unwrap();
        assert!(!proposal.baseline_observed, "{seed}");
        // The pairs hardly reduce the standard deviation of the prior, which is 0.1 rad about each of two axes.
        assert!(proposal.sd.translation > 0.9 * 0.1 * 2.0_f32.sqrt(), "{seed}: {:?}", proposal.sd);
        if calibrator.state() == State::Locked {
            let applied = calibrator.apply().unwrap();
            assert_eq!(applied.extrinsics.translation(), in_use.translation(), "{seed}");
        }
    }
    assert_eq!(calibrator.state(), State::Locked);
    let off = Deviation::between(&calibrator.in_use().extrinsics, &Extrinsics::SIDE_BY_SIDE);
    assert!(off.rotation < 1e-4, "{off:?}");
}

/// Points at infinity, with noise of 0.4 px RMS in the right image.
fn noisy_infinity(seed: u64) -> Vec<Correspondence<f32>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut noisy = |x: f32, last: f32| (x + rng.random_range(-0.7..0.7)).clamp(0.0, last);
    let mut scene = correspondences::<f32>(&Extrinsics::SIDE_BY_SIDE, 200, 0.0, seed);
    for c in &mut scene {
        let [u, v] = c.left;
        c.right = [noisy(u, 1919.0), noisy(v, 1199.0)];
    }
    scene
}

#[test]
fn points_at_infinity_improve_the_rotation_of_a_locked_rig_and_not_its_baseline() {
    let mut calibrator = robust::<f32>();
    for seed in 0..5 {
        let scene = correspondences(&Extrinsics::SIDE_BY_SIDE, 200, 0.5, seed);
        take(&mut calibrator, &scene).unwrap();
    }
    let before = calibrator.proposal().unwrap();
    for seed in 10..60 {
        take(&mut calibrator, &noisy_infinity(seed)).unwrap();
    }
    let after = calibrator.proposal().unwrap();
    assert!(after.baseline_observed);
    let moved = Deviation::between(&after.extrinsics, &before.extrinsics);
    assert!(moved.translation < 0.5 * before.sd.translation, "{moved:?} {:?}", before.sd);
    // A better `R` also makes the `t` of the near pairs more certain, by this factor at most.
    assert!(after.sd.translation > 0.7 * before.sd.translation, "{after:?}");
    assert!(after.sd.rotation < 0.7 * before.sd.rotation, "{after:?}");
}

#[test]
fn rays_behind_the_rectified_plane_are_skipped_and_counted() {
    // A very wide left camera sees these points 84 degrees off axis, and the rectification turns it by 8 degrees.
    let mut wide = cameras::<f32>();
    let intrinsics = Intrinsics { focal: [100.0; 2], ..*wide.left.intrinsics() };
    wide.left = Camera::try_new(intrinsics, Lens::Pinhole).unwrap();
    let made = FactoryCalibration::new(wide, rig([0.0, 8.0, 0.0], [0.0, 0.0]));
    let mut calibrator = Tested::new(Config::paper(), &made);
    for c in correspondences::<f32>(&rig([0.0, 8.0, 0.0], [0.0, 0.0]), 200, 0.3, 3) {
        let left = c.left.map(|x| x / 14.0);
        let left = [left[0] + 959.5 * 13.0 / 14.0, left[1] + 599.5 * 13.0 / 14.0];
        calibrator.push(&Correspondence { left, ..c }).unwrap();
    }
    for v in [580.0, 600.0, 620.0] {
        calibrator.push(&at([1918.0, v], [1000.0, v])).unwrap();
    }
    let report = calibrator.solve_pair().pair.unwrap();
    assert_eq!([report.usable, report.skipped], [200, 3]);
}

#[test]
fn a_start_with_rays_behind_the_plane_is_recovered_from() {
    let made = FactoryCalibration::new(cameras(), rig([0.0, 65.0, 0.0], [0.0, 0.0]));
    let mut calibrator = Tested::new(Config::paper(), &made);
    for c in correspondences(&Extrinsics::SIDE_BY_SIDE, 200, 0.3, 3) {
        calibrator.push(&c).unwrap();
    }
    let outcome = calibrator.solve_pair();
    let report = outcome.pair.unwrap();
    assert!(report.screened < 200, "none was behind at the start");
    assert_eq!([report.usable, report.skipped], [200, 0]);
    assert_eq!(outcome.fused, Err(Rejection::CorrectionLimit));
}

#[test]
fn a_pair_beyond_the_limits_is_refused_and_the_estimate_keeps_its_bits() {
    let refused = |config: Config, factory: Extrinsics<f32>| {
        let made = FactoryCalibration::new(cameras(), factory);
        let mut calibrator = Tested::new(config, &made);
        for c in correspondences(&rig([1.0, 2.0, -1.0], [2.0, 1.0]), 200, 0.3, 7) {
            calibrator.push(&c).unwrap();
        }
        let before = state(&calibrator);
        let refusal = calibrator.solve_pair().fused.unwrap_err();
        assert_eq!(state(&calibrator), before);
        refusal
    };
    let near = Config::paper().with_max_correction_rad(0.02).unwrap();
    assert_eq!(refused(near, Extrinsics::SIDE_BY_SIDE), Rejection::CorrectionLimit);
    // The baseline alone is beyond the limit.
    let turned = rig([1.0, 2.0, -1.0], [0.0, 0.0]);
    assert_eq!(refused(near, turned), Rejection::CorrectionLimit);
    let strict = Config::paper().with_paper(Settings::DEFAULT.with_max_sd_rad(1e-6).unwrap());
    assert_eq!(refused(strict, Extrinsics::SIDE_BY_SIDE), Rejection::TooUncertain);
}

#[test]
fn generation_counts_changes_of_what_is_in_use() {
    let mut calibrator = fused();
    assert_eq!(calibrator.in_use().generation, 0);
    let applied = calibrator.apply().unwrap();
    assert_eq!(
        (calibrator.in_use().generation, &calibrator.in_use().extrinsics),
        (1, &applied.extrinsics)
    );
    calibrator.apply().unwrap();
    assert_eq!(calibrator.in_use().generation, 1);
    calibrator.reset();
    assert_eq!(calibrator.in_use().generation, 2);
    assert_eq!(&calibrator.in_use().extrinsics, &Extrinsics::SIDE_BY_SIDE);
    assert_eq!(calibrator.proposal(), None);
}

#[test]
fn details_compare_in_use_and_proposed_over_the_same_matches() {
    let mut calibrator = filled(200);
    calibrator.push(&at([1000.0, 300.0], [900.0, 800.0])).unwrap();
    calibrator.solve_pair().fused.unwrap();
    let details = calibrator.details().unwrap();
    assert!(details.in_use_px > 10.0 && details.proposed_px < 0.4, "{details:?}");
    assert_eq!([details.fit_in_use, details.fit_proposed], [0, 200]);
    calibrator.apply().unwrap();
    let applied = calibrator.details().unwrap();
    assert_eq!(applied.in_use_px, applied.proposed_px);
}
