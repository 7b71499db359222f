//! Storage that begins with a mark, so that initialised storage is recognised.

use crate::error::selfcal_error_t::{self, *};
use crate::pointer::check;

/// Content of an initialised storage.
///
/// # Safety
/// `repr(C)`, and the first field is a `[u32; 3]`.
pub(crate) unsafe trait Marked: Sized {
    /// Name of the content: eight ASCII characters.
    const NAME: [u32; 2];

    /// Value of the first field: the name, and the size, which differs between most builds.
    const MAGIC: [u32; 3] = {
        let size = size_of::<Self>();
        assert!(size < 1 << 31);
        #[expect(clippy::cast_possible_truncation, reason = "asserted")]
        let size = size as u32;
        [Self::NAME[0], Self::NAME[1], size]
    };
}

/// Fails the build unless the content `M` fits into `Storage`, and `Storage` has a length of `bytes`.
pub(crate) const fn assert_fits<M: Marked, Storage>(bytes: usize) {
    assert!(size_of::<M>() <= size_of::<Storage>());
    assert!(align_of::<M>() <= align_of::<Storage>());
    assert!(size_of::<Storage>() == bytes);
}

/// Checks that a place is not null, is aligned, and has room for an `M`.
///
/// * `size`: size of the storage, bytes.
pub(crate) fn check_place<M: Marked>(place: *const M, size: usize) -> Result<(), selfcal_error_t> {
    check(place)?;
    if size < size_of::<M>() { Err(SELFCAL_ERROR_STORAGE_SIZE) } else { Ok(()) }
}

/// Returns the content of an initialised storage, exclusively.
///
/// # Safety
/// The contract of the crate, for a storage that is as large as `M`.
pub(crate) unsafe fn exclusive<'a, M: Marked>(place: *mut M) -> Result<&'a mut M, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    unsafe { check_magic(place) }?;
    // SAFETY: not null, aligned, and only an `M` carries the magic.
    Ok(unsafe { &mut *place })
}

/// Returns the content of an initialised storage, read only.
///
/// # Safety
/// As [`exclusive`].
pub(crate) unsafe fn shared<'a, M: Marked>(place: *const M) -> Result<&'a M, selfcal_error_t> {
    // SAFETY: the contract of the crate.
    unsafe { check_magic(place) }?;
    // SAFETY: as in `exclusive`.
    Ok(unsafe { &*place })
}

/// Checks that a storage begins with the mark of `M`.
///
/// # Safety
/// As [`exclusive`].
unsafe fn check_magic<M: Marked>(place: *const M) -> Result<(), selfcal_error_t> {
    check(place)?;
    // SAFETY: not null, aligned, large enough, and any bits are a `[u32; 3]`.
    let magic = unsafe { place.cast::<[u32; 3]>().read() };
    if magic == M::MAGIC { Ok(()) } else { Err(SELFCAL_ERROR_NOT_INITIALISED) }
}
