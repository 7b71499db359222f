//! Frame header.

use thiserror::Error;

use super::layout::{CRC_BYTES, HEADER_BYTES, MAGIC, MAX_LEVEL, RECORD_BYTES};
use crate::checksum;

const VERSION: u8 = 1;

/// Bits of the flags.
const DROPPED_BEFORE: u8 = 1;
const MORE_FOUND: u8 = 1 << 1;

/// Encoded pyramid ratio of 1.
const RATIO_ONE: u8 = 64;
const MAX_FRACTION_BITS: u8 = 8;
/// Resolution of the encoded grid step, 1/px.
const GRID_STEPS_PER_PX: f32 = 256.0;
/// Largest relative error at which a grid step still belongs to a level.
const GRID_STEP_TOLERANCE: f32 = 1.0 / 16.0;

/// Header of a frame: image data and the scale of its records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrameHeader {
    /// Time of exposure on the sender's clock, us. Not interpreted.
    pub timestamp_us: u64,
    /// Sequence number of the frame; wraps around.
    pub sequence: u32,
    /// Number of records in the frame.
    pub count: u16,
    /// Width and height of the left image, px; the right one may differ.
    pub image_size: [u16; 2],
    /// Grid step of level 0, 1/256 px: the spacing of match positions. 0 stands for the coordinate step.
    pub grid_step: u16,
    /// Fraction bits of the coordinates, 0 to 8: the coordinate step is `2^-fraction_bits` px.
    pub fraction_bits: u8,
    /// Ratio of the pixel size of a pyramid level to the pixel size of the level below, in units of 1/64; 64 to 255. It
    /// is 64 without a pyramid, and 77 for a ratio of 1.2.
    pub pyramid_ratio: u8,
    /// The sender dropped frames right before this one because the receiver did not read.
    pub dropped_before: bool,
    /// The sender found more matches than it sends.
    pub more_found: bool,
}

/// Why a header cannot be decoded or encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HeaderError {
    /// The bytes do not start with the magic. Try one byte further.
    #[error("the bytes do not start with the magic")]
    Magic,
    /// The header is damaged, or record bytes equal the magic by chance. Try one byte further.
    #[error("the CRC of the header is wrong")]
    Crc,
    /// The sender uses another version. Update sender or receiver.
    #[error("version {0} of the format; version 1 is supported")]
    Version(u8),
    /// The sender sets flags that version 1 does not define. Correct the sender.
    #[error("unknown flags: {0:#04x}")]
    Flags(u8),
    /// There are more than 8 fraction bits. Correct the sender.
    #[error("{0} fraction bits are not within 0 to 8")]
    FractionBits(u8),
    /// The pyramid ratio is below 64. Correct the sender.
    #[error("a pyramid ratio of {0}/64 is below 1")]
    PyramidRatio(u8),
}

codes! {
    HeaderError {
        Magic = 1110, Crc = 1111, Version = 1112, Flags = 1113, FractionBits = 1113, PyramidRatio = 1113,
    }
}

/// Scales of the records of a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scales {
    /// Coordinate step, px.
    pub(super) px_per_step: f32,
    /// Grid step of level 0, px.
    grid_step: f32,
    /// Ratio of the pixel size of a pyramid level to the pixel size of the level below.
    pyramid_ratio: f32,
}

impl Scales {
    /// Returns the grid step of a pyramid level, px.
    ///
    /// * `level`: 0 to 15; higher levels count as 15.
    #[inline(always)]
    pub(super) fn grid_step_px(&self, level: u8) -> f32 {
        (0..level.min(MAX_LEVEL)).fold(self.grid_step, |step, _| step * self.pyramid_ratio)
    }
}

impl FrameHeader {
    /// Length on the wire, bytes.
    pub const BYTES: usize = HEADER_BYTES;

    /// Encodes the header; its CRC is the last 4 bytes.
    ///
    /// # Errors
    /// [`HeaderError::FractionBits`], [`HeaderError::PyramidRatio`].
    pub fn encode(&self) -> Result<[u8; HEADER_BYTES], HeaderError> {
        self.check()?;
        let flag = |set: bool, bit: u8| if set { bit } else { 0 };
        let flags = flag(self.dropped_before, DROPPED_BEFORE) | flag(self.more_found, MORE_FOUND);
        let fields: [&[u8]; 8] = [
            &MAGIC,
            &[VERSION, flags, self.fraction_bits, self.pyramid_ratio],
            &self.sequence.to_le_bytes(),
            &self.count.to_le_bytes(),
            &self.grid_step.to_le_bytes(),
            &self.timestamp_us.to_le_bytes(),
            &self.image_size[0].to_le_bytes(),
            &self.image_size[1].to_le_bytes(),
        ];
        let mut bytes = [0; HEADER_BYTES];
        bytes.iter_mut().zip(fields.into_iter().flatten()).for_each(|(to, from)| *to = *from);
        if let Some((covered, crc)) = bytes.split_last_chunk_mut::<CRC_BYTES>() {
            *crc = checksum::of(covered).to_le_bytes();
        }
        Ok(bytes)
    }

    /// Decodes a header.
    ///
    /// # Errors
    /// [`HeaderError`]; the CRC is checked before the fields.
    #[rustfmt::skip]
    pub fn decode(bytes: &[u8; HEADER_BYTES]) -> Result<Self, HeaderError> {
        if !bytes.starts_with(&MAGIC) {
            return Err(HeaderError::Magic);
        }
        let [.., c0, c1, c2, c3] = *bytes;
        let covered = bytes.split_last_chunk::<CRC_BYTES>();
        let crc = u32::from_le_bytes([c0, c1, c2, c3]);
        if covered.map(|(covered, _)| checksum::of(covered)) != Some(crc) {
            return Err(HeaderError::Crc);
        }
        let [
            _, _, _, _, version, flags, fraction_bits, pyramid_ratio,
            s0, s1, s2, s3, c0, c1, g0, g1,
            t0, t1, t2, t3, t4, t5, t6, t7,
            w0, w1, h0, h1, ..
        ] = *bytes;
        if version != VERSION {
            return Err(HeaderError::Version(version));
        }
        if flags & !(DROPPED_BEFORE | MORE_FOUND) != 0 {
            return Err(HeaderError::Flags(flags));
        }
        let header = Self {
            timestamp_us: u64::from_le_bytes([t0, t1, t2, t3, t4, t5, t6, t7]),
            sequence: u32::from_le_bytes([s0, s1, s2, s3]),
            count: u16::from_le_bytes([c0, c1]),
            image_size: [u16::from_le_bytes([w0, w1]), u16::from_le_bytes([h0, h1])],
            grid_step: u16::from_le_bytes([g0, g1]),
            fraction_bits,
            pyramid_ratio,
            dropped_before: flags & DROPPED_BEFORE != 0,
            more_found: flags & MORE_FOUND != 0,
        };
        header.check().map(|()| header)
    }

    fn check(&self) -> Result<(), HeaderError> {
        if self.fraction_bits > MAX_FRACTION_BITS {
            return Err(HeaderError::FractionBits(self.fraction_bits));
        }
        if self.pyramid_ratio < RATIO_ONE {
            return Err(HeaderError::PyramidRatio(self.pyramid_ratio));
        }
        Ok(())
    }

    /// Returns the length of the whole frame on the wire, bytes.
    #[must_use]
    pub fn frame_bytes(&self) -> usize {
        HEADER_BYTES + usize::from(self.count) * RECORD_BYTES + CRC_BYTES
    }

    /// Returns the number of coordinate steps per pixel.
    #[inline(always)]
    pub(super) fn steps_per_px(&self) -> f32 {
        f32::from(1_u16 << self.fraction_bits.min(MAX_FRACTION_BITS))
    }

    /// Returns the scales of the records. A frame computes them once, because computing them for each record takes a
    /// tenth of the decoding time.
    #[inline(always)]
    pub(super) fn scales(&self) -> Scales {
        // A power of two, built without a division. The biased exponent of 1 is 127. The exponent lies above the 23
        // bits of the fraction.
        let px_per_step =
            f32::from_bits((127 - u32::from(self.fraction_bits.min(MAX_FRACTION_BITS))) << 23);
        let grid_step = match self.grid_step {
            0 => px_per_step,
            step => f32::from(step) / GRID_STEPS_PER_PX,
        };
        let pyramid_ratio = f32::from(self.pyramid_ratio) / f32::from(RATIO_ONE);
        Scales { px_per_step, grid_step, pyramid_ratio }
    }

    /// Returns the grid step of a pyramid level, px.
    ///
    /// * `level`: 0 to 15; higher levels count as 15.
    #[must_use]
    pub fn grid_step_px(&self, level: u8) -> f32 {
        self.scales().grid_step_px(level)
    }

    /// Returns the pyramid level with the nearest grid step; `None` if the relative error exceeds 1/16.
    ///
    /// * `grid_step_px`: grid step, px. If the grid step of the header is 0, any step below the coordinate step counts
    ///   as level 0.
    #[must_use]
    pub fn level_of(&self, grid_step_px: f32) -> Option<u8> {
        let sent = match self.grid_step {
            0 if grid_step_px >= 0.0 => grid_step_px.max(self.grid_step_px(0)),
            _ => grid_step_px,
        };
        let error = |level: u8| {
            let step = self.grid_step_px(level);
            (step - sent).abs() / step
        };
        let levels = (0..=MAX_LEVEL).map(|level| (level, error(level)));
        let (level, error) = levels.min_by(|(_, a), (_, b)| a.total_cmp(b))?;
        (error <= GRID_STEP_TOLERANCE).then_some(level)
    }
}
