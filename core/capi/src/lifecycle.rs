//! Start and reset of a calibrator.

use crate::capacity::SELFCAL_CAPACITY;
use crate::config::selfcal_config_t;
use crate::error::{selfcal_error_t, status};
use crate::instance::{Instance, Known, exclusive, place, selfcal_t};
use crate::pointer::{Out, read};

/// Storage that the library needs.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct selfcal_requirements_t {
    /// Size, bytes; at most `sizeof(selfcal_t)`.
    pub size: usize,
    /// Alignment, bytes.
    pub align: usize,
    /// Correspondences a pair.
    pub capacity: usize,
}

/// Reads the storage that the library needs, to size it at run time or to compare with the header.
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

/// Initialises a calibrator without cameras, at `R = I`, `t = (-1, 0, 0)`. Call it before all
/// others; it also restarts a calibrator in use.
///
/// * `cal`: a `selfcal_t`, or any storage of the required size and alignment.
/// * `size`: of the storage, bytes: `sizeof(selfcal_t)`.
/// * `config`: copied; null for the default.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_init(
    cal: *mut selfcal_t,
    size: usize,
    config: *const selfcal_config_t,
) -> selfcal_error_t {
    status(|| {
        let config = if config.is_null() {
            (stereo_selfcal::Config::default(), Known::DEFAULT)
        } else {
            // SAFETY: the caller keeps the contract of the crate.
            let config = unsafe { read(config) }?;
            (config.core()?, config.known()?)
        };
        // SAFETY: as above.
        unsafe { place(cal, size, config) }
    })
}

/// Returns to the factory extrinsics, releases a freeze, and forgets batch, report and fused pairs.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_reset(cal: *mut selfcal_t) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { exclusive(cal) }?;
        instance.forget_pair();
        instance.calibrator.reset();
        Ok(())
    })
}
