//! The factory calibration, from which every estimate starts.

use core::ffi::{CStr, c_char};

use stereo_selfcal::{Cameras, FactoryCalibration};
use zerocopy::FromBytes;

use crate::camera::selfcal_camera_t;
use crate::config::{ConfigFault, selfcal_config_t};
use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::extrinsics::selfcal_extrinsics_t;
use crate::pointer::{Out, read, read_array};

/// Length of a record of `selfcal_factory_to_record`, bytes.
pub const SELFCAL_FACTORY_BYTES: usize = 180;

const _: () = assert!(SELFCAL_FACTORY_BYTES == FactoryCalibration::<f32>::BYTES);

/// Cameras and extrinsics of a rig as it left the factory, and the uncertainty of its calibration.
/// `{.left = left, .right = right}` is a guess: two cameras side by side.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_factory_t {
    /// Left camera.
    pub left: selfcal_camera_t,
    /// Right camera.
    pub right: selfcal_camera_t,
    /// Extrinsics of a calibration: `R` orthonormal to about 0.1, `t` of any length. All 0 stand for a guess: cameras
    /// side by side. The prior and the correction limit refer to these extrinsics, and `selfcal_reset` returns to them.
    pub extrinsics: selfcal_extrinsics_t,
    /// 1 if the extrinsics are a guess: the estimate then does not keep their yaw, and follows the yaw that the rows
    /// show. Otherwise 0.
    pub is_guess: u32,
    /// Standard deviation of the yaw of the extrinsics, rad, 1e-6 to 1. Depth relies on this yaw and on the turns since.
    /// 0 stands for 8.7e-4 (0.05 degrees), the standard deviation of a calibration with boards. Not used for a guess.
    pub yaw_sd_rad: f32,
    /// Length of the baseline, m, 1e-3 to 1e3; 0 if it is not known. `selfcal_push_range` needs it.
    pub baseline_m: f32,
}

impl selfcal_factory_t {
    /// Returns the factory calibration of the core, or the text of the fault. It checks all fields that are used,
    /// because the caller may have written any bits.
    pub(crate) fn core(&self) -> Result<FactoryCalibration<f32>, &'static CStr> {
        let left = self.left.core().map_err(|[left, _]| left)?;
        let right = self.right.core().map_err(|[_, right]| right)?;
        let factory = FactoryCalibration::new(Cameras { left, right }, self.extrinsics.core()?);
        let text = |error| ConfigFault::Parameter(error).text();
        let factory = match (self.is_guess, self.yaw_sd_rad) {
            (0, _) if self.extrinsics.is_zero() => factory.without_yaw(),
            (1, _) => factory.without_yaw(),
            (0, 0.0) => factory,
            (0, rad) => factory.with_yaw_sd_rad(rad).map_err(text)?,
            _ => return Err(c"is_guess is neither 0 nor 1"),
        };
        if self.baseline_m == 0.0 {
            return Ok(factory);
        }
        factory.with_baseline_m(self.baseline_m).map_err(text)
    }
}

impl From<&FactoryCalibration<f32>> for selfcal_factory_t {
    fn from(factory: &FactoryCalibration<f32>) -> Self {
        Self {
            left: (&factory.cameras.left).into(),
            right: (&factory.cameras.right).into(),
            extrinsics: (&factory.extrinsics).into(),
            is_guess: factory.yaw_sd_rad().is_none().into(),
            yaw_sd_rad: factory.yaw_sd_rad().unwrap_or_default(),
            baseline_m: factory.baseline_m().unwrap_or_default(),
        }
    }
}

/// Reads a factory calibration that is an argument of a call.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn factory(
    factory: *const selfcal_factory_t,
) -> Result<FactoryCalibration<f32>, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    let given = unsafe { read(factory) }?;
    given.core().map_err(|_| SELFCAL_ERROR_FACTORY)
}

/// Returns the English text of the parameter or quantity that `selfcal_init` refuses; never null. If both arguments
/// are valid, the text is `"no error"`. If both are refused, the text names the parameter of `config`.
///
/// * `config`, `factory`: each may be null. An argument that is null or misaligned is not checked.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_argument_string(
    config: *const selfcal_config_t,
    factory: *const selfcal_factory_t,
) -> *const c_char {
    // SAFETY: the caller keeps the contract of the crate.
    let (config, factory) = unsafe { (read(config).ok(), read(factory).ok()) };
    let config = config.and_then(|config| config.core().err()).map(|fault| fault.text());
    let factory = || factory.and_then(|factory| factory.core().err());
    config.or_else(factory).unwrap_or(c"no error").as_ptr()
}

/// Writes a factory calibration as a record. Call it once, in production.
///
/// * `record`: place for `SELFCAL_FACTORY_BYTES` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_to_record(
    factory: *const selfcal_factory_t,
    record: *mut u8,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (factory, place) = unsafe {
            (self::factory(factory)?, Out::<[u8; SELFCAL_FACTORY_BYTES]>::checked(record.cast())?)
        };
        place.set(factory.to_record());
        Ok(())
    })
}

/// Reads a factory calibration from a record. Call it at each start. A calibrator that is initialised with it has the
/// same cameras and factory extrinsics, bit for bit, as with the calibration that was written.
///
/// * `record`: from `selfcal_factory_to_record`.
/// * `length`: number of bytes that were found.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_factory_from_record(
    factory: *mut selfcal_factory_t,
    record: *const u8,
    length: usize,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (place, record) = unsafe { (Out::checked(factory)?, read_array(record, length)?) };
        place.set((&FactoryCalibration::from_record(record)?).into());
        Ok(())
    })
}
