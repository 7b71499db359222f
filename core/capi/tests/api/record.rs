//! Records are those of Rust, byte for byte.

use host_tests::data::Dataset;
use stereo_selfcal::{Calibrator, Config, FactoryCalibration};
use stereo_selfcal_capi::selfcal_error_t::{self, *};
use stereo_selfcal_capi::selfcal_state_t::*;
use stereo_selfcal_capi::*;

use crate::life::{
    Twin, assert_same, assert_same_estimate, change_what_is_in_use, push, take_pair, twins,
};
use crate::rig::{Cal, at_work, config, get, pair, recorded};

pub(crate) type Write = unsafe extern "C" fn(*const selfcal_t, *mut u8) -> selfcal_error_t;
pub(crate) type Read = unsafe extern "C" fn(*mut selfcal_t, *const u8, usize) -> selfcal_error_t;

pub(crate) fn record(cal: &mut Cal, write: Write, room: usize) -> Result<Vec<u8>, selfcal_error_t> {
    let mut buffer = vec![0xa5; room];
    // SAFETY: live objects.
    match unsafe { write(cal.ptr(), buffer.as_mut_ptr()) } {
        SELFCAL_OK => Ok(buffer),
        error => {
            assert!(buffer.iter().all(|byte| *byte == 0xa5));
            Err(error)
        }
    }
}

pub(crate) fn snapshot(cal: &mut Cal) -> Vec<u8> {
    record(cal, selfcal_snapshot, SELFCAL_SNAPSHOT_BYTES).unwrap()
}

pub(crate) fn read(cal: &mut Cal, read: Read, record: &[u8]) -> selfcal_error_t {
    // SAFETY: live objects.
    unsafe { read(cal.ptr(), record.as_ptr(), record.len()) }
}

pub(crate) fn restore(cal: &mut Cal, record: &[u8]) -> selfcal_error_t {
    read(cal, selfcal_restore, record)
}

fn snapshot_of(twin: &Twin) -> Vec<u8> {
    twin.snapshot().to_vec()
}

fn run(cal: &mut Cal, twin: &mut Twin, set: &Dataset, pairs: std::ops::Range<usize>) {
    for index in pairs {
        // SAFETY: live storage.
        assert_eq!(unsafe { selfcal_clear_pair(cal.ptr()) }, SELFCAL_OK);
        twin.discard_pair();
        push(cal, twin, set, index);
        take_pair(cal, twin);
        change_what_is_in_use(cal, twin);
    }
}

#[test]
fn a_restored_run_is_bit_identical_to_that_of_rust() {
    let set = recorded();
    let presets = [
        (config(selfcal_config_robust), Config::robust()),
        (config(selfcal_config_paper), Config::paper()),
    ];
    for (c, rust) in presets {
        let (mut cal, mut twin) = twins(&set, &c, rust);
        assert_eq!(snapshot(&mut cal), snapshot_of(&twin));
        run(&mut cal, &mut twin, &set, 0..6);
        let kept = snapshot(&mut cal);
        assert_eq!(kept, snapshot_of(&twin));

        let generation = twin.in_use().generation;
        (cal, twin) = twins(&set, &c, rust);
        assert_eq!(restore(&mut cal, &kept), SELFCAL_OK);
        twin.restore(&kept).unwrap();
        assert_same(&get!(cal, selfcal_in_use).unwrap(), &twin.in_use().extrinsics);
        assert_eq!(get!(cal, selfcal_generation), Ok(generation));
        assert_same_estimate(&mut cal, &twin);
        run(&mut cal, &mut twin, &set, 6..13);
        assert_eq!(get!(cal, selfcal_state), Ok(SELFCAL_STATE_LOCKED));
        assert_eq!(snapshot(&mut cal), snapshot_of(&twin));
    }
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
fn a_restore_drops_the_report() {
    let set = recorded();
    let mut cal = at_work();
    let kept = snapshot(&mut cal);
    let factory = record(&mut cal, selfcal_factory_to_record, SELFCAL_FACTORY_BYTES).unwrap();
    assert_eq!(read(&mut cal, selfcal_factory_from_record, &factory), SELFCAL_OK);
    assert_eq!(get!(cal, selfcal_report), Err(SELFCAL_ERROR_NO_REPORT));
    assert_eq!(get!(cal, selfcal_state), Ok(SELFCAL_STATE_ACQUIRING));

    let (all, _) = pair(&set, 5);
    get!(cal, selfcal_push_array, all.as_ptr(), all.len()).unwrap();
    // SAFETY: live storage.
    assert_eq!(unsafe { selfcal_solve_pair(cal.ptr()) }, SELFCAL_OK);
    assert_eq!(restore(&mut cal, &kept), SELFCAL_OK);
    assert_eq!(get!(cal, selfcal_fuse), Err(SELFCAL_ERROR_NO_REPORT));
}

#[test]
fn factory_values_are_bit_identical_after_a_restart() {
    let set = recorded();
    let mut cal = Cal::of(&set, None);
    // Rounded numbers: setting them again from floats could give other bits.
    let factory = selfcal_extrinsics_t {
        rotation: [0.9998, 0.02, 0.0, -0.02, 0.9998, 0.0, 0.0, 0.0, 1.0],
        translation: [-0.12, 0.001, 0.0],
    };
    // SAFETY: live objects.
    assert_eq!(unsafe { selfcal_set_factory(cal.ptr(), &factory) }, SELFCAL_OK);
    let made = record(&mut cal, selfcal_factory_to_record, SELFCAL_FACTORY_BYTES).unwrap();
    let found = FactoryCalibration::<f32>::from_record(&made).unwrap();
    assert_same(&get!(cal, selfcal_in_use).unwrap(), &found.extrinsics);
    assert_eq!(found.to_record(), *made);
    let guess = FactoryCalibration::guess(found.cameras);
    let mut twin = Box::new(Twin::new(Config::default(), &guess));
    twin.install(&found);
    run(&mut cal, &mut twin, &set, 0..5);
    let learnt = snapshot(&mut cal);

    let mut next = Cal::new(None);
    assert_eq!(read(&mut next, selfcal_factory_from_record, &made), SELFCAL_OK);
    assert_eq!(restore(&mut next, &learnt), SELFCAL_OK);
    // What was learnt is rounded to the numbers of the record.
    let [new, old] = [&mut next, &mut cal].map(|c| get!(c, selfcal_in_use).unwrap());
    assert_eq!(new.translation.map(f32::to_bits), old.translation.map(f32::to_bits));
    let apart = new.rotation.iter().zip(old.rotation).map(|(a, b)| (a - b).abs());
    assert!(apart.fold(0.0, f32::max) < 5e-7, "{new:?} {old:?}");
    let again = record(&mut next, selfcal_factory_to_record, SELFCAL_FACTORY_BYTES);
    assert_eq!(again, Ok(made));
}
