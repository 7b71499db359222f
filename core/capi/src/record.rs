//! Snapshots, which outlast a loss of power.

use stereo_selfcal::Calibrator;

use crate::capacity::SELFCAL_CAPACITY;
use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t, shared};
use crate::pointer::{Out, read_array};

/// Length of a record of `selfcal_snapshot`, bytes, for any capacity.
pub const SELFCAL_SNAPSHOT_BYTES: usize = 400;

const _: () =
    assert!(SELFCAL_SNAPSHOT_BYTES == Calibrator::<f32, SELFCAL_CAPACITY>::SNAPSHOT_BYTES);

/// Writes the calibration in use and the estimate as a record for non-volatile memory. The estimate is a prior: pose
/// and covariance, noise, vibration, and the knowledge of lens and mount. The record also contains the generation, the
/// calibration that `selfcal_undo` returns to, and whether the calibrator is frozen. It omits the factory calibration
/// (see `selfcal_factory_to_record`), the batch, and a pair that is being solved.
///
/// The record has a layout number and a checksum, and the same bytes on every machine. Keep the previous
/// record until the new one is written: `selfcal_restore` detects a record that a loss of power has cut
/// short.
///
/// * `record`: place for `SELFCAL_SNAPSHOT_BYTES` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_snapshot(
    cal: *const selfcal_t,
    record: *mut u8,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, place) =
            unsafe { (shared(cal)?, Out::<[u8; SELFCAL_SNAPSHOT_BYTES]>::checked(record.cast())?) };
        place.set(instance.calibrator.snapshot());
        Ok(())
    })
}

/// Replaces everything that has been learnt by the content of a record of `selfcal_snapshot`. The rig may have changed
/// since: a restored estimate is `SELFCAL_STATE_SUSPECT` until a pair confirms it.
///
/// Call it after `selfcal_init` with the same factory calibration. If the record is refused, the calibrator is in the
/// state after `selfcal_reset`: go on from the factory calibration.
///
/// * `record`: from `selfcal_snapshot`, also of another machine or another capacity.
/// * `length`: number of bytes that were found. A record of another length than `SELFCAL_SNAPSHOT_BYTES` is damaged.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_restore(
    cal: *mut selfcal_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, record) = unsafe { (exclusive(cal)?, read_array(record, length)?) };
        Ok(instance.calibrator.restore(record)?)
    })
}
