//! Records equal those of Rust, byte for byte.

use std::mem::MaybeUninit;

use rigs::data::Dataset;
use stereo_selfcal::{Calibrator, Config, FactoryCalibration};
use stereo_selfcal_capi::selfcal_error_t::{self, *};
use stereo_selfcal_capi::selfcal_state_t::*;
use stereo_selfcal_capi::*;

use crate::life::{
    Twin, assert_same, assert_same_estimate, change_what_is_in_use, push, take_pair, twins,
};
use crate::rig::{Cal, at_work, defaults, factory, get, pair, recorded};

pub(crate) fn snapshot(cal: &mut Cal) -> Vec<u8> {
    let mut buffer = vec![0xa5; SELFCAL_SNAPSHOT_BYTES];
    // SAFETY: live objects.
    assert_eq!(unsafe { selfcal_snapshot(cal.ptr(), buffer.as_mut_ptr()) }, SELFCAL_OK);
    buffer
}

pub(crate) fn restore(cal: &mut Cal, record: &[u8]) -> selfcal_error_t {
    // SAFETY: live objects.
    unsafe { selfcal_restore(cal.ptr(), record.as_ptr(), record.len()) }
}

/// The record of a factory calibration.
pub(crate) fn to_record(factory: &selfcal_factory_t) -> Vec<u8> {
    let mut bytes = vec![0; SELFCAL_FACTORY_BYTES];
    // SAFETY: live objects.
    assert_eq!(unsafe { selfcal_factory_to_record(factory, bytes.as_mut_ptr()) }, SELFCAL_OK);
    bytes
}

/// The factory calibration of a record.
pub(crate) fn from_record(record: &[u8]) -> Result<selfcal_factory_t, selfcal_error_t> {
    let mut factory = MaybeUninit::uninit();
    let place = factory.as_mut_ptr();
    // SAFETY: live objects.
    match unsafe { selfcal_factory_from_record(place, record.as_ptr(), record.len()) } {
        // SAFETY: written.
        SELFCAL_OK => Ok(unsafe { factory.assume_init() }),
        error => Err(error),
    }
}

fn snapshot_of(twin: &Twin) -> Vec<u8> {
    twin.snapshot().to_vec()
}

fn run(cal: &mut Cal, twin: &mut Twin, set: &Dataset, pairs: std::ops::Range<usize>) {
    for index in pairs {
        push(cal, twin, set, index);
        take_pair(cal, twin);
        change_what_is_in_use(cal, twin);
    }
}

#[test]
fn a_restored_run_is_bit_identical_to_that_of_rust() {
    let set = recorded();
    let (c, rust) = (defaults(), Config::robust());
    let (mut cal, mut twin) = twins(&set, &c, rust);
    assert_eq!(snapshot(&mut cal), snapshot_of(&twin));
    run(&mut cal, &mut twin, &set, 0..6);
    let kept = snapshot(&mut cal);
    assert_eq!(kept, snapshot_of(&twin));

    let generation = twin.in_use().generation;
    (cal, twin) = twins(&set, &c, rust);
    assert_eq!(restore(&mut cal, &kept), SELFCAL_OK);
    twin.restore(&kept).unwrap();
    let used = get!(cal, selfcal_in_use).unwrap();
    assert_same(&used.extrinsics, &twin.in_use().extrinsics);
    assert_eq!(used.generation, generation);
    assert_same_estimate(&mut cal, &twin);
    run(&mut cal, &mut twin, &set, 6..13);
    assert_eq!(get!(cal, selfcal_state), Ok(SELFCAL_STATE_LOCKED));
    assert_eq!(snapshot(&mut cal), snapshot_of(&twin));
}

#[test]
fn a_record_of_another_capacity_is_restored() {
    let set = recorded();
    let factory = FactoryCalibration::guess(set.cameras().unwrap());
    let mut small = Box::new(Calibrator::<f32, 64>::new(Config::default(), &factory));
    for index in 0..5 {
        small.take_pair(pair(&set, index).1).fused.unwrap();
    }
    let kept = small.snapshot();
    let mut cal = Cal::of(&set, None);
    assert_eq!(restore(&mut cal, &kept), SELFCAL_OK);
    assert_eq!(get!(cal, selfcal_state), Ok(SELFCAL_STATE_SUSPECT));
    small.restore(&kept).unwrap();
    let estimate = get!(cal, selfcal_proposal).unwrap();
    assert_same(&estimate.extrinsics, &small.proposal().unwrap().extrinsics);
}

#[test]
fn a_restore_drops_the_batch() {
    let mut cal = at_work();
    let kept = snapshot(&mut cal);
    let (all, _) = pair(&recorded(), 5);
    get!(cal, selfcal_push_array, all.as_ptr(), all.len()).unwrap();
    assert_eq!(restore(&mut cal, &kept), SELFCAL_OK);
    assert_eq!(get!(cal, selfcal_solve_pair), Err(SELFCAL_ERROR_TOO_FEW));
}

#[test]
fn factory_values_are_bit_identical_after_a_restart() {
    let set = recorded();
    // Rounded numbers: the library makes the rotation orthonormal and normalises t.
    let extrinsics = selfcal_extrinsics_t {
        rotation: [0.9998, 0.02, 0.0, -0.02, 0.9998, 0.0, 0.0, 0.0, 1.0],
        translation: [-0.12, 0.001, 0.0],
    };
    let given = selfcal_factory_t {
        extrinsics,
        is_guess: 0,
        yaw_sd_rad: 1e-3,
        baseline_m: 0.12,
        ..factory(&set)
    };
    let mut cal = Cal::made(None, &given);
    let made = to_record(&given);
    let rust = FactoryCalibration::<f32>::from_record(&made).unwrap();
    assert_same(&get!(cal, selfcal_in_use).unwrap().extrinsics, &rust.extrinsics);
    assert_eq!(rust.to_record(), *made);
    let mut twin = Box::new(Twin::new(Config::default(), &rust));
    run(&mut cal, &mut twin, &set, 0..5);
    let learnt = snapshot(&mut cal);

    let found = from_record(&made).unwrap();
    assert_eq!((found.is_guess, found.yaw_sd_rad, found.baseline_m), (0, 1e-3, 0.12));
    assert_eq!(to_record(&found), made);
    let mut next = Cal::made(None, &found);
    assert_eq!(restore(&mut next, &learnt), SELFCAL_OK, "of the same rig, bit for bit");
    // The record stores R as a rotation vector, so R is the same only to rounding.
    let [new, old] = [&mut next, &mut cal].map(|c| get!(c, selfcal_in_use).unwrap().extrinsics);
    assert_eq!(new.translation.map(f32::to_bits), old.translation.map(f32::to_bits));
    let apart = new.rotation.iter().zip(old.rotation).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f32::max) < 5e-7, "{new:?} {old:?}");
}
