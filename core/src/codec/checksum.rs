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

#[cfg(test)]
mod tests {
    use super::*;

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
