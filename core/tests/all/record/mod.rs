//! Records: a restart continues from the estimate, and a damaged record is refused.

mod damage;
mod format;
mod lives;

use crate::api::disturbed::with_outliers;
use crate::api::presets::{robust, with};
use crate::api::scene::{correspondences, rig, take};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{ApplyError, Calibrator, Config, Correspondence, Extrinsics, Scalar, State};

pub(crate) const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
pub(crate) const BASELINE: [f64; 2] = [0.5, -0.4];
const KNOCKED: [f64; 3] = [1.4, -0.5, 0.8];

pub(crate) type Tested<T> = Calibrator<T, 256>;
pub(crate) type Record = [u8; Tested::<f32>::SNAPSHOT_BYTES];

pub(crate) fn scene<T: Scalar>(rotation: [f64; 3], seed: u64) -> Vec<Correspondence<T>> {
    with_outliers(correspondences(&rig(rotation, BASELINE), 250, 0.5, seed), 4)
}

/// A calibrator after `pairs` pairs of the rig, which has applied the estimate if it is locked.
pub(crate) fn after<T: Scalar>(config: Config, pairs: u64) -> Tested<T> {
    let mut calibrator = with(config);
    for seed in 0..pairs {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
    }
    let _ = calibrator.apply();
    calibrator
}

/// A fresh calibrator of the same rig that has read the record.
fn restored<T: Scalar>(config: Config, record: &Record) -> Tested<T> {
    let mut fresh = with(config);
    fresh.restore(record).unwrap();
    fresh
}

pub(crate) fn off<T: Scalar>(found: &Extrinsics<T>, rotation: [f64; 3]) -> [f64; 2] {
    let Deviation { rotation, translation } = Deviation::between(found, &rig(rotation, BASELINE));
    [rotation.to_f64(), translation.to_f64()]
}

/// Whether extrinsics differ by no more than the rounding of a record and of their own numbers.
fn same<T: Scalar>(one: &Extrinsics<T>, other: &Extrinsics<T>) -> bool {
    let Deviation { rotation, translation } = Deviation::between(one, other);
    rotation.to_f64().max(translation.to_f64()) < 5e-7
}

/// Checks that a restored calibrator is suspect until a pair confirms it, and then stays close to the original.
fn goes_on<T: Scalar>(pairs: u64) {
    let mut before = after::<T>(Config::robust(), pairs);
    let mut after = restored(Config::robust(), &before.snapshot());
    let estimates = [&before, &after].map(|c| c.proposal().unwrap());
    assert!(same(&estimates[0].extrinsics, &estimates[1].extrinsics));
    assert!(same(&before.in_use().extrinsics, &after.in_use().extrinsics));
    assert_eq!(estimates[0].pairs, estimates[1].pairs);
    let [old, new] = estimates.map(|p| [p.sd.rotation, p.sd.translation].map(T::to_f64));
    for (old, new) in old.into_iter().zip(new) {
        assert!((new / old - 1.0).abs() < 0.1, "{old} {new}");
    }
    assert_eq!(after.apply(), Err(ApplyError::NotLocked(State::Suspect)));
    for seed in 100..110 {
        take(&mut before, &scene(ROTATION, seed)).unwrap();
        take(&mut after, &scene(ROTATION, seed)).unwrap();
        assert_eq!(after.state(), State::Locked);
        let [one, other] = [&before, &after].map(|c| c.proposal().unwrap());
        let apart = Deviation::between(&one.extrinsics, &other.extrinsics);
        assert!(apart.rotation <= one.sd.rotation * T::lit(0.1), "{apart:?}");
        assert!(apart.translation <= one.sd.translation * T::lit(0.1), "{apart:?}");
    }
}

#[test]
fn a_restored_estimate_is_suspect_until_a_pair_confirms_it_and_then_goes_on_as_without_a_restart() {
    [8, 40].into_iter().for_each(goes_on::<f32>);
    goes_on::<f64>(12);
}

#[test]
fn a_rig_that_was_knocked_meanwhile_is_found_within_three_pairs() {
    let before = after::<f32>(Config::robust(), 20);
    let mut after = restored::<f32>(Config::robust(), &before.snapshot());
    for seed in 0..3 {
        let _ = take(&mut after, &scene(KNOCKED, 50 + seed));
    }
    assert_eq!(after.state(), State::Locked);
    let [r, t] = off(&after.proposal().unwrap().extrinsics, KNOCKED);
    assert!(r < 1e-3 && t < 3e-3, "{r} {t}");
}

#[test]
fn frozen_undo_and_generation_survive_and_other_extrinsics_get_another_generation() {
    let mut old = after::<f32>(Config::robust(), 10);
    old.set_frozen(true);
    let mut new = restored::<f32>(Config::robust(), &old.snapshot());
    assert_eq!(new.in_use().generation, old.in_use().generation);
    assert_eq!(new.undo(), Err(ApplyError::Frozen));
    new.set_frozen(false);
    assert_eq!(new.undo().unwrap().extrinsics, Extrinsics::SIDE_BY_SIDE);
    // Both calibrators have changed twice, to different extrinsics, so they have the same generation.
    old.set_frozen(false);
    take(&mut old, &scene(ROTATION, 70)).unwrap();
    old.apply().unwrap();
    let mut fresh = robust::<f32>();
    for seed in 0..4 {
        take(&mut fresh, &scene(KNOCKED, seed)).unwrap();
    }
    fresh.apply().unwrap();
    fresh.undo().unwrap();
    assert_eq!([old.in_use().generation, fresh.in_use().generation], [2, 2]);
    fresh.restore(&old.snapshot()).unwrap();
    assert_eq!(fresh.in_use().generation, 3);
}

#[test]
fn without_a_confirmed_estimate_only_the_calibration_in_use_is_kept() {
    let new = after::<f32>(Config::robust(), 2);
    let again = restored::<f32>(Config::robust(), &new.snapshot());
    assert_eq!((again.state(), again.proposal()), (State::Acquiring, None));
    assert_eq!(&again.in_use().extrinsics, &Extrinsics::SIDE_BY_SIDE, "bit for bit");
}

/// Angles of `R` of the locked estimates of eight pairs. Each snapshot must restore its estimate.
fn restored_angles(config: Config, rotation: [f64; 3]) -> Vec<f32> {
    let mut calibrator = with::<f32, 256>(config);
    let mut angles = Vec::new();
    for seed in 0..8 {
        let _ = take(&mut calibrator, &scene(rotation, seed));
        if calibrator.state() == State::Locked {
            restored::<f32>(config, &calibrator.snapshot());
            let found = calibrator.proposal().unwrap().extrinsics;
            angles.push(Deviation::between(&found, &Extrinsics::SIDE_BY_SIDE).rotation);
        }
    }
    angles
}

#[test]
fn an_estimate_at_the_correction_limit_is_restored() {
    let mut at_limit = 0;
    for seed in 0..20 {
        let rotation = [1.0 + 0.01 * f64::from(seed), -0.5, 0.8];
        let angles = restored_angles(Config::robust(), rotation);
        let most = angles.iter().copied().fold(0.0, f32::max);
        let limited = Config::robust().with_max_correction_rad(most).unwrap();
        at_limit += u32::from(restored_angles(limited, rotation).contains(&most));
    }
    assert!(at_limit > 5, "{at_limit}");
}
