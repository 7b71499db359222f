//! What lies in the storage, and how it is told from anything else.

use stereo_selfcal::{Calibrator, Config, PairReport};

use crate::capacity::SELFCAL_CAPACITY;
use crate::code::selfcal_error_t::{self, *};
use crate::storage::selfcal_t;

/// "SELFCAL1", and the size: another build has another.
const MAGIC: [u32; 3] = [0x5345_4C46, 0x4341_4C31, {
    let size = size_of::<Instance>();
    assert!(size < 1 << 31);
    #[expect(clippy::cast_possible_truncation, reason = "asserted")]
    let size = size as u32;
    size
}];

/// A calibrator and its last pair.
#[repr(C)]
pub(crate) struct Instance {
    magic: [u32; 3],
    pub(crate) calibrator: Calibrator<f32, SELFCAL_CAPACITY>,
    pub(crate) solved: Option<Solved>,
}

/// The last pair, once it is solved.
pub(crate) struct Solved {
    pub(crate) report: PairReport<f32>,
    /// The paper preset would count it again.
    pub(crate) fused: bool,
}

impl From<PairReport<f32>> for Solved {
    fn from(report: PairReport<f32>) -> Self {
        Self { report, fused: false }
    }
}

/// Checks the storage and puts a new calibrator into it.
///
/// # Safety
/// `storage` is null or points to `size` bytes that the caller owns.
pub(crate) unsafe fn place(
    storage: *mut selfcal_t,
    size: usize,
    config: Config,
) -> Result<(), selfcal_error_t> {
    let place = storage.cast::<Instance>();
    if place.is_null() {
        return Err(SELFCAL_ERROR_NULL);
    }
    if !place.is_aligned() {
        return Err(SELFCAL_ERROR_ALIGNMENT);
    }
    if size < size_of::<Instance>() {
        return Err(SELFCAL_ERROR_STORAGE_SIZE);
    }
    // SAFETY: not null, aligned and large enough. Field by field: the whole need not pass the stack.
    unsafe {
        (&raw mut (*place).calibrator).write(Calibrator::new(config));
        (&raw mut (*place).solved).write(None);
        (&raw mut (*place).magic).write(MAGIC);
    }
    Ok(())
}

/// The calibrator in a storage, to change it.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn instance<'a>(
    storage: *mut selfcal_t,
) -> Result<&'a mut Instance, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    unsafe { check(storage) }?;
    // SAFETY: the magic says that `place` has been here.
    Ok(unsafe { &mut *storage.cast::<Instance>() })
}

/// The calibrator in a storage, to look at it.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn shared<'a>(
    storage: *const selfcal_t,
) -> Result<&'a Instance, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    unsafe { check(storage) }?;
    // SAFETY: the magic says that `place` has been here.
    Ok(unsafe { &*storage.cast::<Instance>() })
}

/// # Safety
/// `storage` is null or points to an owned storage.
unsafe fn check(storage: *const selfcal_t) -> Result<(), selfcal_error_t> {
    let place = storage.cast::<Instance>();
    if place.is_null() {
        return Err(SELFCAL_ERROR_NULL);
    }
    if !place.is_aligned() {
        return Err(SELFCAL_ERROR_ALIGNMENT);
    }
    // SAFETY: any bits are a magic, if not the right one.
    let magic = unsafe { (&raw const (*place).magic).read() };
    if magic == MAGIC { Ok(()) } else { Err(SELFCAL_ERROR_NOT_INITIALISED) }
}
