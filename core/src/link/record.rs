//! Match record: one correspondence on the wire.

use thiserror::Error;

use super::header::{FrameHeader, Scales};
use super::layout::{LEVEL_BITS, MAX_LEVEL, RECORD_BYTES, record_words};
use crate::batch::correspondence::Correspondence;
use crate::error::SCORE;
use crate::scalar::Scalar;

/// Largest encoded coordinate: 24 bits, exact in `f32`.
const MAX_COORDINATE: u32 = (1 << 24) - 1;

/// Largest track: 12 bits.
const MAX_TRACK: u16 = (1 << 12) - 1;

/// Encoded score of 1.
const FULL_SCORE: f32 = 65_535.0;

/// Correspondence in the integer units of the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct MatchRecord {
    left: [u32; 2],
    right: [u32; 2],
    score: u16,
    level: u8,
    track: u16,
}

/// Why a correspondence or the frame around it cannot be encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum EncodeError {
    /// A coordinate is not finite, is negative, or has more than 24 bits in coordinate steps. Drop the match.
    #[error("a coordinate is not within the 24 bits of a record")]
    Coordinate,
    /// The score is not within 0 to 1. Drop the match.
    #[error("the score is not within 0 to 1")]
    Score,
    /// No level of the header's pyramid has this grid step. Correct the header.
    #[error("no level of the header's pyramid has this grid step")]
    GridStep,
    /// The frame has all records that its header counts. Finish it.
    #[error("the frame has as many records as its header counts")]
    Full,
    /// The frame has fewer records than its header counts. Push the missing ones.
    #[error("{0} records of the frame are missing")]
    Missing(u16),
}

codes! {
    EncodeError { Coordinate = 1120, Score = SCORE, GridStep = 1122, Full = 1123, Missing = 1124 }
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
    /// [`EncodeError::Coordinate`], [`EncodeError::Score`], [`EncodeError::GridStep`].
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
            track: 0,
        })
    }

    /// Returns the record with the track of a match that a tracker follows.
    ///
    /// * `id`: number of the track; its low 12 bits are sent. If they are 0, the match is sent without a track.
    #[must_use]
    pub const fn with_track(self, id: u16) -> Self {
        Self { track: id & MAX_TRACK, ..self }
    }

    /// Returns the track of the match, up to 4095; 0 for a match without a track.
    #[must_use]
    pub const fn track(&self) -> u16 {
        self.track
    }

    /// Encodes the record.
    #[must_use]
    pub fn to_bytes(&self) -> [u8; RECORD_BYTES] {
        let [a0, a1, a2, _] = self.left[0].to_le_bytes();
        let [b0, b1, b2, _] = self.left[1].to_le_bytes();
        let [c0, c1, c2, _] = self.right[0].to_le_bytes();
        let [d0, d1, d2, _] = self.right[1].to_le_bytes();
        let [s0, s1] = self.score.to_le_bytes();
        let [l0, l1] = (u16::from(self.level) | self.track << LEVEL_BITS).to_le_bytes();
        [a0, a1, a2, b0, b1, b2, c0, c1, c2, d0, d1, d2, s0, s1, l0, l1]
    }

    /// Decodes a record. Any bytes are a valid record.
    #[must_use]
    #[inline(always)]
    pub fn from_bytes(bytes: &[u8; RECORD_BYTES]) -> Self {
        Self::from_words(record_words(bytes))
    }

    /// Decodes a record, given as words.
    #[inline(always)]
    pub(super) fn from_words([a, b, c, d]: [u32; 4]) -> Self {
        let [s0, s1, l0, l1] = d.to_le_bytes();
        let coordinate = |bits: u32| bits & MAX_COORDINATE;
        Self {
            left: [coordinate(a), coordinate(a >> 24 | b << 8)],
            right: [coordinate(b >> 16 | c << 16), c >> 8],
            score: u16::from_le_bytes([s0, s1]),
            level: l0 & MAX_LEVEL,
            track: u16::from_le_bytes([l0, l1]) >> LEVEL_BITS,
        }
    }

    /// Returns the correspondence. Its coordinates in px are exact.
    ///
    /// * `header`: header of the frame that carried the record.
    #[must_use]
    pub fn decode(&self, header: &FrameHeader) -> Correspondence<f32> {
        self.scaled(&header.scales())
    }

    /// Does the work of [`Self::decode`], with scales that are computed once per frame.
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

/// Returns `x * scale`, rounded to the nearest integer; `None` if the product is negative, NaN or beyond 32 bits.
#[expect(
    clippy::as_conversions,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "in range, and truncation is intended"
)]
fn rounded(x: f32, scale: f32) -> Option<u32> {
    // The sum is in `f64`: in `f32` it may round up to the next integer.
    let nearest = f64::from(x) * f64::from(scale) + 0.5;
    (nearest >= 0.5 && nearest < f64::from(u32::MAX)).then_some(nearest as u32)
}
