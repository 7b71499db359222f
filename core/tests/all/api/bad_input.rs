//! Bad input leads to a typed refusal or a counted skip, and the state stays as it was, bit for bit.

use crate::api::presets::robust;
use crate::api::scene::{correspondences, rig, take};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::batch::Pushed;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::{Side, UndistortError};
use stereo_selfcal::{Calibrator, Correspondence, Extrinsics, PushError, Rejection, State};

type Tested = Calibrator<f32, 256>;

/// Batch, estimate and calibration in use as text, with all digits of the numbers. A refused pair may change the state
/// of the estimate, which is left out.
fn state(c: &Tested) -> String {
    format!(
        "{:?} {:?} {:?} {}",
        c.batch().matches(),
        c.proposal().map(|p| (p.extrinsics, p.covariance, p.pairs)),
        &c.in_use().extrinsics,
        c.in_use().generation
    )
}

fn filled(n: usize) -> Tested {
    let mut calibrator = robust::<f32>();
    for c in correspondences(&rig([1.0, 2.0, -1.0], [2.0, 1.0]), n, 0.3, 7) {
        calibrator.push(&c).unwrap();
    }
    calibrator
}

/// A calibrator with four fused pairs, which lock it, and an empty batch.
fn fused() -> Tested {
    let mut calibrator = robust::<f32>();
    for seed in 0..4 {
        let pair = correspondences(&rig([1.0, 2.0, -1.0], [2.0, 1.0]), 200, 0.3, seed);
        take(&mut calibrator, &pair).unwrap();
    }
    calibrator.discard_pair();
    calibrator
}

pub(crate) fn at(left: [f32; 2], right: [f32; 2]) -> Correspondence<f32> {
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
fn points_on_one_line_show_no_depth() {
    // Columns, rows and disparities change linearly along the line.
    let line = (0..200_u8).map(|i| {
        let s = f32::from(i);
        at([400.0 + 4.0 * s, 200.0 + 3.0 * s], [360.0 + 3.8 * s, 202.0 + 3.0 * s])
    });
    refuses_pair(line, Rejection::NoDepth);
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
pub(crate) fn noisy_infinity(seed: u64) -> Vec<Correspondence<f32>> {
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
    let mut calibrator = fused();
    for c in correspondences(&rig([1.0, 2.0, -1.0], [2.0, 1.0]), 200, 0.3, 7) {
        calibrator.push(&c).unwrap();
    }
    calibrator.push(&at([1000.0, 300.0], [900.0, 800.0])).unwrap();
    calibrator.solve_pair().fused.unwrap();
    let details = calibrator.details().unwrap();
    assert!(details.in_use_px > 10.0 && details.proposed_px < 0.4, "{details:?}");
    assert_eq!([details.fit_in_use, details.fit_proposed], [0, 200]);
    calibrator.apply().unwrap();
    let applied = calibrator.details().unwrap();
    assert_eq!(applied.in_use_px, applied.proposed_px);
}
