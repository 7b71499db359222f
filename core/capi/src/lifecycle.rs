//! Start and reset of a calibrator.

use core::ffi::{CStr, c_char};

use crate::calibration::selfcal_calibration_t;
use crate::capacity::SELFCAL_CAPACITY;
use crate::config::selfcal_config_t;
use crate::details::selfcal_details_t;
use crate::error::{selfcal_error_t, status};
use crate::estimate::selfcal_proposal_t;
use crate::factory::{factory, selfcal_factory_t};
use crate::history::selfcal_event_t;
use crate::instance::{Instance, exclusive, place, selfcal_t};
use crate::pair::selfcal_outcome_t;
use crate::pointer::{Out, read};
use crate::push::selfcal_correspondence_t;
use crate::verdict::selfcal_verdict_t;

/// Version of the library.
const VERSION: &CStr =
    match CStr::from_bytes_with_nul(concat!(env!("CARGO_PKG_VERSION"), "\0").as_bytes()) {
        Ok(version) => version,
        Err(_) => c"",
    };

/// The number `SELFCAL_HEADER` of the header that belongs to this library: its version, and the sizes of its structs as
/// this compiler lays them out.
///
/// cbindgen:ignore
pub const SELFCAL_HEADER: u32 = version()
    .wrapping_add(weighed::<selfcal_config_t>(31))
    .wrapping_add(weighed::<selfcal_factory_t>(37))
    .wrapping_add(weighed::<selfcal_correspondence_t>(41))
    .wrapping_add(weighed::<selfcal_outcome_t>(43))
    .wrapping_add(weighed::<selfcal_proposal_t>(47))
    .wrapping_add(weighed::<selfcal_verdict_t>(53))
    .wrapping_add(weighed::<selfcal_event_t>(59))
    .wrapping_add(weighed::<selfcal_details_t>(61))
    .wrapping_add(weighed::<selfcal_calibration_t>(67));

/// Version of the library as a number: 1,000,000 major, 1,000 minor, patch.
const fn version() -> u32 {
    const fn number(text: &str) -> u32 {
        match u32::from_str_radix(text, 10) {
            Ok(number) => number,
            Err(_) => 0,
        }
    }
    let [major, minor, patch] = [
        number(env!("CARGO_PKG_VERSION_MAJOR")),
        number(env!("CARGO_PKG_VERSION_MINOR")),
        number(env!("CARGO_PKG_VERSION_PATCH")),
    ];
    major.wrapping_mul(1_000_000).wrapping_add(minor.wrapping_mul(1000)).wrapping_add(patch)
}

/// Size of a struct, times a weight that tells the structs apart.
#[expect(clippy::cast_possible_truncation, reason = "no struct has 4 GB")]
const fn weighed<T>(weight: u32) -> u32 {
    (size_of::<T>() as u32).wrapping_mul(weight)
}

/// Returns the version of the library as a text; never null. `selfcal_init` compares it with that of the header.
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
/// * `header`: `SELFCAL_HEADER`. A program that was compiled with the header of another version, or with structs of
///   other sizes, is refused.
/// * `config`: copied; null for the default.
/// * `factory`: copied. `selfcal_argument_string` says why `config` or `factory` is refused.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_init(
    cal: *mut selfcal_t,
    size: usize,
    header: u32,
    config: *const selfcal_config_t,
    factory: *const selfcal_factory_t,
) -> selfcal_error_t {
    status(|| {
        if header != SELFCAL_HEADER {
            return Err(selfcal_error_t::SELFCAL_ERROR_HEADER);
        }
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
