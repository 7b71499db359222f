//! How many correspondences a pair holds, and the storage that takes.

/// Correspondences a pair has room for; a full batch selects.
#[cfg(feature = "capacity-1024")]
pub const SELFCAL_CAPACITY: usize = 1024;

/// Correspondences a pair has room for; a full batch selects.
#[cfg(all(feature = "capacity-512", not(feature = "capacity-1024")))]
pub const SELFCAL_CAPACITY: usize = 512;

/// Correspondences a pair has room for; a full batch selects.
#[cfg(all(
    feature = "capacity-128",
    not(any(feature = "capacity-512", feature = "capacity-1024"))
))]
pub const SELFCAL_CAPACITY: usize = 128;

/// Correspondences a pair has room for; a full batch selects.
#[cfg(all(
    feature = "capacity-64",
    not(any(feature = "capacity-128", feature = "capacity-512", feature = "capacity-1024"))
))]
pub const SELFCAL_CAPACITY: usize = 64;

/// Correspondences a pair has room for; a full batch selects.
#[cfg(not(any(
    feature = "capacity-64",
    feature = "capacity-128",
    feature = "capacity-512",
    feature = "capacity-1024"
)))]
pub const SELFCAL_CAPACITY: usize = 256;

/// Storage in words of 8 bytes: the same for every target, so with a little to spare.
pub const SELFCAL_STORAGE_WORDS: usize = 448 + 5 * SELFCAL_CAPACITY / 2;

/// Storage, bytes.
pub const SELFCAL_STORAGE_SIZE: usize = 8 * SELFCAL_STORAGE_WORDS;

/// Alignment of the storage that is enough on every target, bytes.
pub const SELFCAL_STORAGE_ALIGN: usize = 8;
