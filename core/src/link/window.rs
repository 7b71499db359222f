//! Sliding window of the stream that may hold a header.

use super::layout::{HEADER_BYTES, MAGIC};

/// Bytes since the earliest position that may start a header; at most one header length.
///
/// Invariant: the bytes held agree with the magic as far as it reaches.
#[derive(Debug, Clone)]
pub(super) struct Window {
    bytes: [u8; HEADER_BYTES],
    held: u8,
}

impl Window {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; HEADER_BYTES], held: 0 }
    }

    pub(super) fn held(&self) -> usize {
        self.held.into()
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.held == 0
    }

    /// The bytes, once they have the length of a header.
    #[inline(always)]
    pub(super) fn full(&self) -> Option<&[u8; HEADER_BYTES]> {
        (self.held() == HEADER_BYTES).then_some(&self.bytes)
    }

    /// Appends a byte; number of bytes dropped because no header starts with them.
    pub(super) fn push(&mut self, byte: u8) -> u8 {
        let mut dropped = 0;
        if MAGIC.get(self.held()).is_some_and(|&expected| expected != byte) {
            // The magic holds its first byte once: a header starts at this byte or later.
            dropped = self.held;
            self.held = 0;
            if byte != MAGIC[0] {
                return dropped.saturating_add(1);
            }
        }
        if let Some(place) = self.bytes.get_mut(usize::from(self.held)) {
            *place = byte;
            self.held = self.held.saturating_add(1);
        }
        dropped
    }

    /// Moves on to the next position that may start a header; number of bytes dropped.
    pub(super) fn slide(&mut self) -> u8 {
        let bytes = self.bytes;
        let held = self.held();
        self.held = 0;
        let rest = bytes.iter().take(held).skip(1);
        rest.fold(1, |dropped, &byte| self.push(byte).saturating_add(dropped))
    }
}
