//! Constants of the wire format that several modules use; `FORMAT.md` defines them.

/// First bytes of every frame.
pub(super) const MAGIC: [u8; 4] = *b"SCMF";

/// Length of a frame header, bytes.
pub(super) const HEADER_BYTES: usize = 32;
/// Length of a match record, bytes.
pub(super) const RECORD_BYTES: usize = 16;
/// Length of the CRC that ends headers and frames, bytes.
pub(super) const CRC_BYTES: usize = 4;

/// Highest pyramid level; the lowest is 0.
pub(super) const MAX_LEVEL: u8 = (1 << LEVEL_BITS) - 1;
/// Bits of a pyramid level in a record; the track is above them.
pub(super) const LEVEL_BITS: u8 = 4;

/// Returns the words of a record, with the first byte of each word in the low bits. The CRC and the fields share these
/// words, because reading the record for each use takes a fifth more instructions. The code is written out, because at
/// opt-level "s" the compiler does not unroll a loop.
#[inline(always)]
pub(super) fn record_words(record: &[u8; RECORD_BYTES]) -> [u32; 4] {
    // The compiler loads a chunk of four bytes at once, and single bytes separately.
    match record.as_chunks().0 {
        [a, b, c, d] => [
            u32::from_le_bytes(*a),
            u32::from_le_bytes(*b),
            u32::from_le_bytes(*c),
            u32::from_le_bytes(*d),
        ],
        _ => [0; 4],
    }
}
