//! Errors of the store. `E`: error of the flash driver.

use core::fmt::Debug;

use thiserror::Error;

/// Why a store cannot be opened. Nothing was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum OpenError<E: Debug> {
    /// The range is reversed or ends beyond the flash. Correct it.
    #[error("the range is not within the flash")]
    OutOfBounds,
    /// The range holds fewer than two pages. Enlarge it, or use smaller pages.
    #[error("the range holds fewer than two pages")]
    TooFewPages,
    /// Start or page size is no multiple of the erase block, or the range no multiple of the page. Correct them.
    #[error("range and pages are not multiples of the erase block")]
    Unaligned,
    /// The flash holds records of another layout. Run the firmware that wrote them, or erase them with
    /// [`crate::store::Store::format`].
    #[error("the records are of another layout")]
    UnsupportedLayout,
    /// Erasing the flash failed. Try again.
    #[error("flash: {0:?}")]
    Flash(E),
}

/// Why a record cannot be loaded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum LoadError<E: Debug> {
    /// The buffer is smaller than the record. Offer `needed` bytes.
    #[error("the record takes {needed} bytes")]
    BufferTooSmall {
        /// Length of the record, bytes.
        needed: usize,
    },
    /// Repeated reads of the record differ, or every page reads as 00. Try again, or treat the record as lost.
    #[error("repeated reads of the record differ, or read as 00")]
    Unstable,
    /// Part of the flash cannot be read, and the rest holds no such record. Try again. If power was lost
    /// in the very first save, the error persists until the next save.
    #[error("flash: {0:?}")]
    Flash(E),
}

/// Why a record was not saved. The record saved before remains; after an error of the flash the new
/// record may be found instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SaveError<E: Debug> {
    /// A page does not hold two of each record, or the payload exceeds 65,535 bytes. Use larger pages.
    #[error("two of each record take {needed} bytes of a page, which has {page}")]
    TooLarge {
        /// Length of two of each record, bytes.
        needed: u32,
        /// Page size, bytes.
        page: u32,
    },
    /// Read-back differs from the data written or erased: the flash is worn out, locked or stuck. Try again later.
    #[error("read-back differs from the data written")]
    VerifyFailed,
    /// Every other page holds the only intact record of a kind, or a record or page found before is missing.
    /// Try again later; if it lasts: load the records, then [`crate::store::Store::format`].
    #[error("no page can be erased without losing a record")]
    NoPageToErase,
    /// Reading, writing or erasing the flash failed. Try again later.
    #[error("flash: {0:?}")]
    Flash(E),
}

/// Which parameter of a policy is out of range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum PolicyError {
    /// Shortest interval: above 0 and at most the longest.
    #[error("shortest interval must be above 0 and at most the longest")]
    ShortestInterval,
    /// Longest interval: at least the shortest.
    #[error("longest interval must be at least the shortest")]
    LongestInterval,
}
