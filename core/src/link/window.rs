//! Sliding window of the stream that may hold a header.

use super::layout::{HEADER_BYTES, MAGIC};
use crate::codec::checksum;

/// Bytes since the earliest position that may start a header; at most one header length.
///
/// The magic may begin in each fourth byte. So no byte is looked at again when the window slides: a ring, whose
/// checksum rolls on with each byte, and a set of the places of the magic.
#[derive(Debug, Clone)]
pub(super) struct Window {
    /// The last bytes appended.
    ring: [u8; HEADER_BYTES],
    /// Place of the next byte.
    next: u8,
    held: u8,
    /// Bit `i`: the magic ended `i` bytes ago.
    magics: u32,
    /// Bytes of the magic that the last bytes are, all four not counted.
    begun: u8,
    /// Rolling checksum of the ring.
    checksum: u32,
}

impl Window {
    pub(super) const fn new() -> Self {
        Self { ring: [0; HEADER_BYTES], next: 0, held: 0, magics: 0, begun: 0, checksum: 0 }
    }

    pub(super) fn held(&self) -> usize {
        self.held.into()
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.held == 0
    }

    /// Whether the bytes have the length of a header.
    #[inline(always)]
    pub(super) fn is_full(&self) -> bool {
        self.held() == HEADER_BYTES
    }

    /// Whether the checksum of a full window is correct: a header.
    pub(super) fn is_header(&self) -> bool {
        self.checksum == checksum::ROLLED_CORRECT
    }

    /// The bytes of a full window, in order.
    pub(super) fn bytes(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = self.ring;
        let (new, old) = self.ring.split_at_checked(self.place()).unwrap_or_default();
        bytes.iter_mut().zip(old.iter().chain(new)).for_each(|(to, from)| *to = *from);
        bytes
    }

    /// Appends a byte; number of bytes dropped because no header starts with them.
    #[inline(always)]
    pub(super) fn push(&mut self, byte: u8) -> u8 {
        let place = self.place();
        let old = self.ring.get_mut(place).map_or(0, |place| core::mem::replace(place, byte));
        self.next = self.next.wrapping_add(1);
        self.checksum = checksum::roll(self.checksum, byte, old);
        self.begun = match MAGIC.get(usize::from(self.begun)) {
            Some(expected) if *expected == byte => self.begun.wrapping_add(1),
            // The magic holds its first byte once.
            _ => u8::from(byte == MAGIC[0]),
        };
        self.magics <<= 1;
        if usize::from(self.begun) == MAGIC.len() {
            (self.begun, self.magics) = (0, self.magics | 1);
        }
        self.hold(self.held.saturating_add(1))
    }

    /// Moves on to the next position that may start a header; number of bytes dropped.
    pub(super) fn slide(&mut self) -> u8 {
        // A window is full by its first magic.
        self.magics &= !(1 << (HEADER_BYTES - MAGIC.len()));
        self.hold(self.held)
    }

    /// Holds the bytes from the first magic, or from the beginning of one; number of bytes dropped of `all`.
    #[inline(always)]
    fn hold(&mut self, all: u8) -> u8 {
        self.held = match self.magics.leading_zeros().to_le_bytes() {
            [32, ..] => self.begun,
            [zeros, ..] => 35_u8.saturating_sub(zeros),
        };
        all.saturating_sub(self.held)
    }

    fn place(&self) -> usize {
        usize::from(self.next) % HEADER_BYTES
    }
}
