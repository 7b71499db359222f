//! A calibration: extrinsics, and the cameras that they belong to.

use stereo_selfcal::Calibration;

use crate::camera::selfcal_camera_t;
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
    /// Right camera, as given; with `SELFCAL_LENS_TRACKING_COMPENSATE` it may be corrected.
    pub right: selfcal_camera_t,
    /// `p_r = R p_l + t`.
    pub extrinsics: selfcal_extrinsics_t,
    /// Number that changes whenever the calibration in use changes; it wraps around. A restored record may change the
    /// number alone.
    pub generation: u32,
}

impl From<&Calibration<f32>> for selfcal_calibration_t {
    fn from(calibration: &Calibration<f32>) -> Self {
        let Calibration { cameras, extrinsics, generation } = calibration;
        Self {
            left: (&cameras.left).into(),
            right: (&cameras.right).into(),
            extrinsics: extrinsics.into(),
            generation: *generation,
        }
    }
}

/// Reads the calibration in use; at first this is the factory calibration. Load the rectifier with it at start, and
/// again whenever its generation has changed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_in_use(
    cal: *const selfcal_t,
    calibration: *mut selfcal_calibration_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, calibration) = unsafe { (shared(cal)?, Out::checked(calibration)?) };
        calibration.set((&instance.calibrator.in_use()).into());
        Ok(())
    })
}
