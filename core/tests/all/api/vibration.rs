//! A rig that vibrates.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::geometry::so3;
use stereo_selfcal::{
    Calibrator, Config, Extrinsics, Fused, LensTracking, Proposal, Reason, State,
};

use crate::api::lens::pair_of;
use crate::api::presets::{ROWS_ALONE, with};
use crate::api::scene::{self, correspondences, rig};

type Tested = Calibrator<f32, 256>;

const ROTATION: [f64; 3] = [1.0, -2.0, 1.5];
const BASELINE: [f64; 2] = [1.0, -1.0];

/// A calibrator of a matcher that searches 10 px across rows.
fn fresh() -> Tested {
    with(ROWS_ALONE.with_rows_limit_px(10.0).unwrap())
}

/// The rig with its right camera turned at random, by `vibration_deg` RMS about each axis.
pub(crate) fn shaken(vibration_deg: f64, seed: u64) -> Extrinsics<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let turn = Vector3::from_fn(|_, _| normal() * vibration_deg.to_radians());
    let (steady, turn) = (rig::<f64>(ROTATION, BASELINE), so3::exp(&turn).unwrap());
    let r = turn * steady.rotation();
    Extrinsics::try_new(r.matrix(), &(turn * steady.translation().into_inner())).unwrap()
}

/// Takes a pair of the vibrating rig, then applies the estimate. Returns whether the rig may arm between the two steps.
fn take(calibrator: &mut Tested, pair: u64, vibration_deg: f64) -> bool {
    for m in correspondences::<f32>(&shaken(vibration_deg, pair), 200, 0.5, 1000 + pair) {
        calibrator.push(&m).unwrap();
    }
    let _ = calibrator.solve_pair();
    let arms = calibrator.verdict().may_arm;
    let _ = calibrator.apply();
    calibrator.discard_pair();
    arms
}

#[test]
fn a_vibrating_rig_locks_on_its_mean_reports_the_vibration_and_is_armed() {
    let mut calibrator = fresh();
    let armed: Vec<_> = (0..40).map(|pair| take(&mut calibrator, pair, 0.1)).collect();
    assert_eq!(calibrator.state(), State::Locked);
    let proposal = calibrator.proposal().unwrap();
    let off = Deviation::between(&proposal.extrinsics, &rig(ROTATION, BASELINE));
    // The mean of 40 turns of 0.1 degrees RMS about each of 3 axes is off by 0.5 mrad.
    assert!(off.rotation < 1.5e-3 && off.translation < 2e-3, "{off:?}");
    assert!(off.rotation < 3.0 * proposal.sd.rotation, "{off:?}, {:?}", proposal.sd);
    let degrees = proposal.vibration.rotation.to_degrees();
    assert!((0.07..0.13).contains(&degrees), "{degrees}");
    let yes = armed[20..].iter().filter(|arms| **arms).count();
    assert!(yes >= 18, "{armed:?}");
}

#[test]
fn extrinsics_in_use_that_are_off_are_misaligned_on_a_vibrating_rig_too() {
    let mut calibrator = fresh();
    for pair in 0..30 {
        for m in correspondences::<f32>(&shaken(0.1, pair), 200, 0.5, 1000 + pair) {
            calibrator.push(&m).unwrap();
        }
        // The estimate is not applied: the factory extrinsics stay in use.
        let _ = calibrator.solve_pair();
        calibrator.discard_pair();
    }
    assert!(!calibrator.proposal().unwrap().vibration.is_none());
    let verdict = calibrator.verdict();
    assert_eq!(verdict.state, State::Locked);
    assert!(verdict.reasons.contains(Reason::Rows) && !verdict.may_arm);
}

#[test]
fn a_restored_calibrator_keeps_the_vibration_and_its_deviations_and_locks_again() {
    let mut calibrator = fresh();
    (0..30).for_each(|pair| {
        take(&mut calibrator, pair, 0.1);
    });
    let mut restored = fresh();
    restored.restore(&calibrator.snapshot()).unwrap();
    let [before, after] = [&calibrator, &restored].map(|c| c.proposal().unwrap());
    assert_eq!(before.vibration, after.vibration);
    for (old, new) in
        [(before.sd.rotation, after.sd.rotation), (before.sd.translation, after.sd.translation)]
    {
        assert!((new / old - 1.0).abs() < 0.1, "{old} {new}");
    }
    (30..34).for_each(|pair| {
        take(&mut restored, pair, 0.1);
    });
    assert_eq!(restored.state(), State::Locked);
}

#[test]
fn a_rigid_rig_has_no_vibration() {
    let mut calibrator = fresh();
    for pair in 0..60 {
        take(&mut calibrator, pair, 0.0);
        assert!(calibrator.proposal().unwrap().vibration.is_none(), "{pair}");
    }
}

/// The proposal after 60 pairs, and the number of corrections of the lens.
///
/// * `focal`: relative error of the right focal length.
fn with_lens(vibration_deg: f64, focal: f32, tracking: LensTracking) -> (Proposal<f32>, usize) {
    let mut calibrator: Tested = with(Config::robust().with_lens_tracking(tracking));
    let fused = (0..60).map(|seed| {
        let matches = pair_of(&shaken(vibration_deg, seed), focal, 0.0, seed);
        scene::take(&mut calibrator, &matches)
    });
    let corrections = fused.filter(|fused| *fused == Ok(Fused::LensCorrected)).count();
    (calibrator.proposal().unwrap(), corrections)
}

#[test]
fn vibration_is_not_taken_for_an_error_of_the_lens() {
    for tracking in [LensTracking::Report, LensTracking::Compensate] {
        let (rigid, _) = with_lens(0.0, 0.0, tracking);
        let (shaken, corrections) = with_lens(0.2, 0.0, tracking);
        assert!(!shaken.vibration.is_none() && rigid.vibration.is_none());
        let lens = shaken.lens.unwrap();
        assert_eq!((lens.to_string().as_str(), corrections), ("as given", 0), "{lens:?}");
        assert!(lens.k1_mean.sd < 2.0 * rigid.lens.unwrap().k1_mean.sd, "{lens:?}");
    }
}

#[test]
fn a_wrong_focal_length_is_found_and_compensated_on_a_vibrating_rig_too() {
    let (reported, _) = with_lens(0.1, 0.002, LensTracking::Report);
    let lens = reported.lens.unwrap();
    assert!((lens.focal.value - 0.002).abs() < 3.0 * lens.focal.sd, "{lens:?}");
    assert!(lens.focal.is_significant() && !lens.k1_mean.is_significant(), "{lens:?}");
    let (compensated, corrections) = with_lens(0.1, 0.002, LensTracking::Compensate);
    let focal = compensated.lens.unwrap().focal;
    assert!(corrections > 0 && (focal.value - 0.002).abs() < 1e-4, "{focal:?}");
}

#[test]
fn pairs_of_other_rigs_are_not_taken_for_vibration() {
    let mut calibrator = fresh();
    let mut kept_apart = 0;
    for pair in 0..60_u64 {
        // In every second pair after the lock, the right camera is turned at random, by 2 degrees RMS about each axis.
        let turned = if pair > 10 && pair.is_multiple_of(2) { 2.0 } else { 0.0 };
        for m in correspondences::<f32>(&shaken(turned, pair), 200, 0.5, 1000 + pair) {
            calibrator.push(&m).unwrap();
        }
        kept_apart += u32::from(calibrator.solve_pair().fused == Ok(Fused::KeptApart));
        let vibration = calibrator.proposal().unwrap().vibration;
        assert_eq!([vibration.rotation, vibration.baseline], [0.0; 2], "{pair}");
    }
    assert!(kept_apart >= 10, "{kept_apart}");
}
