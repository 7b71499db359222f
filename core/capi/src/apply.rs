//! Changes of the calibration in use: apply, undo, freeze.

use crate::calibration::selfcal_calibration_t;
use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t};
use crate::pointer::Out;

/// Puts the estimate into use: `applicable` of the proposal. The generation changes if the calibration changes. Until
/// four pairs agree, `SELFCAL_ERROR_NO_ESTIMATE` and `SELFCAL_ERROR_NOT_LOCKED` are normal.
///
/// * `applied`: the calibration now in use; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_apply(
    cal: *mut selfcal_t,
    applied: *mut selfcal_calibration_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, applied) = unsafe { (exclusive(cal)?, Out::optional(applied)?) };
        applied.set((&instance.calibrator.apply()?).into());
        Ok(())
    })
}

/// Puts the calibration that the last effective `selfcal_apply` replaced back into use. A second call in a row has
/// nothing to undo. The estimate does not change.
///
/// * `restored`: the calibration now in use; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_undo(
    cal: *mut selfcal_t,
    restored: *mut selfcal_calibration_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, restored) = unsafe { (exclusive(cal)?, Out::optional(restored)?) };
        restored.set((&instance.calibrator.undo()?).into());
        Ok(())
    })
}

/// Freezes the estimate and the calibration in use, or releases both. While they are frozen, pairs are still solved,
/// and end with `SELFCAL_ERROR_FROZEN`. `selfcal_apply` and `selfcal_undo` return this error, too.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_set_frozen(cal: *mut selfcal_t, frozen: bool) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        unsafe { exclusive(cal) }?.calibrator.set_frozen(frozen);
        Ok(())
    })
}
