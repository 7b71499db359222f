//! Sliding window over the stream: the bytes that may belong to a header.

use super::layout::{HEADER_BYTES, MAGIC};
use crate::checksum;

/// The magic as a word, with its last byte in the low bits.
const WORD: u32 = u32::from_be_bytes(MAGIC);

/// Bit of [`Window::magics`] for a magic at the start of a full window.
const FULL: u32 = 1 << (HEADER_BYTES - MAGIC.len());

/// Bytes since the earliest position that may start a header; at most one header length.
///
/// A stream may contain a magic every four bytes. The window keeps a ring with a rolling checksum and the set of places
/// of the magic, so that it reads no byte again when it slides.
#[derive(Debug, Clone)]
pub(super) struct Window {
    /// The last bytes appended.
    ring: [u8; HEADER_BYTES],
    /// Number of bytes appended, modulo 256. The next byte goes to `next % HEADER_BYTES` in the ring.
    next: u8,
    /// Number of bytes since the first magic, whole or incomplete; at most [`HEADER_BYTES`].
    held: u8,
    /// Bit `i` is set if a magic ended `i` bytes ago.
    magics: u32,
    /// The last four bytes as a word, with the last byte in the low bits.
    last: u32,
    /// Rolling checksum of the ring.
    checksum: u32,
}

impl Window {
    pub(super) const fn new() -> Self {
        Self { ring: [0; HEADER_BYTES], next: 0, held: 0, magics: 0, last: 0, checksum: 0 }
    }

    /// Returns the number of bytes since the first magic, whole or incomplete.
    pub(super) fn held(&self) -> usize {
        self.held.into()
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.held == 0
    }

    /// Returns whether the window holds a header with a correct checksum.
    #[inline(always)]
    pub(super) fn is_header(&self) -> bool {
        self.held() == HEADER_BYTES
    }

    /// Returns the last 32 bytes, in order: the header if [`Self::is_header`] is true.
    pub(super) fn bytes(&self) -> [u8; HEADER_BYTES] {
        core::array::from_fn(|i| {
            let place = (usize::from(self.next) + i) % HEADER_BYTES;
            self.ring.get(place).copied().unwrap_or_default()
        })
    }

    /// Appends bytes to a window that is not full. It stops after a byte that completes a header, or after a byte at
    /// which no begun header remains.
    ///
    /// * `within_frame`: if true, it does not stop where no begun header remains.
    #[inline(always)]
    pub(super) fn take(&mut self, bytes: impl Iterator<Item = u8>, within_frame: bool) -> Taken {
        // Local variables: with fields, each store to the ring would store and load the other fields, too.
        let (mut next, mut magics) = (self.next, self.magics);
        let (mut last, mut checksum) = (self.last, self.checksum);
        let mut taken = Taken { bytes: 0, bad_headers: 0 };
        for byte in bytes {
            let place = self.ring.get_mut(usize::from(next) % HEADER_BYTES);
            let old = place.map_or(0, |place| core::mem::replace(place, byte));
            next = next.wrapping_add(1);
            checksum = checksum::roll(checksum, byte, old);
            last = last << 8 | u32::from(byte);
            magics = magics << 1 | u32::from(last == WORD);
            taken.bytes += 1;
            if magics & FULL != 0 {
                if checksum == checksum::ROLLED_CORRECT {
                    break;
                }
                magics &= !FULL;
                taken.bad_headers += 1;
            }
            if !within_frame && magics == 0 && begun(last) == 0 {
                break;
            }
        }
        (self.next, self.magics, self.last, self.checksum) = (next, magics, last, checksum);
        self.hold();
        taken
    }

    /// Moves on from a header to the next position that may start one.
    pub(super) fn slide(&mut self) {
        self.magics &= !FULL;
        self.hold();
    }

    /// Sets the number of held bytes. The held bytes begin with the first magic, whole or incomplete.
    #[inline(always)]
    fn hold(&mut self) {
        self.held = match self.magics.leading_zeros().to_le_bytes() {
            [32, ..] => begun(self.last),
            [zeros, ..] => 35_u8.saturating_sub(zeros),
        };
    }
}

/// Result of one call of [`Window::take`].
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    pub(super) bytes: usize,
    /// Number of headers with a wrong checksum.
    pub(super) bad_headers: u32,
}

/// Returns the number of leading bytes of the magic that the last bytes match, 0 to 3; 0 for the whole magic. The first
/// byte of the magic occurs in it only once, so at most one number matches.
fn begun(last: u32) -> u8 {
    let is = |bytes: u32| last & ((1 << (8 * bytes)) - 1) == WORD >> (u32::BITS - 8 * bytes);
    if is(3) {
        3
    } else if is(2) {
        2
    } else {
        u8::from(is(1))
    }
}
