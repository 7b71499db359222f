//! The calibrator as C sees it, and its start.

use core::mem::MaybeUninit;

use crate::capacity::{
    SELFCAL_CAPACITY, SELFCAL_STORAGE_ALIGN, SELFCAL_STORAGE_SIZE, SELFCAL_STORAGE_WORDS,
};
use crate::code::{code, selfcal_error_t};
use crate::config::selfcal_config_t;
use crate::instance::{Instance, instance, place};
use crate::pointer::{Out, read};

/// A calibrator of one stereo rig. The caller owns it, statically or wherever it likes; it holds no
/// pointers and nothing needs to be released. One call at a time; calibrators are independent.
#[repr(C)]
pub struct selfcal_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_STORAGE_WORDS],
}

const _: () = assert!(size_of::<Instance>() <= size_of::<selfcal_t>());
const _: () = assert!(size_of::<selfcal_t>() == SELFCAL_STORAGE_SIZE);
const _: () = assert!(align_of::<Instance>() <= SELFCAL_STORAGE_ALIGN);

/// What the library was built for.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct selfcal_requirements_t {
    /// Bytes of storage that it really uses.
    pub size: usize,
    /// Alignment that it really needs, bytes.
    pub align: usize,
    /// Correspondences a pair.
    pub capacity: usize,
}

/// Says what the library was built for: to size storage at run time, or to compare with the header.
///
/// * `requirements`: the answer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_requirements(
    requirements: *mut selfcal_requirements_t,
) -> selfcal_error_t {
    code(|| {
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

/// Makes a calibrator without cameras, at `R = I`, `t = (-1, 0, 0)`. Comes before all other calls; on
/// a calibrator in use it begins anew.
///
/// * `cal`: a `selfcal_t`, or other storage that is large enough.
/// * `size`: of the storage, bytes: `sizeof(selfcal_t)`.
/// * `config`: copied; null for the default.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_init(
    cal: *mut selfcal_t,
    size: usize,
    config: *const selfcal_config_t,
) -> selfcal_error_t {
    code(|| {
        let config = if config.is_null() {
            stereo_selfcal::Config::default()
        } else {
            // SAFETY: the caller keeps the contract of the crate.
            unsafe { read(config) }?.core()?
        };
        // SAFETY: as above.
        unsafe { place(cal, size, config) }
    })
}

/// Back to the factory extrinsics: batch, report and fused pairs are forgotten. Not frozen any more.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_reset(cal: *mut selfcal_t) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { instance(cal) }?;
        instance.solved = None;
        instance.calibrator.reset();
        Ok(())
    })
}
