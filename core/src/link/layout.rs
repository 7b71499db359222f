//! Constants of the wire format that more than one part of it uses; `FORMAT.md` defines them.

/// First bytes of every frame.
pub(super) const MAGIC: [u8; 4] = *b"SCMF";

/// Length of a frame header, bytes.
pub(super) const HEADER_BYTES: usize = 32;
/// Length of a match record, bytes.
pub(super) const RECORD_BYTES: usize = 16;
/// Length of the CRC that ends headers and frames, bytes.
pub(super) const CRC_BYTES: usize = 4;

/// Highest pyramid level; the lowest is 0.
pub(super) const MAX_LEVEL: u8 = 15;
