//! Records over a loss of power: what was learnt, and what it was learnt from.

use stereo_selfcal::{Calibrator, FactoryCalibration, SnapshotError};

use crate::capacity::SELFCAL_CAPACITY;
use crate::code::{code, selfcal_error_t};
use crate::instance::{instance, shared};
use crate::pointer::{Out, read_array, room};
use crate::storage::selfcal_t;

/// Length of the longest record of `selfcal_snapshot`, bytes; of any capacity.
pub const SELFCAL_SNAPSHOT_BYTES: usize = 2532;

/// Length of the longest record of `selfcal_factory_to_record`, bytes.
pub const SELFCAL_FACTORY_BYTES: usize = 160;

const _: () =
    assert!(SELFCAL_SNAPSHOT_BYTES == Calibrator::<f32, SELFCAL_CAPACITY>::SNAPSHOT_BYTES);
const _: () = assert!(SELFCAL_FACTORY_BYTES == FactoryCalibration::<f32>::MAX_BYTES);

/// Says how long a record has become, or would become if there were room.
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

/// Writes all that was learnt as a record, to be kept where power loss does not reach. Not in it: cameras
/// and factory extrinsics, see `selfcal_factory_to_record`; the batch, and a pair being solved.
///
/// The record is versioned, has its own checksum, and is the same on every machine. Keep the one before
/// until the new one is written: `selfcal_restore` recognises one that power loss has cut short.
///
/// * `buffer`: where to; `SELFCAL_SNAPSHOT_BYTES` are always enough. What the record leaves of these is
///   set to 0. May be null where `room` is 0.
/// * `room`: of the buffer, bytes.
/// * `length`: of the record, bytes; to be kept with it. Also set by `SELFCAL_ERROR_SNAPSHOT_ROOM`, after
///   which the buffer holds no record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_snapshot(
    cal: *const selfcal_t,
    buffer: *mut u8,
    room: usize,
    length: *mut usize,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, length) = unsafe { (shared(cal)?, Out::checked(length)?) };
        // SAFETY: as above.
        let buffer = unsafe { self::room(buffer, room, SELFCAL_SNAPSHOT_BYTES) }?;
        written(instance.calibrator.snapshot(buffer), length)
    })
}

/// Takes up where a record left off: what was in use is in use, and the pairs behind the estimate count,
/// as if there had been no break. But the rig may have changed meanwhile: the state is
/// `SELFCAL_STATE_SUSPECT` until a pair confirms the estimate.
///
/// For a calibrator that has learnt nothing yet, right after its cameras and factory extrinsics have been
/// set. Refused: it is as it was, and the rig starts from the factory.
///
/// * `record`: from `selfcal_snapshot`, also of another machine, another capacity or an older version.
/// * `length`: what `selfcal_snapshot` gave as such.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_restore(
    cal: *mut selfcal_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, record) = unsafe { (instance(cal)?, read_array(record, length)?) };
        instance.calibrator.restore(record)?;
        instance.solved = None;
        Ok(())
    })
}

/// Writes cameras and factory extrinsics as a record: once, in production.
///
/// * `buffer`: where to; `SELFCAL_FACTORY_BYTES` are always enough. What the record leaves of these is set
///   to 0. May be null where `room` is 0.
/// * `room`: of the buffer, bytes.
/// * `length`: of the record, bytes; to be kept with it. Also set by `SELFCAL_ERROR_SNAPSHOT_ROOM`, after
///   which the buffer holds no record.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_to_record(
    cal: *const selfcal_t,
    buffer: *mut u8,
    room: usize,
    length: *mut usize,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, length) = unsafe { (shared(cal)?, Out::checked(length)?) };
        let calibrator = &instance.calibrator;
        let cameras = *calibrator.cameras().ok_or(SnapshotError::NoCameras)?;
        let factory = FactoryCalibration { cameras, extrinsics: *calibrator.factory() };
        // SAFETY: as above.
        let buffer = unsafe { self::room(buffer, room, SELFCAL_FACTORY_BYTES) }?;
        written(factory.to_record(buffer), length)
    })
}

/// Sets cameras and factory extrinsics from a record, at each start; forgets all that was learnt. In the
/// place of `selfcal_set_cameras` and `selfcal_set_factory`, to the same bits as when it was written.
///
/// * `record`: from `selfcal_factory_to_record`.
/// * `length`: what it gave as such.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_from_record(
    cal: *mut selfcal_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, record) = unsafe { (instance(cal)?, read_array(record, length)?) };
        let FactoryCalibration { cameras, extrinsics } = FactoryCalibration::from_record(record)?;
        instance.solved = None;
        instance.calibrator.set_cameras(cameras);
        instance.calibrator.set_factory(extrinsics);
        Ok(())
    })
}
