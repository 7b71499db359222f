//! The one checksum of all that leaves the core as bytes: CRC-32 of IEEE 802.3.

use crc::{CRC_32_ISO_HDLC, Crc, Digest, Table};

/// A byte at a time: a table of 1,024 bytes; sixteen at a time would take 16 of them.
static CRC_32: Crc<u32, Table<1>> = Crc::<u32, Table<1>>::new(&CRC_32_ISO_HDLC);

/// A running checksum.
pub(crate) type Checksum = Digest<'static, u32, Table<1>>;

/// Of nothing yet.
pub(crate) fn begin() -> Checksum {
    CRC_32.digest()
}

/// Of these bytes.
pub(crate) fn of(bytes: &[u8]) -> u32 {
    CRC_32.checksum(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_checksum_is_the_one_of_ethernet() {
        assert_eq!(of(b"123456789"), 0xcbf4_3926);
        let mut parts = begin();
        parts.update(b"1234");
        parts.update(b"");
        parts.update(b"56789");
        assert_eq!(parts.finalize(), 0xcbf4_3926);
    }
}
