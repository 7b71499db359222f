//! CRC-32 of IEEE 802.3 (CRC-32/ISO-HDLC): checksum of every record and frame.

/// Contribution of a byte to the register after this byte and 0 to 3 further bytes. With the four tables of 1,024 bytes
/// each, a word is processed at a time.
static AFTER: [[u32; 256]; 4] = [table(1, 1), table(1, 2), table(1, 3), table(1, 4)];

/// Running checksum.
#[derive(Debug, Clone)]
pub(crate) struct Checksum(u32);

/// Starts a checksum.
pub(crate) fn begin() -> Checksum {
    Checksum(u32::MAX)
}

impl Checksum {
    /// Adds bytes.
    pub(crate) fn update(&mut self, bytes: &[u8]) {
        let (words, rest) = bytes.as_chunks();
        for word in words {
            self.update_word(u32::from_le_bytes(*word));
        }
        for byte in rest {
            self.0 = self.0 >> 8 ^ after(0, low(self.0) ^ byte);
        }
    }

    /// Adds four bytes, the first in the low bits.
    #[inline(always)]
    pub(crate) fn update_word(&mut self, word: u32) {
        let [a, b, c, d] = (self.0 ^ word).to_le_bytes();
        self.0 = after(3, a) ^ after(2, b) ^ after(1, c) ^ after(0, d);
    }

    /// Returns the checksum of the bytes added so far.
    #[inline(always)]
    pub(crate) fn value(&self) -> u32 {
        !self.0
    }
}

/// Returns the checksum of `bytes`.
pub(crate) fn of(bytes: &[u8]) -> u32 {
    let mut checksum = begin();
    checksum.update(bytes);
    checksum.value()
}

/// Contribution of half a byte to the register after this half, for [`of_record`].
static AFTER_HALF: [u32; 16] = table(16, 1);

/// Returns the checksum of a record, computed half a byte at a time: records do not justify tables of 4 kB in flash.
#[inline(never)]
pub(crate) fn of_record(bytes: &[u8]) -> u32 {
    !bytes
        .iter()
        .fold(u32::MAX, |register, byte| after_half(after_half(register, byte & 15), byte >> 4))
}

/// Returns the register after half a byte.
fn after_half(register: u32, half: u8) -> u32 {
    let place = usize::from((low(register) ^ half) & 15);
    register >> 4 ^ AFTER_HALF.get(place).copied().unwrap_or(0)
}

/// Returns the contribution of a byte to the register after this byte and `more` further bytes, 0 to 3.
#[inline(always)]
fn after(more: usize, byte: u8) -> u32 {
    AFTER.get(more).and_then(|table| table.get(usize::from(byte))).copied().unwrap_or(0)
}

fn low(register: u32) -> u8 {
    let [low, ..] = register.to_le_bytes();
    low
}

/// Returns the contribution of each multiple of `unit` to the register after `bytes` bytes.
const fn table<const N: usize>(unit: u32, bytes: u32) -> [u32; N] {
    let mut table = [0; N];
    let (mut place, mut byte): (&mut [u32], u32) = (&mut table, 0);
    while let Some((first, rest)) = place.split_first_mut() {
        *first = shifted(byte, bytes);
        (place, byte) = (rest, byte + unit);
    }
    table
}

/// Returns a register after `bytes` zero bytes.
const fn shifted(mut register: u32, bytes: u32) -> u32 {
    let mut bits = 8 * bytes;
    while bits > 0 {
        let polynomial = if register & 1 == 1 { 0xedb8_8320 } else { 0 };
        register = register >> 1 ^ polynomial;
        bits -= 1;
    }
    register
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_checksum_matches_ethernet() {
        assert_eq!(of(b"123456789"), 0xcbf4_3926);
    }

    proptest! {
        #[test]
        fn bytes_in_two_parts_have_the_checksum_of_the_crc_crate(
            bytes in prop::collection::vec(any::<u8>(), 0..100), part: prop::sample::Index,
        ) {
            let (first, second) = bytes.split_at(part.index(bytes.len() + 1));
            let mut parts = begin();
            parts.update(first);
            parts.update(second);
            let expected = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC).checksum(&bytes);
            prop_assert_eq!([parts.value(), of(&bytes), of_record(&bytes)], [expected; 3]);
        }
    }
}
