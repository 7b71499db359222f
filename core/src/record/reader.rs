//! Decoder of records: bytes to finite numbers within their range.

use nalgebra::Vector3;

use super::{Kind, LAYOUT, MAGIC, believe};
use crate::checksum;
use crate::error::RestoreError;
use crate::geometry::extrinsics::Extrinsics;
use crate::scalar::Scalar;

/// Reader of a record with a correct checksum.
pub(super) struct Reader<'a> {
    rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Checks checksum, header and length; returns a reader behind the header, and the last two bytes of the header.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`], [`RestoreError::Foreign`], [`RestoreError::Layout`].
    pub(super) fn begin(
        record: &'a [u8],
        kind: Kind,
        length: usize,
    ) -> Result<(Self, [u8; 2]), RestoreError> {
        let (content, sum) = record.split_last_chunk().ok_or(RestoreError::Damaged)?;
        if checksum::of_record(content) != u32::from_le_bytes(*sum) {
            return Err(RestoreError::Damaged);
        }
        let mut reader = Self { rest: content };
        let [a, b, c, d, layout, found, x, y] = reader.bytes()?;
        if [a, b, c, d] != MAGIC {
            return Err(RestoreError::Foreign);
        }
        if layout != LAYOUT {
            return Err(RestoreError::Layout(layout));
        }
        if found != kind.number() {
            return Err(RestoreError::Foreign);
        }
        if record.len() != length {
            return Err(RestoreError::Damaged);
        }
        Ok((reader, [x, y]))
    }

    fn bytes<const B: usize>(&mut self) -> Result<[u8; B], RestoreError> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(RestoreError::Damaged)?;
        self.rest = rest;
        Ok(*bytes)
    }

    pub(super) fn word(&mut self) -> Result<u32, RestoreError> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    /// Reads a finite number.
    #[inline(never)]
    pub(super) fn number<T: Scalar>(&mut self) -> Result<T, RestoreError> {
        let number = f32::from_bits(self.word()?);
        believe(number.is_finite()).map(|()| T::single(number))
    }

    /// Reads a number from `least` to `most`.
    #[inline(never)]
    pub(super) fn within<T: Scalar>(&mut self, least: T, most: T) -> Result<T, RestoreError> {
        let number = self.number()?;
        // The bounds are rounded as the number was.
        let [low, high] = [least, most].map(|bound| T::single(bound.to_single()));
        believe((low..=high).contains(&number)).map(|()| number)
    }

    /// Reads numbers with a magnitude up to `most`.
    pub(super) fn numbers<T: Scalar, const K: usize>(
        &mut self,
        most: f32,
    ) -> Result<[T; K], RestoreError> {
        let mut numbers = [T::ZERO; K];
        self.fill(&mut numbers, most).map(|()| numbers)
    }

    #[inline(never)]
    fn fill<T: Scalar>(&mut self, numbers: &mut [T], most: f32) -> Result<(), RestoreError> {
        let most = T::single(most);
        for number in numbers {
            *number = self.within(-most, most)?;
        }
        Ok(())
    }

    /// Reads `R` row by row, then `t`.
    pub(super) fn extrinsics<T: Scalar>(&mut self) -> Result<Extrinsics<T>, RestoreError> {
        let (r, t) = (self.numbers(2.0)?, self.numbers(2.0)?);
        Extrinsics::from_row_major(r, t).map_err(|_| RestoreError::Absurd)
    }

    pub(super) fn vector<T: Scalar>(&mut self, most: f32) -> Result<Vector3<T>, RestoreError> {
        self.numbers::<T, 3>(most).map(Vector3::from)
    }
}
