//! The matcher's plain frame: a header, then fixed-point records; little endian, no padding.
//!
//! | header, 12 bytes | type | | record, 20 bytes | type | unit |
//! |---|---|---|---|---|---|
//! | magic `SCMF` | 4 bytes | | left `u`, `v` | 2 x `u32` | 1/256 px |
//! | version, 1 | `u8` | | right `u`, `v` | 2 x `u32` | 1/256 px |
//! | fraction bits, 8 | `u8` | | score | `u16` | 1/65535 |
//! | count of records | `u16` | | grid step | `u16` | 1/256 px |
//! | sequence number | `u32` | | | | |
//!
//! For a link without errors: the header is checked, the records are not. A flipped bit in a record
//! goes through as another pixel, and after a damaged header nothing finds the next frame.

use stereo_selfcal::{Correspondence, Scalar};
use thiserror::Error;
use zerocopy::little_endian::{U16, U32};
use zerocopy::{FromBytes, Immutable, IntoBytes, Unaligned, transmute};

const MAGIC: [u8; 4] = *b"SCMF";
const VERSION: u8 = 1;
const FRACTION_BITS: u8 = 8;

/// Steps of the fixed point in a pixel.
const STEPS: f32 = 256.0;

/// Step of the fixed point, px: no coordinate on the wire is finer.
pub const RESOLUTION_PX: f32 = 1.0 / STEPS;

/// Largest coordinate on the wire, steps: the last that `f32` holds without rounding.
const MAX_COORDINATE: u32 = (1 << 24) - 1;

/// A score of 1 on the wire.
const FULL_SCORE: f32 = 65_535.0;

/// Why a header was refused. Whatever follows it cannot be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// The bytes are not the start of a frame.
    #[error("no frame starts with {0:02x?}")]
    BadMagic([u8; 4]),
    /// The matcher speaks another version of the frame.
    #[error("frame of version {0}, only 1 is understood")]
    Version(u8),
    /// The matcher's coordinates have another resolution.
    #[error("coordinates with {0} fraction bits, only 8 are understood")]
    FractionBits(u8),
}

/// Which quantity of a correspondence does not fit a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum EncodeError {
    /// A coordinate is not within 0 to 65535.99 px.
    #[error("a coordinate is not within 0 to 65535.99 px")]
    Coordinate,
    /// The score is not within 0 to 1.
    #[error("the score is not within 0 to 1")]
    Score,
    /// The grid step is not within 0 to 255.99 px.
    #[error("the grid step is not within 0 to 255.99 px")]
    GridStep,
}

/// What the header says of the records that follow it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FrameHeader {
    /// Number of the frame; wraps around.
    pub sequence: u32,
    /// Records in the frame.
    pub count: u16,
}

#[derive(FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
struct WireHeader {
    magic: [u8; 4],
    version: u8,
    fraction_bits: u8,
    count: U16,
    sequence: U32,
}

impl FrameHeader {
    /// Length on the wire, bytes.
    pub const BYTES: usize = size_of::<WireHeader>();

    /// As bytes on the wire.
    #[must_use]
    pub fn encode(&self) -> [u8; Self::BYTES] {
        transmute!(WireHeader {
            magic: MAGIC,
            version: VERSION,
            fraction_bits: FRACTION_BITS,
            count: self.count.into(),
            sequence: self.sequence.into(),
        })
    }

    /// From bytes off the wire.
    ///
    /// # Errors
    /// [`FrameError`]: not the start of a frame that this version understands.
    pub fn decode(bytes: [u8; Self::BYTES]) -> Result<Self, FrameError> {
        let wire: WireHeader = transmute!(bytes);
        if wire.magic != MAGIC {
            return Err(FrameError::BadMagic(wire.magic));
        }
        if wire.version != VERSION {
            return Err(FrameError::Version(wire.version));
        }
        if wire.fraction_bits != FRACTION_BITS {
            return Err(FrameError::FractionBits(wire.fraction_bits));
        }
        Ok(Self { sequence: wire.sequence.get(), count: wire.count.get() })
    }
}

/// One correspondence on the wire. Any bytes are a record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, FromBytes, IntoBytes, Immutable, Unaligned)]
#[repr(C)]
pub struct Record {
    left: [U32; 2],
    right: [U32; 2],
    score: U16,
    grid_step: U16,
}

impl Record {
    /// A record of zero bytes, to be read over.
    pub const EMPTY: Self = Self {
        left: [U32::ZERO; 2],
        right: [U32::ZERO; 2],
        score: U16::ZERO,
        grid_step: U16::ZERO,
    };

    /// Rounds a correspondence to the resolution of the wire.
    ///
    /// # Errors
    /// [`EncodeError`]: a quantity is not finite or out of range.
    pub fn encode(c: &Correspondence<f32>) -> Result<Self, EncodeError> {
        let coordinate = |px: f32| {
            let steps = rounded(px, STEPS).filter(|&steps| steps <= MAX_COORDINATE);
            steps.map(U32::new).ok_or(EncodeError::Coordinate)
        };
        let short = |x: f32, scale: f32| rounded(x, scale).and_then(|n| u16::try_from(n).ok());
        let [left_u, left_v] = c.left;
        let [right_u, right_v] = c.right;
        Ok(Self {
            left: [coordinate(left_u)?, coordinate(left_v)?],
            right: [coordinate(right_u)?, coordinate(right_v)?],
            score: short(c.score, FULL_SCORE).ok_or(EncodeError::Score)?.into(),
            grid_step: short(c.grid_step, STEPS).ok_or(EncodeError::GridStep)?.into(),
        })
    }

    /// The correspondence, px; exact below 65536 px.
    #[must_use]
    pub fn decode(&self) -> Correspondence<f32> {
        let px = |steps: U32| f32::count(steps.get()) * RESOLUTION_PX;
        Correspondence {
            left: self.left.map(px),
            right: self.right.map(px),
            score: f32::from(self.score.get()) / FULL_SCORE,
            grid_step: f32::from(self.grid_step.get()) * RESOLUTION_PX,
        }
    }
}

/// `x * scale` rounded to the nearest integer; `None` if it is negative, beyond `u32`, or NaN.
#[expect(
    clippy::as_conversions,
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "in range, and cutting off the fraction is meant"
)]
fn rounded(x: f32, scale: f32) -> Option<u32> {
    // In f64, where adding the half does not itself round.
    let nearest = f64::from(x) * f64::from(scale) + 0.5;
    (nearest >= 0.5 && nearest < f64::from(u32::MAX)).then_some(nearest as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    prop_compose! {
        fn records()(
            pixels in prop::array::uniform4(0..=MAX_COORDINATE),
            score: u16,
            grid_step: u16,
        ) -> Record {
            let [a, b, c, d] = pixels.map(U32::new);
            Record { left: [a, b], right: [c, d], score: score.into(), grid_step: grid_step.into() }
        }
    }

    proptest! {
        #[test]
        fn a_header_comes_back_as_it_was_sent(sequence: u32, count: u16) {
            let header = FrameHeader { sequence, count };
            prop_assert_eq!(FrameHeader::decode(header.encode()), Ok(header));
        }

        #[test]
        fn a_quantised_correspondence_comes_back_bit_for_bit(record in records()) {
            prop_assert_eq!(Record::encode(&record.decode()), Ok(record));
        }

        #[test]
        fn a_correspondence_moves_by_half_a_step_at_most(
            left in prop::array::uniform2(0.0..4096.0_f32),
            right in prop::array::uniform2(0.0..4096.0_f32),
            score in 0.0..=1.0_f32,
            grid_step in 0.0..255.0_f32,
        ) {
            let sent = Correspondence { left, right, score, grid_step };
            let seen = Record::encode(&sent).unwrap().decode();
            let near = |a: f32, b: f32, step: f32| (a - b).abs() <= step * 0.5001;
            for (a, b) in sent.left.iter().chain(&sent.right).zip(seen.left.iter().chain(&seen.right)) {
                prop_assert!(near(*a, *b, RESOLUTION_PX));
            }
            prop_assert!(near(score, seen.score, 1.0 / FULL_SCORE));
            prop_assert!(near(grid_step, seen.grid_step, RESOLUTION_PX));
        }

        #[test]
        fn any_bytes_decode_to_finite_numbers(bytes: [u8; 20]) {
            let c = Record::read_from_bytes(&bytes).unwrap().decode();
            let [a, b] = c.left;
            let [d, e] = c.right;
            prop_assert!([a, b, d, e, c.score, c.grid_step].iter().all(|x| x.is_finite()));
            prop_assert!((0.0..=1.0).contains(&c.score));
        }
    }

    #[test]
    fn a_header_is_laid_out_as_documented() {
        let bytes = FrameHeader { sequence: 0x0403_0201, count: 0x0605 }.encode();
        assert_eq!(bytes, [b'S', b'C', b'M', b'F', 1, 8, 5, 6, 1, 2, 3, 4]);
    }

    #[test]
    fn a_record_is_laid_out_as_documented() {
        let sent =
            Correspondence { left: [1.0, 2.5], right: [256.0, 0.0], score: 1.0, grid_step: 0.5 };
        let record = Record::encode(&sent).unwrap();
        let left = [0, 1, 0, 0, 128, 2, 0, 0];
        let right = [0, 0, 1, 0, 0, 0, 0, 0];
        let score_and_step = [255, 255, 128, 0];
        assert_eq!(record.as_bytes(), [&left[..], &right, &score_and_step].concat());
    }

    #[test]
    fn a_foreign_header_is_refused_by_what_is_foreign_in_it() {
        let good = FrameHeader { sequence: 1, count: 2 }.encode();
        let with = |at: usize, value: u8| {
            let mut bytes = good;
            bytes[at] = value;
            FrameHeader::decode(bytes)
        };
        assert_eq!(with(3, b'X'), Err(FrameError::BadMagic(*b"SCMX")));
        assert_eq!(with(4, 2), Err(FrameError::Version(2)));
        assert_eq!(with(5, 4), Err(FrameError::FractionBits(4)));
    }

    #[test]
    fn what_does_not_fit_a_record_is_named() {
        let good = Correspondence { left: [1.0; 2], right: [1.0; 2], score: 1.0, grid_step: 1.0 };
        for bad in [-0.1, 65_536.0, f32::NAN, f32::INFINITY] {
            let coordinate = Correspondence { left: [1.0, bad], ..good };
            assert_eq!(Record::encode(&coordinate), Err(EncodeError::Coordinate), "{bad}");
            let score = Correspondence { score: bad, ..good };
            assert_eq!(Record::encode(&score), Err(EncodeError::Score), "{bad}");
            let grid_step = Correspondence { grid_step: bad, ..good };
            assert_eq!(Record::encode(&grid_step), Err(EncodeError::GridStep), "{bad}");
        }
    }
}
