//! What lies in the storage of a calibrator.

use stereo_selfcal::{Calibrator, Config, PairReport};

use crate::capacity::SELFCAL_CAPACITY;
use crate::code::selfcal_error_t;
use crate::marked::{self, Marked};
use crate::storage::selfcal_t;

/// A calibrator and its last pair.
#[repr(C)]
pub(crate) struct Instance {
    magic: [u32; 3],
    pub(crate) calibrator: Calibrator<f32, SELFCAL_CAPACITY>,
    pub(crate) solved: Option<Solved>,
}

// SAFETY: `repr(C)`, and the magic is the first field.
unsafe impl Marked for Instance {
    /// "SELFCAL1".
    const NAME: [u32; 2] = [0x5345_4C46, 0x4341_4C31];
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
    marked::judge(place, size)?;
    // SAFETY: not null, aligned and large enough. Field by field: the whole need not pass the stack.
    unsafe {
        (&raw mut (*place).calibrator).write(Calibrator::new(config));
        (&raw mut (*place).solved).write(None);
        (&raw mut (*place).magic).write(Instance::MAGIC);
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
    // SAFETY: the contract of the crate; storage is as large as `Instance`.
    unsafe { marked::exclusive(storage.cast()) }
}

/// The calibrator in a storage, to look at it.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn shared<'a>(
    storage: *const selfcal_t,
) -> Result<&'a Instance, selfcal_error_t> {
    // SAFETY: as above.
    unsafe { marked::shared(storage.cast()) }
}
