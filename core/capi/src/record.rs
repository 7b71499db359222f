//! Records that outlast a loss of power: snapshots, and the factory calibration.

use stereo_selfcal::{Calibrator, FactoryCalibration, SnapshotError};

use crate::capacity::SELFCAL_CAPACITY;
use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t, shared};
use crate::pointer::{self, Out, read_array};

/// Length of the longest record of `selfcal_snapshot`, bytes, for any capacity.
pub const SELFCAL_SNAPSHOT_BYTES: usize = 4240;

/// Length of the longest record of `selfcal_factory_to_record`, bytes.
pub const SELFCAL_FACTORY_BYTES: usize = 184;

const _: () =
    assert!(SELFCAL_SNAPSHOT_BYTES == Calibrator::<f32, SELFCAL_CAPACITY>::SNAPSHOT_BYTES);
const _: () = assert!(SELFCAL_FACTORY_BYTES == FactoryCalibration::<f32>::MAX_BYTES);

/// Writes the length of a record, also of one that is longer than its buffer.
fn written(
    record: Result<&[u8], SnapshotError>,
    length: Out<usize>,
) -> Result<(), selfcal_error_t> {
    match record {
        Ok(record) => length.set(record.len()),
        Err(SnapshotError::Room { needed }) => length.set(needed),
        Err(_) => (),
    }
    Ok(record.map(|_| ())?)
}

/// Writes the state of the estimator and the extrinsics in use as a record for non-volatile memory.
/// Not included: cameras and factory extrinsics (see `selfcal_factory_to_record`), the batch, a
/// pair that is being solved.
///
/// The record has a version and a checksum, and the same bytes on every machine. Keep the previous
/// record until the new one is written: `selfcal_restore` detects one that a loss of power has cut
/// short.
///
/// * `buffer`: destination; `SELFCAL_SNAPSHOT_BYTES` are always sufficient. Up to that size, bytes
///   after the record are set to 0. May be null where `room` is 0.
/// * `room`: size of the buffer, bytes.
/// * `length`: length of the record, bytes; keep it with the record. `SELFCAL_ERROR_SNAPSHOT_ROOM`
///   sets it too; the buffer then holds no record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_snapshot(
    cal: *const selfcal_t,
    buffer: *mut u8,
    room: usize,
    length: *mut usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, length) = unsafe { (shared(cal)?, Out::checked(length)?) };
        // SAFETY: as above.
        let buffer = unsafe { pointer::buffer(buffer, room, SELFCAL_SNAPSHOT_BYTES) }?;
        written(instance.calibrator.snapshot(buffer), length)
    })
}

/// Restores a record: the extrinsics in use, and the estimate with its pairs. The rig may have changed
/// since: the state is `SELFCAL_STATE_SUSPECT` until a pair confirms the estimate.
///
/// Call it after cameras and factory extrinsics are set, and before the first pair. If it is
/// refused, the calibrator is unchanged and starts from the factory extrinsics.
///
/// * `record`: from `selfcal_snapshot`, also of another machine, another capacity or an older version.
/// * `length`: length that `selfcal_snapshot` set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_restore(
    cal: *mut selfcal_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, record) = unsafe { (exclusive(cal)?, read_array(record, length)?) };
        instance.calibrator.restore(record)?;
        instance.solved = None;
        Ok(())
    })
}

/// Writes cameras and factory extrinsics as a record, once, in production.
///
/// * `buffer`: destination; `SELFCAL_FACTORY_BYTES` are always sufficient. Up to that size, bytes
///   after the record are set to 0. May be null where `room` is 0.
/// * `room`: size of the buffer, bytes.
/// * `length`: length of the record, bytes; keep it with the record. `SELFCAL_ERROR_SNAPSHOT_ROOM`
///   sets it too; the buffer then holds no record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_to_record(
    cal: *const selfcal_t,
    buffer: *mut u8,
    room: usize,
    length: *mut usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, length) = unsafe { (shared(cal)?, Out::checked(length)?) };
        let calibrator = &instance.calibrator;
        let cameras = *calibrator.cameras().ok_or(SnapshotError::NoCameras)?;
        let factory = FactoryCalibration { cameras, extrinsics: *calibrator.factory() };
        // SAFETY: as above.
        let buffer = unsafe { pointer::buffer(buffer, room, SELFCAL_FACTORY_BYTES) }?;
        written(factory.to_record(buffer), length)
    })
}

/// Sets cameras and factory extrinsics from a record, at each start, and resets the calibrator.
/// Replaces `selfcal_set_cameras` and `selfcal_set_factory`; the values are bit-identical to those
/// written.
///
/// * `record`: from `selfcal_factory_to_record`.
/// * `length`: length that `selfcal_factory_to_record` set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_from_record(
    cal: *mut selfcal_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, record) = unsafe { (exclusive(cal)?, read_array(record, length)?) };
        let FactoryCalibration { cameras, extrinsics } = FactoryCalibration::from_record(record)?;
        instance.solved = None;
        instance.calibrator.set_cameras(cameras);
        instance.calibrator.set_factory(extrinsics);
        Ok(())
    })
}
