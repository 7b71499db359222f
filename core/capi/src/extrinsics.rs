//! Extrinsics as plain numbers.

use nalgebra::{Matrix3, Vector3};
use stereo_selfcal::Extrinsics;
use zerocopy::FromBytes;

use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t, shared};
use crate::pointer::{Out, read};

/// `R` and unit `t` of `p_r = R p_l + t`. A plain side-by-side rig has `R = I`, `t = (-1, 0, 0)`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_extrinsics_t {
    /// `R`, left to right camera frame, row by row.
    pub rotation: [f32; 9],
    /// `t`: position of the left camera in the right camera frame. Unit length as a result, any
    /// length as an argument.
    pub translation: [f32; 3],
}

impl selfcal_extrinsics_t {
    pub(crate) fn core(&self) -> Result<Extrinsics<f32>, selfcal_error_t> {
        let [r11, r12, r13, r21, r22, r23, r31, r32, r33] = self.rotation;
        let r = Matrix3::new(r11, r12, r13, r21, r22, r23, r31, r32, r33);
        Ok(Extrinsics::try_new(&r, &Vector3::from(self.translation))?)
    }
}

impl From<&Extrinsics<f32>> for selfcal_extrinsics_t {
    fn from(extrinsics: &Extrinsics<f32>) -> Self {
        Self {
            rotation: extrinsics.rotation_row_major(),
            translation: extrinsics.translation().into_inner().into(),
        }
    }
}

/// Extrinsics of two parallel cameras side by side: `R = I`, `t = (-1, 0, 0)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_side_by_side(
    extrinsics: *mut selfcal_extrinsics_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        unsafe { Out::checked(extrinsics) }?.set((&Extrinsics::SIDE_BY_SIDE).into());
        Ok(())
    })
}

/// Sets the factory extrinsics and resets the calibrator. The prior and the correction limit refer to
/// them, and `selfcal_reset` returns to them.
///
/// * `factory`: `R` orthonormal to about 0.1, `t` of any length.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_set_factory(
    cal: *mut selfcal_t,
    factory: *const selfcal_extrinsics_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, factory) = unsafe { (exclusive(cal)?, read(factory)?) };
        let factory = factory.core()?;
        instance.set_factory(factory);
        Ok(())
    })
}

/// Reads the extrinsics in use. They belong to the cameras of `selfcal_calibration_in_use`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_in_use(
    cal: *const selfcal_t,
    extrinsics: *mut selfcal_extrinsics_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, extrinsics) = unsafe { (shared(cal)?, Out::checked(extrinsics)?) };
        extrinsics.set((&instance.calibrator.in_use().extrinsics).into());
        Ok(())
    })
}

/// Reads a counter that changes exactly when the calibration in use does; it wraps around.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_generation(
    cal: *const selfcal_t,
    generation: *mut u32,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, generation) = unsafe { (shared(cal)?, Out::checked(generation)?) };
        generation.set(instance.calibrator.in_use().generation);
        Ok(())
    })
}
