//! How storage that has been initialised is told from any other.

use crate::code::selfcal_error_t::{self, *};
use crate::pointer::check;

/// What lies in a storage, once it is initialised.
///
/// # Safety
/// `repr(C)`, and the first field is a `[u32; 3]`.
pub(crate) unsafe trait Marked: Sized {
    /// Eight letters.
    const NAME: [u32; 2];

    /// What the first field says: the name, and the size, for another build has another.
    const MAGIC: [u32; 3] = {
        let size = size_of::<Self>();
        assert!(size < 1 << 31);
        #[expect(clippy::cast_possible_truncation, reason = "asserted")]
        let size = size as u32;
        [Self::NAME[0], Self::NAME[1], size]
    };
}

/// Whether a value can be put there.
pub(crate) fn judge<M: Marked>(place: *const M, size: usize) -> Result<(), selfcal_error_t> {
    check(place)?;
    if size < size_of::<M>() { Err(SELFCAL_ERROR_STORAGE_SIZE) } else { Ok(()) }
}

/// What has been put there, to change it.
///
/// # Safety
/// The contract of the crate, for a storage that is as large as `M`.
pub(crate) unsafe fn exclusive<'a, M: Marked>(place: *mut M) -> Result<&'a mut M, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    unsafe { recognise(place) }?;
    // SAFETY: not null, aligned, and the magic is only there where an `M` has been put.
    Ok(unsafe { &mut *place })
}

/// What has been put there, to look at it.
///
/// # Safety
/// As [`exclusive`].
pub(crate) unsafe fn shared<'a, M: Marked>(place: *const M) -> Result<&'a M, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    unsafe { recognise(place) }?;
    // SAFETY: as in `exclusive`.
    Ok(unsafe { &*place })
}

/// # Safety
/// As [`exclusive`].
unsafe fn recognise<M: Marked>(place: *const M) -> Result<(), selfcal_error_t> {
    check(place)?;
    // SAFETY: not null, aligned, it begins with these, and any bits are a magic, if not the right one.
    let magic = unsafe { place.cast::<[u32; 3]>().read() };
    if magic == M::MAGIC { Ok(()) } else { Err(SELFCAL_ERROR_NOT_INITIALISED) }
}
