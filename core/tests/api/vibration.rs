//! A rig that vibrates.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{Arming, Calibrator, Config, Extrinsics, State, so3};

use crate::scene::{cameras, correspondences, rig};

type Tested = Calibrator<f32, 256>;

const ROTATION: [f64; 3] = [1.0, -2.0, 1.5];
const BASELINE: [f64; 2] = [1.0, -1.0];

fn fresh() -> Tested {
    let mut calibrator = Tested::new(Config::robust());
    calibrator.set_cameras(cameras());
    calibrator
}

/// The rig with its right camera turned at random, degrees RMS about each axis.
fn shaken(vibration_deg: f64, seed: u64) -> Extrinsics<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut normal = || (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0;
    let turn = Vector3::from_fn(|_, _| normal() * vibration_deg.to_radians());
    let (steady, turn) = (rig::<f64>(ROTATION, BASELINE), so3::exp(&turn).unwrap());
    let r = turn * steady.rotation();
    Extrinsics::try_new(r.matrix(), &(turn * steady.translation().into_inner())).unwrap()
}

fn take(calibrator: &mut Tested, pair: u64, vibration_deg: f64) -> Option<Arming> {
    for m in correspondences::<f32>(&shaken(vibration_deg, pair), 200, 0.5, 1000 + pair) {
        calibrator.push(&m).unwrap();
    }
    let _ = calibrator.solve_pair().is_ok() && calibrator.fuse().is_ok();
    let arming = calibrator.health().map(|health| health.arming);
    let _ = calibrator.apply();
    calibrator.clear_pair();
    arming
}

#[test]
fn a_vibrating_rig_locks_on_its_mean_reports_the_vibration_and_is_armed() {
    let mut calibrator = fresh();
    let armed: Vec<_> = (0..40).map(|pair| take(&mut calibrator, pair, 0.1)).collect();
    assert_eq!(calibrator.state(), State::Locked);
    let proposal = calibrator.proposal().unwrap();
    let off = Deviation::between(&proposal.extrinsics, &rig(ROTATION, BASELINE));
    // 0.1 degrees over sqrt(40) about each axis: 0.5 mrad of R.
    assert!(off.rotation < 1.5e-3 && off.translation < 2e-3, "{off:?}");
    assert!(off.rotation < 3.0 * proposal.sd.rotation, "{off:?}, {:?}", proposal.sd);
    let degrees = proposal.vibration.rotation.to_degrees();
    assert!((0.07..0.13).contains(&degrees), "{degrees}");
    let yes = armed[20..].iter().filter(|arming| **arming == Some(Arming::Yes)).count();
    assert!(yes >= 18, "{armed:?}");
}

#[test]
fn extrinsics_in_use_that_are_off_are_misaligned_on_a_vibrating_rig_too() {
    let mut calibrator = fresh();
    let mut last = None;
    for pair in 0..30 {
        for m in correspondences::<f32>(&shaken(0.1, pair), 200, 0.5, 1000 + pair) {
            calibrator.push(&m).unwrap();
        }
        // Nothing is applied: the factory extrinsics stay in use.
        let _ = calibrator.solve_pair().is_ok() && calibrator.fuse().is_ok();
        last = calibrator.health();
        calibrator.clear_pair();
    }
    let health = last.unwrap();
    assert!(!health.vibration.is_none());
    assert_eq!((health.state, health.arming), (State::Locked, Arming::Misaligned));
}

#[test]
fn a_restored_rig_still_vibrates_and_goes_on_as_it_was() {
    let mut calibrator = fresh();
    (0..30).for_each(|pair| {
        take(&mut calibrator, pair, 0.1);
    });
    let mut buffer = vec![0; Tested::SNAPSHOT_BYTES];
    let record = calibrator.snapshot(&mut buffer).unwrap();
    let mut restored = fresh();
    restored.restore(record).unwrap();
    let [before, after] = [&calibrator, &restored].map(|c| c.proposal().unwrap());
    assert_eq!((before.vibration, before.sd), (after.vibration, after.sd));
    let mut again = vec![0; Tested::SNAPSHOT_BYTES];
    let state = restored.snapshot(&mut again).unwrap().len();
    assert_eq!(state, record.len());
    (30..34).for_each(|pair| {
        take(&mut restored, pair, 0.1);
    });
    assert_eq!(restored.state(), State::Locked);
}

#[test]
fn a_rigid_rig_has_no_vibration_and_its_health_does_not_name_one() {
    let mut calibrator = fresh();
    for pair in 0..60 {
        take(&mut calibrator, pair, 0.0);
        assert!(calibrator.proposal().unwrap().vibration.is_none(), "{pair}");
    }
}
