//! Why the store did not do what it was asked. `E`: what the driver of the flash says.

use core::fmt::Debug;

use thiserror::Error;

/// Why there is no store in a range of flash. Nothing was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum OpenError<E: Debug> {
    /// The range does not end after it starts, or ends beyond the flash. Correct it.
    #[error("the range is not within the flash")]
    OutOfBounds,
    /// The range holds fewer than two pages. Give it more, or smaller ones.
    #[error("the range holds fewer than two pages")]
    TooFewPages,
    /// The start or the page is not of whole erase blocks, or the range not of whole pages. Correct it.
    #[error("range and pages are not of whole erase blocks")]
    Unaligned,
    /// Records of another layout are there. Run the firmware that wrote them, or
    /// [`crate::store::Store::format`].
    #[error("the records are of another layout")]
    UnsupportedLayout,
    /// The flash could not be erased. Try again.
    #[error("flash: {0:?}")]
    Flash(E),
}

/// Why a record was not loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LoadError<E: Debug> {
    /// Offer a buffer of so many bytes.
    #[error("the record takes {needed} bytes")]
    BufferTooSmall {
        /// Bytes.
        needed: usize,
    },
    /// The record reads differently each time. Try again, or take what was there before for lost.
    #[error("the record reads differently each time")]
    Unstable,
    /// The flash could not be read everywhere, and no such record was found in what could be. Try again;
    /// where power was lost in the very first save, only the next save ends it.
    #[error("flash: {0:?}")]
    Flash(E),
}

/// Why a record was not saved. What was saved before is there still; the new record may be, if the
/// error is of the flash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError<E: Debug> {
    /// A page must hold two of each record, and nothing above 65,535 bytes. Open with larger pages.
    #[error("two of each record take {needed} bytes of a page, which has {page}")]
    TooLarge {
        /// Bytes of a page that two of each record take.
        needed: u32,
        /// Bytes of a page.
        page: u32,
    },
    /// What was read back is not what was written: the flash is worn out or locked. Try again later.
    #[error("what was read back is not what was written")]
    VerifyFailed,
    /// Every page that might be erased has the only intact record of another kind. Load what is
    /// needed, then [`crate::store::Store::format`].
    #[error("no page can be erased without losing a record")]
    NoPageToErase,
    /// The flash could not be read, written or erased. Try again later.
    #[error("flash: {0:?}")]
    Flash(E),
}

/// Which parameter of a policy was out of its range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PolicyError {
    /// Shortest interval: above 0, at most the longest.
    #[error("shortest interval must be above 0 and at most the longest")]
    ShortestInterval,
    /// Longest interval: at least the shortest.
    #[error("longest interval must be at least the shortest")]
    LongestInterval,
}
