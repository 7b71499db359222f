//! The header of a frame.

use thiserror::Error;

use super::crc::FrameCrc;
use super::record::Record;
use crate::checksum;

/// The bytes every frame starts with.
pub(super) const MAGIC: [u8; 4] = *b"SCMF";
const VERSION: u8 = 1;

const DROPPED_BEFORE: u8 = 1;
const MORE_FOUND: u8 = 1 << 1;

/// A pyramid ratio of 1.
const RATIO_ONE: u8 = 64;
const MAX_FRACTION_BITS: u8 = 8;
/// Steps of the grid's step in a pixel.
const STEPS_PER_PX: f32 = 256.0;

/// The last level of a pyramid; the first is 0.
pub(super) const MAX_LEVEL: u8 = 15;

/// What a frame says of its records.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FrameHeader {
    /// When the images were taken: the sender's clock, us. Not interpreted.
    pub timestamp_us: u64,
    /// Number of the frame; wraps around.
    pub sequence: u32,
    /// Records in the frame.
    pub count: u16,
    /// Width and height of both images, px.
    pub image_size: [u16; 2],
    /// Step of the grid that matches of level 0 were found on, 1/256 px; 0: the step of the wire.
    pub grid_step: u16,
    /// Fraction bits of the coordinates, 0 to 8: the step of the wire is `2^-fraction_bits` px.
    pub fraction_bits: u8,
    /// Size of a pixel of a pyramid level over that of the level below, 64 to 255, 1/64: 64 without a
    /// pyramid, 77 for 1.2.
    pub pyramid_ratio: u8,
    /// The sender dropped frames right before this one: nobody read them.
    pub dropped_before: bool,
    /// The sender found more matches than it sends.
    pub more_found: bool,
}

/// Why bytes are no header that is understood, or a header cannot be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum HeaderError {
    /// The bytes are not the start of a frame. Look one byte on.
    #[error("the bytes are not the start of a frame")]
    Magic,
    /// The header was damaged, or its first bytes stood there by chance. Look one byte on.
    #[error("the CRC of the header is wrong")]
    Crc,
    /// The sender speaks another version. Update the one or the other.
    #[error("frame of version {0}, only 1 is understood")]
    Version(u8),
    /// The sender sets flags that version 1 does not have. Correct the sender.
    #[error("unknown flags: {0:#04x}")]
    Flags(u8),
    /// Fraction bits: 0 to 8. Correct the sender.
    #[error("{0} fraction bits are not within 0 to 8")]
    FractionBits(u8),
    /// Pyramid ratio: 64 to 255. Correct the sender.
    #[error("a pyramid ratio of {0}/64 is below 1")]
    PyramidRatio(u8),
}

codes! {
    HeaderError {
        Magic = 1110, Crc = 1111, Version = 1112, Flags = 1113, FractionBits = 1114, PyramidRatio = 1115,
    }
}

impl FrameHeader {
    /// Length on the wire, bytes.
    pub const BYTES: usize = 32;

    /// As bytes on the wire, its CRC at their end.
    ///
    /// # Errors
    /// [`HeaderError::FractionBits`], [`HeaderError::PyramidRatio`].
    pub fn encode(&self) -> Result<[u8; Self::BYTES], HeaderError> {
        self.check()?;
        let flag = |set: bool, bit: u8| if set { bit } else { 0 };
        let flags = flag(self.dropped_before, DROPPED_BEFORE) | flag(self.more_found, MORE_FOUND);
        let mut bytes = [0; Self::BYTES];
        let parts: [&[u8]; 8] = [
            &MAGIC,
            &[VERSION, flags, self.fraction_bits, self.pyramid_ratio],
            &self.sequence.to_le_bytes(),
            &self.count.to_le_bytes(),
            &self.grid_step.to_le_bytes(),
            &self.timestamp_us.to_le_bytes(),
            &self.image_size[0].to_le_bytes(),
            &self.image_size[1].to_le_bytes(),
        ];
        fill(&mut bytes, parts.into_iter().flatten());
        if let Some((covered, crc)) = bytes.split_last_chunk_mut::<{ FrameCrc::BYTES }>() {
            *crc = checksum::of(covered).to_le_bytes();
        }
        Ok(bytes)
    }

    /// From bytes off the wire.
    ///
    /// # Errors
    /// [`HeaderError`]; the CRC is looked at before what it covers.
    #[rustfmt::skip]
    pub fn decode(bytes: &[u8; Self::BYTES]) -> Result<Self, HeaderError> {
        let [
            m0, m1, m2, m3, version, flags, fraction_bits, pyramid_ratio,
            s0, s1, s2, s3, c0, c1, g0, g1,
            t0, t1, t2, t3, t4, t5, t6, t7,
            w0, w1, h0, h1, covered @ ..
        ] = *bytes;
        if [m0, m1, m2, m3] != MAGIC {
            return Err(HeaderError::Magic);
        }
        let crc = u32::from_le_bytes(covered);
        if bytes.split_last_chunk::<{ FrameCrc::BYTES }>().map(|(b, _)| checksum::of(b)) != Some(crc) {
            return Err(HeaderError::Crc);
        }
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

    /// Length of the whole frame on the wire, bytes.
    #[must_use]
    pub fn frame_bytes(&self) -> usize {
        Self::BYTES + usize::from(self.count) * Record::BYTES + FrameCrc::BYTES
    }

    /// Steps of the wire in a pixel.
    #[inline(always)]
    pub(super) fn steps_per_px(&self) -> f32 {
        f32::from(1_u16 << self.fraction_bits.min(MAX_FRACTION_BITS))
    }

    /// Step of the grid that matches of a pyramid level were found on, px.
    ///
    /// * `level`: 0 to 15; what is above counts as 15.
    #[must_use]
    #[inline(always)]
    pub fn grid_step_px(&self, level: u8) -> f32 {
        let base = match self.grid_step {
            0 => 1.0 / self.steps_per_px(),
            step => f32::from(step) / STEPS_PER_PX,
        };
        let ratio = f32::from(self.pyramid_ratio) / f32::from(RATIO_ONE);
        (0..level.min(MAX_LEVEL)).fold(base, |step, _| step * ratio)
    }

    /// The pyramid level whose grid step is nearest; `None` if even that is off by more than a
    /// sixteenth.
    ///
    /// * `grid_step_px`: px. Where the header says the step of the wire, any finer one is that.
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
        (error <= 1.0 / 16.0).then_some(level)
    }
}

/// Writes `source` over the start of `target`.
fn fill<'a>(target: &mut [u8], source: impl Iterator<Item = &'a u8>) {
    for (to, from) in target.iter_mut().zip(source) {
        *to = *from;
    }
}
