//! Pointers of the caller, checked before use.

use zerocopy::FromBytes;

use crate::error::selfcal_error_t::{self, *};

/// Reads an argument through a pointer. Any bits are a valid `T`; the caller checks their meaning.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn read<T: FromBytes + Copy>(from: *const T) -> Result<T, selfcal_error_t> {
    check(from)?;
    // SAFETY: not null, aligned, and any bits are a `T`.
    Ok(unsafe { from.read() })
}

/// Returns an array argument. If `count` is 0, the array is empty and the pointer may be null.
///
/// # Safety
/// The contract of the crate, for `count` elements.
pub(crate) unsafe fn read_array<'a, T: FromBytes>(
    from: *const T,
    count: usize,
) -> Result<&'a [T], selfcal_error_t> {
    if count == 0 {
        return Ok(&[]);
    }
    check(from)?;
    if count > isize::MAX.unsigned_abs() / size_of::<T>() {
        return Err(SELFCAL_ERROR_VALUE);
    }
    // SAFETY: not null, aligned, not longer than the address space, and any bits are a `T`.
    Ok(unsafe { core::slice::from_raw_parts(from, count) })
}

/// Place for a result.
pub(crate) struct Out<T>(*mut T);

impl<T> Out<T> {
    /// Returns the place for a result, after a check of its pointer.
    ///
    /// # Safety
    /// The contract of the crate, for as long as the value lives.
    pub(crate) unsafe fn checked(place: *mut T) -> Result<Self, selfcal_error_t> {
        check(place)?;
        Ok(Self(place))
    }

    /// Returns a place that may be null; if it is null, the result is dropped.
    ///
    /// # Safety
    /// As [`Out::checked`].
    pub(crate) unsafe fn optional(place: *mut T) -> Result<Self, selfcal_error_t> {
        if place.is_aligned() { Ok(Self(place)) } else { Err(SELFCAL_ERROR_ALIGNMENT) }
    }

    /// Writes the result, unless the place is null.
    pub(crate) fn set(self, value: T) {
        if !self.0.is_null() {
            // SAFETY: not null, aligned, and the caller's by the contract of the constructors.
            unsafe { self.0.write(value) }
        }
    }
}

/// Refuses a pointer that is null or misaligned.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), selfcal_error_t> {
    if pointer.is_null() {
        return Err(SELFCAL_ERROR_NULL);
    }
    if pointer.is_aligned() { Ok(()) } else { Err(SELFCAL_ERROR_ALIGNMENT) }
}
