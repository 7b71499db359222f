//! CRC of a frame: CRC-32 of IEEE 802.3, also known as CRC-32/ISO-HDLC.

use core::fmt;

use super::layout::{CRC_BYTES, HEADER_BYTES, RECORD_BYTES, record_words};
use crate::checksum::{self, Checksum};

/// Running CRC of a frame. It covers the header without the header CRC, then all records.
#[derive(Clone)]
pub struct FrameCrc(Checksum);

impl FrameCrc {
    /// Length on the wire, bytes.
    pub const BYTES: usize = CRC_BYTES;

    /// Returns the CRC of a frame before its first record.
    ///
    /// * `header`: encoded header; its last 4 bytes, the header CRC, are left out.
    #[must_use]
    pub fn new(header: &[u8; HEADER_BYTES]) -> Self {
        let mut digest = checksum::begin();
        if let Some((covered, _)) = header.split_last_chunk::<CRC_BYTES>() {
            digest.update(covered);
        }
        Self(digest)
    }

    /// Adds one encoded record.
    #[inline(always)]
    pub fn add(&mut self, record: &[u8; RECORD_BYTES]) {
        self.add_words(record_words(record));
    }

    /// Adds one record, given as words.
    #[inline(always)]
    pub(super) fn add_words(&mut self, [a, b, c, d]: [u32; 4]) {
        self.0.update_word(a);
        self.0.update_word(b);
        self.0.update_word(c);
        self.0.update_word(d);
    }

    /// Returns the CRC of the header and the records added so far.
    #[must_use]
    pub fn value(&self) -> u32 {
        self.0.value()
    }
}

impl fmt::Debug for FrameCrc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FrameCrc({:#010x})", self.value())
    }
}
