//! Extrinsics and the cameras that they belong to, together.

use stereo_selfcal::Calibration;

use crate::camera::{in_use, selfcal_camera_t};
use crate::error::{selfcal_error_t, status};
use crate::extrinsics::selfcal_extrinsics_t;
use crate::instance::{selfcal_t, shared};
use crate::pointer::Out;

/// Extrinsics and the cameras that they belong to. With other cameras the extrinsics are wrong.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_calibration_t {
    /// Left camera, as given.
    pub left: selfcal_camera_t,
    /// Right camera, as given, or corrected with `SELFCAL_LENS_TRACKING_COMPENSATE`.
    pub right: selfcal_camera_t,
    /// `p_r = R p_l + t`.
    pub extrinsics: selfcal_extrinsics_t,
}

impl From<&Calibration<f32>> for selfcal_calibration_t {
    fn from(calibration: &Calibration<f32>) -> Self {
        let Calibration { cameras, extrinsics, .. } = calibration;
        Self {
            left: (&cameras.left).into(),
            right: (&cameras.right).into(),
            extrinsics: extrinsics.into(),
        }
    }
}

/// Reads the calibration in use: what a rectifier needs. `SELFCAL_ERROR_NO_CAMERAS` without cameras.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_calibration_in_use(
    cal: *const selfcal_t,
    calibration: *mut selfcal_calibration_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, calibration) = unsafe { (shared(cal)?, Out::checked(calibration)?) };
        calibration.set((&in_use(instance)?).into());
        Ok(())
    })
}
