//! Pointers of the caller, checked before use.

use zerocopy::FromBytes;

use crate::error::selfcal_error_t::{self, *};

/// An argument behind a pointer. Its type takes any bits; its meaning is checked later.
///
/// # Safety
/// The contract of the crate.
pub(crate) unsafe fn read<T: FromBytes + Copy>(from: *const T) -> Result<T, selfcal_error_t> {
    check(from)?;
    // SAFETY: not null, aligned, and any bits are a `T`.
    Ok(unsafe { from.read() })
}

/// An array argument; null is an empty one where `count` is 0.
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
    /// # Safety
    /// The contract of the crate, for as long as the value lives.
    pub(crate) unsafe fn checked(place: *mut T) -> Result<Self, selfcal_error_t> {
        check(place)?;
        Ok(Self(place))
    }

    /// A place that may be null: the result is dropped then.
    ///
    /// # Safety
    /// As [`Out::checked`].
    pub(crate) unsafe fn optional(place: *mut T) -> Result<Self, selfcal_error_t> {
        if place.is_aligned() { Ok(Self(place)) } else { Err(SELFCAL_ERROR_ALIGNMENT) }
    }

    /// Writes the result.
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
