//! What is in use: changed, taken back, frozen.

use crate::code::{code, selfcal_error_t};
use crate::extrinsics::selfcal_extrinsics_t;
use crate::instance::{instance, shared};
use crate::pointer::Out;
use crate::storage::selfcal_t;

/// Puts the estimate into use. The generation changes if the extrinsics do.
///
/// * `applied`: what is in use now; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_apply(
    cal: *mut selfcal_t,
    applied: *mut selfcal_extrinsics_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, applied) = unsafe { (instance(cal)?, Out::optional(applied)?) };
        applied.set((&instance.calibrator.apply()?).into());
        Ok(())
    })
}

/// Puts back what was in use before the last change, once; the estimate stays.
///
/// * `restored`: what is in use now; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_undo(
    cal: *mut selfcal_t,
    restored: *mut selfcal_extrinsics_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, restored) = unsafe { (instance(cal)?, Out::optional(restored)?) };
        restored.set((&instance.calibrator.undo()?).into());
        Ok(())
    })
}

/// Freezes both the estimate and what is in use, or lets go of them again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_set_frozen(cal: *mut selfcal_t, frozen: bool) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        unsafe { instance(cal) }?.calibrator.set_frozen(frozen);
        Ok(())
    })
}

/// Whether the calibrator is frozen.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_is_frozen(
    cal: *const selfcal_t,
    frozen: *mut bool,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, frozen) = unsafe { (shared(cal)?, Out::checked(frozen)?) };
        frozen.set(instance.calibrator.is_frozen());
        Ok(())
    })
}
