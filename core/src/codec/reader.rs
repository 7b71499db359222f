//! Bytes to numbers, each of them finite.

use nalgebra::Rotation3;

use crate::codec::checksum;
use crate::error::RestoreError;
use crate::geometry::so3;
use crate::scalar::Scalar;

/// What the rows of a rotation may be off from orthonormal: rounding leaves 4e-7 in `f32`.
const ORTHONORMAL: f64 = 2e-6;

/// What turning sums may leave of a square below 0, in parts of the largest.
const TURNED: f64 = 1e-4;

/// Reads a record whose checksum is right.
pub(crate) struct Reader<'a> {
    rest: &'a [u8],
    pub(super) version: u8,
}

impl<'a> Reader<'a> {
    /// At the start of a record.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`] if the checksum at its end is not that of the rest.
    pub(super) fn checked(record: &'a [u8]) -> Result<Self, RestoreError> {
        let (rest, sum) = record.split_last_chunk().ok_or(RestoreError::Damaged)?;
        if checksum::of(rest) != u32::from_le_bytes(*sum) {
            return Err(RestoreError::Damaged);
        }
        Ok(Self { rest, version: 0 })
    }

    /// Version of the layout that the record was written in.
    pub(crate) fn version(&self) -> u8 {
        self.version
    }

    /// All that there should be has been read.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`] if something is left.
    pub(crate) fn end(&self) -> Result<(), RestoreError> {
        if self.rest.is_empty() { Ok(()) } else { Err(RestoreError::Damaged) }
    }

    pub(crate) fn bytes<const B: usize>(&mut self) -> Result<[u8; B], RestoreError> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(RestoreError::Damaged)?;
        self.rest = rest;
        Ok(*bytes)
    }

    pub(crate) fn word(&mut self) -> Result<u32, RestoreError> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    pub(crate) fn flag(&mut self) -> Result<bool, RestoreError> {
        match self.word()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(RestoreError::Absurd),
        }
    }

    pub(crate) fn number<T: Scalar>(&mut self) -> Result<T, RestoreError> {
        let mut bits = [0; 8];
        let (place, _) = bits.split_at_mut_checked(T::BYTES.into()).unwrap_or_default();
        let taken = self.rest.split_at_checked(place.len()).ok_or(RestoreError::Damaged)?;
        place.copy_from_slice(taken.0);
        self.rest = taken.1;
        let number = T::from_bits(u64::from_le_bytes(bits));
        if number.is_finite() { Ok(number) } else { Err(RestoreError::Absurd) }
    }

    pub(crate) fn numbers<'n, T: Scalar>(
        &mut self,
        numbers: impl IntoIterator<Item = &'n mut T>,
    ) -> Result<(), RestoreError> {
        for number in numbers {
            *number = self.number()?;
        }
        Ok(())
    }

    /// Numbers no further than `limit` from 0.
    pub(crate) fn numbers_within<'n, T: Scalar>(
        &mut self,
        limit: T,
        numbers: impl IntoIterator<Item = &'n mut T>,
    ) -> Result<(), RestoreError> {
        for number in numbers {
            *number = self.number()?;
            if number.abs() > limit {
                return Err(RestoreError::Absurd);
            }
        }
        Ok(())
    }

    /// A number that cannot be negative.
    pub(crate) fn size<T: Scalar>(&mut self) -> Result<T, RestoreError> {
        self.number().and_then(|x| if x >= T::ZERO { Ok(x) } else { Err(RestoreError::Absurd) })
    }

    pub(crate) fn rotation<T: Scalar>(&mut self) -> Result<Rotation3<T>, RestoreError> {
        let mut rotation = Rotation3::identity();
        let m = rotation.matrix_mut_unchecked();
        self.numbers(m.iter_mut())?;
        // Kept as it is, bit for bit, if it is one.
        let nearest = so3::nearest_rotation(m).ok_or(RestoreError::Absurd)?;
        if (nearest.matrix() - rotation.matrix()).amax() <= T::lit(ORTHONORMAL) {
            Ok(rotation)
        } else {
            Err(RestoreError::Absurd)
        }
    }
}

/// Whether these can be sums of squares that were turned, which may leave a small one below 0.
///
/// # Errors
/// [`RestoreError::Absurd`].
pub(crate) fn can_be_squares<T: Scalar>(
    diagonal: impl IntoIterator<Item = T>,
) -> Result<(), RestoreError> {
    let ends =
        diagonal.into_iter().fold([T::ZERO; 2], |[least, most], d| [least.min(d), most.max(d)]);
    let [least, most] = ends;
    if -least <= T::lit(TURNED) * most { Ok(()) } else { Err(RestoreError::Absurd) }
}
