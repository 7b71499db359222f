//! The CRC of headers and frames: CRC-32 of IEEE 802.3, also known as CRC-32/ISO-HDLC.

use core::fmt;

use super::header::FrameHeader;
use super::record::Record;
use crate::codec::checksum::{self, Checksum};

/// The CRC that ends a frame: over the header without its own CRC, then over all records.
#[derive(Clone)]
pub struct FrameCrc(Checksum);

impl FrameCrc {
    /// Length on the wire, bytes.
    pub const BYTES: usize = 4;

    /// The CRC of a frame without records.
    ///
    /// * `header`: as it goes over the wire; its last four bytes do not enter.
    #[must_use]
    pub fn new(header: &[u8; FrameHeader::BYTES]) -> Self {
        let mut digest = checksum::begin();
        if let Some((covered, _)) = header.split_last_chunk::<{ Self::BYTES }>() {
            digest.update(covered);
        }
        Self(digest)
    }

    /// Takes in one more record.
    #[inline(always)]
    pub fn add(&mut self, record: &[u8; Record::BYTES]) {
        self.0.update(record);
    }

    /// The CRC of what has been taken in.
    #[must_use]
    pub fn value(&self) -> u32 {
        self.0.clone().finalize()
    }
}

impl fmt::Debug for FrameCrc {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "FrameCrc({:#010x})", self.value())
    }
}
