//! Capacity of a pair, and the storage for it.

/// Largest number of correspondences in a batch. A full batch keeps a selection.
#[cfg(feature = "capacity-1024")]
pub const SELFCAL_CAPACITY: usize = 1024;

/// Largest number of correspondences in a batch. A full batch keeps a selection.
#[cfg(all(feature = "capacity-512", not(feature = "capacity-1024")))]
pub const SELFCAL_CAPACITY: usize = 512;

/// Largest number of correspondences in a batch. A full batch keeps a selection.
#[cfg(all(
    feature = "capacity-128",
    not(any(feature = "capacity-512", feature = "capacity-1024"))
))]
pub const SELFCAL_CAPACITY: usize = 128;

/// Largest number of correspondences in a batch. A full batch keeps a selection.
#[cfg(all(
    feature = "capacity-64",
    not(any(feature = "capacity-128", feature = "capacity-512", feature = "capacity-1024"))
))]
pub const SELFCAL_CAPACITY: usize = 64;

/// Largest number of correspondences in a batch. A full batch keeps a selection.
#[cfg(not(any(
    feature = "capacity-64",
    feature = "capacity-128",
    feature = "capacity-512",
    feature = "capacity-1024"
)))]
pub const SELFCAL_CAPACITY: usize = 256;

/// Size of `selfcal_t` in words of 8 bytes, sufficient on every target.
pub const SELFCAL_STORAGE_WORDS: usize = 644 + 23 * SELFCAL_CAPACITY / 8;

/// Size of `selfcal_t`, bytes.
pub const SELFCAL_STORAGE_SIZE: usize = 8 * SELFCAL_STORAGE_WORDS;

/// Alignment of `selfcal_t`, bytes, sufficient on every target.
pub const SELFCAL_STORAGE_ALIGN: usize = 8;
