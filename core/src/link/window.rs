//! The bytes that may be the start of a header.

use super::header::{FrameHeader, MAGIC};

/// Up to one header's length of the stream, from the first place on where a frame could start.
///
/// A window that slides over the stream, without the places that cannot be a start.
#[derive(Debug, Clone)]
pub(super) struct Window {
    bytes: [u8; FrameHeader::BYTES],
    held: u8,
}

impl Window {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; FrameHeader::BYTES], held: 0 }
    }

    pub(super) fn held(&self) -> usize {
        self.held.into()
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.held == 0
    }

    /// The bytes, once they are as many as a header has.
    #[inline(always)]
    pub(super) fn full(&self) -> Option<&[u8; FrameHeader::BYTES]> {
        (self.held() == FrameHeader::BYTES).then_some(&self.bytes)
    }

    /// Takes one more byte; how many were found to be no part of a header.
    pub(super) fn push(&mut self, byte: u8) -> u8 {
        // The magic's first byte is nowhere else in it: after a mismatch it starts here or later.
        if MAGIC.get(self.held()).is_some_and(|&expected| expected != byte) {
            let dropped = self.held;
            self.held = 0;
            if byte != MAGIC[0] {
                return dropped.saturating_add(1);
            }
            self.append(byte);
            return dropped;
        }
        self.append(byte);
        0
    }

    fn append(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(usize::from(self.held)) {
            *place = byte;
            self.held = self.held.saturating_add(1);
        }
    }

    /// On to the next place where a frame could start; how many bytes were dropped on the way.
    pub(super) fn slide(&mut self) -> u8 {
        let bytes = self.bytes;
        let held = self.held();
        self.held = 0;
        let mut dropped = 1;
        for &byte in bytes.iter().take(held).skip(1) {
            dropped = self.push(byte).saturating_add(dropped);
        }
        dropped
    }
}
