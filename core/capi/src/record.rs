//! Records that outlast a loss of power: snapshots, and the factory calibration.

use stereo_selfcal::{Calibrator, FactoryCalibration};

use crate::capacity::SELFCAL_CAPACITY;
use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t, shared};
use crate::pointer::{Out, read_array};

/// Length of a record of `selfcal_snapshot`, bytes, for any capacity.
pub const SELFCAL_SNAPSHOT_BYTES: usize = 400;

/// Length of a record of `selfcal_factory_to_record`, bytes.
pub const SELFCAL_FACTORY_BYTES: usize = 180;

const _: () =
    assert!(SELFCAL_SNAPSHOT_BYTES == Calibrator::<f32, SELFCAL_CAPACITY>::SNAPSHOT_BYTES);
const _: () = assert!(SELFCAL_FACTORY_BYTES == FactoryCalibration::<f32>::BYTES);

/// Writes the calibration in use, and the estimate as a prior, as a record for non-volatile memory: pose and covariance,
/// noise, vibration, and what is known of lens and mount. Not included: cameras and factory extrinsics (see
/// `selfcal_factory_to_record`), the batch, a pair that is being solved, the estimate of the paper preset.
///
/// The record has a layout number and a checksum, and the same bytes on every machine. Keep the previous
/// record until the new one is written: `selfcal_restore` detects one that a loss of power has cut
/// short.
///
/// * `record`: `SELFCAL_SNAPSHOT_BYTES`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_snapshot(
    cal: *const selfcal_t,
    record: *mut u8,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, place) =
            unsafe { (shared(cal)?, Out::<[u8; SELFCAL_SNAPSHOT_BYTES]>::checked(record.cast())?) };
        place.set({
            instance.given()?;
            instance.calibrator.snapshot()
        });
        Ok(())
    })
}

/// Replaces everything that has been learnt by a record: the calibration in use, and the estimate. The rig may have
/// changed since: the state is `SELFCAL_STATE_SUSPECT` until a pair confirms the estimate.
///
/// Call it after cameras and factory extrinsics are set. If it is refused, the calibrator is as after `selfcal_reset` and
/// starts from the factory extrinsics.
///
/// * `record`: from `selfcal_snapshot`, also of another machine or another capacity.
/// * `length`: bytes that were found; other than `SELFCAL_SNAPSHOT_BYTES` they are a damaged record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_restore(
    cal: *mut selfcal_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, record) = unsafe { (exclusive(cal)?, read_array(record, length)?) };
        instance.given()?;
        instance.forget_pair();
        Ok(instance.calibrator.restore(record)?)
    })
}

/// Writes cameras and factory extrinsics as a record, once, in production, with the deviation of the factory yaw and the
/// length of the baseline of the configuration.
///
/// * `record`: `SELFCAL_FACTORY_BYTES`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_to_record(
    cal: *const selfcal_t,
    record: *mut u8,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, place) =
            unsafe { (shared(cal)?, Out::<[u8; SELFCAL_FACTORY_BYTES]>::checked(record.cast())?) };
        place.set(instance.given()?.to_record());
        Ok(())
    })
}

/// Sets cameras and factory extrinsics from a record, at each start, the deviation of the factory yaw and the length of
/// the baseline in place of those of the configuration, and resets the calibrator. Replaces `selfcal_set_cameras` and
/// `selfcal_set_factory`; the values are bit-identical to those written.
///
/// * `record`: from `selfcal_factory_to_record`.
/// * `length`: bytes that were found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_from_record(
    cal: *mut selfcal_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, record) = unsafe { (exclusive(cal)?, read_array(record, length)?) };
        let factory = FactoryCalibration::from_record(record)?;
        instance.install(factory);
        Ok(())
    })
}
