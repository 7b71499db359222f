//! Bytes of the stream that are not decoded yet.

use super::layout::{HEADER_BYTES, MAGIC};

/// The last bytes received: part of a header, of a record or of the CRC of a frame.
#[derive(Debug, Clone)]
pub(super) struct Held {
    bytes: [u8; HEADER_BYTES],
    count: u8,
}

impl Held {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; HEADER_BYTES], count: 0 }
    }

    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.count.into()
    }

    #[inline(always)]
    pub(super) fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.len()).unwrap_or_default()
    }

    /// Moves bytes from the front of `from`, until `wanted` bytes are held or `from` is empty. Returns whether `wanted`
    /// bytes are held.
    pub(super) fn fill(&mut self, from: &mut &[u8], wanted: usize) -> bool {
        let room = self.bytes.get_mut(self.count.into()..wanted).unwrap_or_default();
        let taken = room.len().min(from.len());
        room.iter_mut().zip(*from).for_each(|(place, byte)| *place = *byte);
        *from = from.get(taken..).unwrap_or_default();
        self.count = self.count.saturating_add(u8::try_from(taken).unwrap_or(u8::MAX));
        self.len() >= wanted
    }

    pub(super) fn clear(&mut self) {
        self.count = 0;
    }

    /// Drops bytes up to the next place that may start a header, and returns their number.
    ///
    /// * `from`: first place that is tested.
    pub(super) fn seek(&mut self, from: usize) -> usize {
        let held = self.bytes();
        let mut rest = held.get(from..).unwrap_or_default();
        while !rest.iter().zip(&MAGIC).all(|(byte, magic)| byte == magic) {
            rest = rest.get(1..).unwrap_or_default();
        }
        let (skipped, count) = (held.len().saturating_sub(rest.len()), rest.len());
        // `copy_within` could panic for a compiler that does not see that the places are within the array.
        let mut kept = [0; HEADER_BYTES];
        kept.iter_mut().zip(rest).for_each(|(place, byte)| *place = *byte);
        (self.bytes, self.count) = (kept, u8::try_from(count).unwrap_or(0));
        skipped
    }
}
