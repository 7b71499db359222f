//! A calibrator in storage of the caller.

use core::mem::MaybeUninit;

use stereo_selfcal::{Calibrator, Cameras, Config, FactoryCalibration, has_valid_lengths};

use crate::capacity::{
    SELFCAL_CAPACITY, SELFCAL_STORAGE_ALIGN, SELFCAL_STORAGE_SIZE, SELFCAL_STORAGE_WORDS,
};
use crate::error::selfcal_error_t;
use crate::marked::{self, Marked};

/// A calibrator of one stereo rig, owned by the caller, in static memory or elsewhere. It holds no
/// pointers and needs no release. One call at a time; calibrators are independent.
///
/// Each call detects two kinds of overwritten storage: changed first 12 bytes (name and size), and a length beyond its
/// array. Then it does nothing, and returns `SELFCAL_ERROR_NOT_INITIALISED`. Other wrong bits are not detected, and the
/// effect of a call is then undefined: protect the memory, or call `selfcal_init` again.
#[repr(C)]
pub struct selfcal_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_STORAGE_WORDS],
}

const _: () = marked::assert_fits::<Instance, selfcal_t>(SELFCAL_STORAGE_SIZE);
const _: () = assert!(align_of::<Instance>() <= SELFCAL_STORAGE_ALIGN);

/// Content of an initialised `selfcal_t`.
#[repr(C)]
pub(crate) struct Instance {
    magic: [u32; 3],
    /// The cameras of the factory calibration, without correction.
    pub(crate) cameras: Cameras<f32>,
    pub(crate) calibrator: Held,
}

/// The calibrator of an instance.
pub(crate) type Held = Calibrator<f32, SELFCAL_CAPACITY>;

// SAFETY: `repr(C)`, and the magic is the first field.
unsafe impl Marked for Instance {
    /// "SELFCAL1".
    const NAME: [u32; 2] = [0x5345_4C46, 0x4341_4C31];
}

/// Checks the storage and writes a new calibrator into it.
///
/// # Safety
/// `storage` is null or points to `size` bytes that the caller owns.
pub(crate) unsafe fn place(
    storage: *mut selfcal_t,
    size: usize,
    config: Config,
    factory: &FactoryCalibration<f32>,
) -> Result<(), selfcal_error_t> {
    let place = storage.cast::<Instance>();
    marked::check_place(place, size)?;
    // SAFETY: not null, aligned and large enough. Written field by field, so that the whole is not on the stack.
    unsafe {
        (&raw mut (*place).calibrator).write(Calibrator::new(config, factory));
        (&raw mut (*place).cameras).write(factory.cameras);
        (&raw mut (*place).magic).write(Instance::MAGIC);
    }
    Ok(())
}

/// Returns the calibrator in a storage, exclusively.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn exclusive<'a>(
    storage: *mut selfcal_t,
) -> Result<&'a mut Instance, selfcal_error_t> {
    // SAFETY: the contract of the crate; storage is as large as `Instance`.
    let instance: &mut Instance = unsafe { marked::exclusive(storage.cast()) }?;
    check_lengths(instance)?;
    Ok(instance)
}

/// Returns the calibrator in a storage, read only.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn shared<'a>(
    storage: *const selfcal_t,
) -> Result<&'a Instance, selfcal_error_t> {
    // SAFETY: as above.
    let instance: &Instance = unsafe { marked::shared(storage.cast()) }?;
    check_lengths(instance)?;
    Ok(instance)
}

/// Refuses lengths beyond their arrays, because an access would leave the storage.
fn check_lengths(instance: &Instance) -> Result<(), selfcal_error_t> {
    let valid = has_valid_lengths(&instance.calibrator);
    if valid { Ok(()) } else { Err(selfcal_error_t::SELFCAL_ERROR_NOT_INITIALISED) }
}
