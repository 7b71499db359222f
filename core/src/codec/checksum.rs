//! CRC-32 of IEEE 802.3 (CRC-32/ISO-HDLC): checksum of every record and frame.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

/// One table of 1,024 bytes, one byte at a time; sixteen at a time take 16 tables.
static CRC_32: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// Running checksum.
pub(crate) type Checksum = Digest<'static, u32, Table<1>>;

/// Starts a checksum.
pub(crate) fn begin() -> Checksum {
    CRC_32.digest()
}

/// Checksum of `bytes`.
pub(crate) fn of(bytes: &[u8]) -> u32 {
    CRC_32.checksum(bytes)
}

/// Bytes of a rolling checksum: a frame header with its own checksum.
const ROLLED_BYTES: u32 = 32;

/// Register of [`roll`] over bytes that end with the checksum of those before, whatever they are.
pub(crate) const ROLLED_CORRECT: u32 = shifted(shifted(u32::MAX, ROLLED_BYTES - 4) ^ u32::MAX, 4);

/// What a half of a byte leaves in the register after it has left the window: lower half, upper half.
static LEAVING: [[u32; 16]; 2] = [leaving(1), leaving(16)];

/// Moves a checksum over the last 32 bytes on by a byte. It starts with 0 over zeros.
///
/// * `old`: the byte 32 before `new`.
#[inline(always)]
pub(crate) fn roll(register: u32, new: u8, old: u8) -> u32 {
    let ([bytes], [lower, upper]) = (CRC_32.table(), &LEAVING);
    let [low, ..] = register.to_le_bytes();
    let parts = [
        bytes.get(usize::from(low ^ new)),
        lower.get(usize::from(old & 15)),
        upper.get(usize::from(old >> 4)),
    ];
    parts.into_iter().flatten().fold(register >> 8, |sum, part| sum ^ part)
}

const fn leaving(unit: u32) -> [u32; 16] {
    let mut table = [0; 16];
    let (mut place, mut byte): (&mut [u32], u32) = (&mut table, 0);
    while let Some((first, rest)) = place.split_first_mut() {
        *first = shifted(byte, ROLLED_BYTES + 1);
        (place, byte) = (rest, byte + unit);
    }
    table
}

/// A register after so many bytes of 0.
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

    #[test]
    fn a_rolling_checksum_is_correct_exactly_where_the_checksum_of_the_window_is() {
        let mut stream = [0_u8; 400];
        let mut seed = 1_u32;
        for byte in &mut stream {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *byte = seed.to_le_bytes()[3];
        }
        for end in [64, 65, 100, 333] {
            let sum = of(&stream[end - 32..end - 4]);
            stream[end - 4..end].copy_from_slice(&sum.to_le_bytes());
        }
        let (mut register, mut correct) = (0, 0);
        for end in 1..=stream.len() {
            let old = end.checked_sub(33).map_or(0, |at| stream[at]);
            register = roll(register, stream[end - 1], old);
            let window = stream[..end].split_last_chunk::<4>();
            let held = window.and_then(|(body, sum)| Some((body.last_chunk::<28>()?, sum)));
            let right = held.is_some_and(|(body, sum)| of(body) == u32::from_le_bytes(*sum));
            assert_eq!(register == ROLLED_CORRECT, right, "{end}");
            correct += u32::from(right);
        }
        // The second has overwritten the end of the first.
        assert_eq!(correct, 3);
    }

    #[test]
    fn the_checksum_is_that_of_ethernet_in_one_part_and_in_several() {
        assert_eq!(of(b"123456789"), 0xcbf4_3926);
        let mut parts = begin();
        parts.update(b"1234");
        parts.update(b"");
        parts.update(b"56789");
        assert_eq!(parts.finalize(), 0xcbf4_3926);
    }
}
