//! Sliding window of the stream that may hold a header.

use super::layout::{HEADER_BYTES, MAGIC};
use crate::checksum;

/// The magic, its last byte lowest.
const WORD: u32 = u32::from_be_bytes(MAGIC);

/// The magic of a full window in [`Window::magics`].
const FULL: u32 = 1 << (HEADER_BYTES - MAGIC.len());

/// Bytes since the earliest position that may start a header; at most one header length.
///
/// Every fourth byte may begin the magic. To look at no byte again when the window slides, it keeps a ring with a
/// rolling checksum, and the set of places of the magic.
#[derive(Debug, Clone)]
pub(super) struct Window {
    /// The last bytes appended.
    ring: [u8; HEADER_BYTES],
    /// Place of the next byte.
    next: u8,
    held: u8,
    /// Bit `i`: the magic ended `i` bytes ago.
    magics: u32,
    /// The last four bytes, the last one lowest.
    last: u32,
    /// Rolling checksum of the ring.
    checksum: u32,
}

impl Window {
    pub(super) const fn new() -> Self {
        Self { ring: [0; HEADER_BYTES], next: 0, held: 0, magics: 0, last: 0, checksum: 0 }
    }

    /// Number of bytes since the first magic, whole or incomplete.
    pub(super) fn held(&self) -> usize {
        self.held.into()
    }

    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.held == 0
    }

    /// Whether the bytes are a header with a correct checksum.
    #[inline(always)]
    pub(super) fn is_header(&self) -> bool {
        self.held() == HEADER_BYTES
    }

    /// The bytes of a header, in order.
    pub(super) fn bytes(&self) -> [u8; HEADER_BYTES] {
        core::array::from_fn(|i| {
            let place = (usize::from(self.next) + i) % HEADER_BYTES;
            self.ring.get(place).copied().unwrap_or_default()
        })
    }

    /// Appends bytes to a window that is not full, up to the first byte that completes a header, or before which no
    /// header can start.
    ///
    /// * `within_frame`: continues where no header starts.
    #[inline(always)]
    pub(super) fn take(&mut self, bytes: impl Iterator<Item = u8>, within_frame: bool) -> Taken {
        // Local variables: a store to the ring would store and load the other fields for each byte.
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

    /// Holds the bytes from the first magic, or from the beginning of one.
    #[inline(always)]
    fn hold(&mut self) {
        self.held = match self.magics.leading_zeros().to_le_bytes() {
            [32, ..] => begun(self.last),
            [zeros, ..] => 35_u8.saturating_sub(zeros),
        };
    }
}

/// Bytes appended at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Taken {
    pub(super) bytes: usize,
    /// Places where a header with a wrong checksum starts.
    pub(super) bad_headers: u32,
}

/// Number of bytes of the magic that the last bytes match; 0 for all four. The magic holds its first byte once.
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
