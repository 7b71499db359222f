//! Match record: one correspondence on the wire.

use thiserror::Error;

use super::header::{FrameHeader, Scales};
use super::layout::{MAX_LEVEL, RECORD_BYTES, record_words};
use crate::batch::correspondence::Correspondence;
use crate::error::SCORE;
use crate::scalar::Scalar;

/// Largest encoded coordinate: 24 bits, exact in `f32`.
const MAX_COORDINATE: u32 = (1 << 24) - 1;

/// Encoded score of 1.
const FULL_SCORE: f32 = 65_535.0;

/// Correspondence in the integer units of the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MatchRecord {
    left: [u32; 2],
    right: [u32; 2],
    score: u16,
    level: u8,
}

/// Why a correspondence or the frame around it cannot be encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EncodeError {
    /// A coordinate is not finite, negative, or above 24 bits of coordinate steps. Drop the match.
    #[error("a coordinate is not within the 24 bits of a record")]
    Coordinate,
    /// The score is not within 0 to 1. Drop the match.
    #[error("the score is not within 0 to 1")]
    Score,
    /// No level of the header's pyramid has this grid step. Correct the header.
    #[error("no level of the header's pyramid has this grid step")]
    GridStep,
    /// The frame has as many records as its header counts. Finish it.
    #[error("the frame has as many records as its header counts")]
    Full,
    /// The frame has fewer records than its header counts. Push the others.
    #[error("{0} records of the frame are missing")]
    Missing(u16),
}

/// Why 16 bytes with a correct CRC are not a record of version 1. Correct the sender.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum RecordError {
    /// The pyramid level is above 15.
    #[error("pyramid level {0} is not within 0 to 15")]
    Level(u8),
    /// The reserved byte is not 0.
    #[error("the reserved byte is {0:#04x}, not 0")]
    Reserved(u8),
}

codes! {
    EncodeError { Coordinate = 1120, Score = SCORE, GridStep = 1122, Full = 1123, Missing = 1124 }
    RecordError { Level = 1130, Reserved = 1131 }
}

impl MatchRecord {
    /// Length on the wire, bytes.
    pub const BYTES: usize = RECORD_BYTES;

    /// Rounds a correspondence to the resolution of the wire.
    ///
    /// * `c`: coordinates and grid step in px.
    /// * `header`: header of the frame that carries the record; sets coordinate and grid steps.
    ///
    /// # Errors
    /// [`EncodeError`].
    pub fn encode(c: &Correspondence<f32>, header: &FrameHeader) -> Result<Self, EncodeError> {
        let scale = header.steps_per_px();
        let coordinate = |px: f32| {
            let steps = rounded(px, scale).filter(|&steps| steps <= MAX_COORDINATE);
            steps.ok_or(EncodeError::Coordinate)
        };
        let score = rounded(c.score, FULL_SCORE).and_then(|score| u16::try_from(score).ok());
        Ok(Self {
            left: [coordinate(c.left[0])?, coordinate(c.left[1])?],
            right: [coordinate(c.right[0])?, coordinate(c.right[1])?],
            score: score.ok_or(EncodeError::Score)?,
            level: header.level_of(c.grid_step).ok_or(EncodeError::GridStep)?,
        })
    }

    /// Encodes the record.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; RECORD_BYTES] {
        let [a0, a1, a2, _] = self.left[0].to_le_bytes();
        let [b0, b1, b2, _] = self.left[1].to_le_bytes();
        let [c0, c1, c2, _] = self.right[0].to_le_bytes();
        let [d0, d1, d2, _] = self.right[1].to_le_bytes();
        let [s0, s1] = self.score.to_le_bytes();
        [a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, s0, s1, self.level, 0]
    }

    /// Decodes a record.
    ///
    /// # Errors
    /// [`RecordError`].
    #[inline(always)]
    pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Result<Self, RecordError> {
        Self::from_words(record_words(bytes))
    }

    /// Decodes a record in words.
    #[inline(always)]
    pub(super) fn from_words([a, b, c, d]: [u32; 4]) -> Result<Self, RecordError> {
        let [s0, s1, level, reserved] = d.to_le_bytes();
        // Checks level and reserved byte at once.
        if d >> 16 > MAX_LEVEL.into() {
            let of_level = level > MAX_LEVEL;
            return Err(if of_level {
                RecordError::Level(level)
            } else {
                RecordError::Reserved(reserved)
            });
        }
        let coordinate = |bits: u32| bits & MAX_COORDINATE;
        Ok(Self {
            left: [coordinate(a), coordinate(a >> 24 | b << 8)],
            right: [coordinate(b >> 16 | c << 16), c >> 8],
            score: u16::from_le_bytes([s0, s1]),
            level,
        })
    }

    /// Correspondence in px, exact.
    ///
    /// * `header`: header of the frame that carried the record.
    #[must_use]
    pub fn decode(&self, header: &FrameHeader) -> Correspondence<f32> {
        self.scaled(&header.scales())
    }

    /// [`Self::decode`] with the scales of the header.
    #[inline(always)]
    pub(super) fn scaled(&self, scales: &Scales) -> Correspondence<f32> {
        let px = |steps: u32| f32::count(steps) * scales.px_per_step;
        let ([u_l, v_l], [u_r, v_r]) = (self.left, self.right);
        Correspondence {
            left: [px(u_l), px(v_l)],
            right: [px(u_r), px(v_r)],
            score: f32::from(self.score) / FULL_SCORE,
            grid_step: scales.grid_step_px(self.level),
        }
    }
}

/// `x * scale` rounded to the nearest integer; `None` if negative, above 32 bits or NaN.
#[expect(
    clippy::as_conversions,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "in range, and truncation is intended"
)]
fn rounded(x: f32, scale: f32) -> Option<u32> {
    // In `f64`, adding 0.5 does not round.
    let nearest = f64::from(x) * f64::from(scale) + 0.5;
    (nearest >= 0.5 && nearest < f64::from(u32::MAX)).then_some(nearest as u32)
}
