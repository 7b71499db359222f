//! Start and reset of a calibrator.

use core::ffi::{CStr, c_char};

use crate::capacity::SELFCAL_CAPACITY;
use crate::config::selfcal_config_t;
use crate::error::{selfcal_error_t, status};
use crate::factory::{factory, selfcal_factory_t};
use crate::instance::{Instance, exclusive, place, selfcal_t};
use crate::pointer::{Out, read};

/// Version of the library.
const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };

/// Returns the version of the library as a text; never null. Compare it with `SELFCAL_VERSION` before `selfcal_init`: a
/// library of another version may read the storage and the configurations in another way.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_version() -> *const c_char {
    VERSION.as_ptr()
}

/// Storage that the library needs.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct selfcal_requirements_t {
    /// Size, bytes; at most `sizeof(selfcal_t)`.
    pub size: usize,
    /// Alignment, bytes.
    pub align: usize,
    /// Largest number of correspondences of a pair.
    pub capacity: usize,
}

/// Writes the size and alignment of the storage that the library needs, and its capacity. Use them to allocate the
/// storage at run time, or to compare the library with the header.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_requirements(
    requirements: *mut selfcal_requirements_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let requirements = unsafe { Out::checked(requirements) }?;
        requirements.set(selfcal_requirements_t {
            size: size_of::<Instance>(),
            align: align_of::<Instance>(),
            capacity: SELFCAL_CAPACITY,
        });
        Ok(())
    })
}

/// Initialises a calibrator at a factory calibration. Call it before all other functions of the calibrator. It also
/// restarts a calibrator in use, with the same or another factory calibration. The generation is 0 afterwards. Load the
/// rectifier with the calibration that `selfcal_in_use` returns.
///
/// * `cal`: a `selfcal_t`, or any storage of the required size and alignment.
/// * `size`: size of the storage, bytes: `sizeof(selfcal_t)`.
/// * `config`: copied; null for the default.
/// * `factory`: copied. `selfcal_argument_string` says why `config` or `factory` is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_init(
    cal: *mut selfcal_t,
    size: usize,
    config: *const selfcal_config_t,
    factory: *const selfcal_factory_t,
) -> selfcal_error_t {
    status(|| {
        let config = if config.is_null() {
            stereo_selfcal::Config::default()
        } else {
            // SAFETY: the caller keeps the contract of the crate.
            unsafe { read(config) }?.core()?
        };
        // SAFETY: as above.
        unsafe { place(cal, size, config, &self::factory(factory)?) }
    })
}

/// Puts the factory calibration back into use, releases a freeze, and forgets the batch and all fused pairs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_reset(cal: *mut selfcal_t) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        unsafe { exclusive(cal) }?.calibrator.reset();
        Ok(())
    })
}
