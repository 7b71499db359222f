//! Decoder of records: bytes to finite numbers.
//!
//! Every method returns [`RestoreError::Damaged`] if the record is too short and
//! [`RestoreError::Absurd`] for a number that no writer produces.

use crate::codec::checksum;
use crate::error::RestoreError;
use crate::scalar::Scalar;

/// Rounding of a change of frame: a negative sum of squares over the largest sum.
pub(crate) const NEGATIVE: f64 = 1e-4;

/// Reader of a record with a correct checksum.
pub(crate) struct Reader<'a> {
    /// Bytes not read yet.
    rest: &'a [u8],
    pub(super) version: u8,
}

impl<'a> Reader<'a> {
    /// Reader at the start of a record.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`] if the checksum is wrong.
    pub(super) fn checked(record: &'a [u8]) -> Result<Self, RestoreError> {
        let (rest, sum) = record.split_last_chunk().ok_or(RestoreError::Damaged)?;
        if checksum::of(rest) != u32::from_le_bytes(*sum) {
            return Err(RestoreError::Damaged);
        }
        Ok(Self { rest, version: 0 })
    }

    /// Layout version of the record.
    pub(crate) fn version(&self) -> u8 {
        self.version
    }

    /// Checks that the record is read to its end.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`] if bytes are left.
    pub(crate) fn end(&self) -> Result<(), RestoreError> {
        if self.rest.is_empty() { Ok(()) } else { Err(RestoreError::Damaged) }
    }

    /// Reads `B` bytes.
    pub(crate) fn bytes<const B: usize>(&mut self) -> Result<[u8; B], RestoreError> {
        let (bytes, rest) = self.rest.split_first_chunk().ok_or(RestoreError::Damaged)?;
        self.rest = rest;
        Ok(*bytes)
    }

    /// Reads a `u32`.
    pub(crate) fn word(&mut self) -> Result<u32, RestoreError> {
        Ok(u32::from_le_bytes(self.bytes()?))
    }

    /// Reads a `bool`, stored as a word.
    pub(crate) fn flag(&mut self) -> Result<bool, RestoreError> {
        match self.word()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(RestoreError::Absurd),
        }
    }

    /// Reads a finite number.
    // Out of line, as `Writer::word`.
    #[inline(never)]
    pub(crate) fn number<T: Scalar>(&mut self) -> Result<T, RestoreError> {
        let mut bits = [0; 8];
        let (place, _) = bits.split_at_mut_checked(T::BYTES.into()).unwrap_or_default();
        let (bytes, rest) = self.rest.split_at_checked(place.len()).ok_or(RestoreError::Damaged)?;
        place.copy_from_slice(bytes);
        self.rest = rest;
        let number = T::from_bits(u64::from_le_bytes(bits));
        believe(number.is_finite()).map(|()| number)
    }

    /// Reads finite numbers in order.
    pub(crate) fn numbers<'n, T: Scalar>(
        &mut self,
        numbers: impl IntoIterator<Item = &'n mut T>,
    ) -> Result<(), RestoreError> {
        for number in numbers {
            *number = self.number()?;
        }
        Ok(())
    }

    /// Reads numbers with a magnitude up to `limit`.
    pub(crate) fn numbers_within<'n, T: Scalar>(
        &mut self,
        limit: T,
        numbers: impl IntoIterator<Item = &'n mut T>,
    ) -> Result<(), RestoreError> {
        for number in numbers {
            *number = self.within(-limit, limit)?;
        }
        Ok(())
    }

    /// Reads a number from `least` to `most`.
    pub(crate) fn within<T: Scalar>(&mut self, least: T, most: T) -> Result<T, RestoreError> {
        let number = self.number()?;
        believe((least..=most).contains(&number)).map(|()| number)
    }

    /// Reads a `u32` up to `most`.
    pub(crate) fn word_within(&mut self, most: u32) -> Result<u32, RestoreError> {
        let word = self.word()?;
        believe(word <= most).map(|()| word)
    }
}

/// Refuses numbers that nothing writes together.
///
/// # Errors
/// [`RestoreError::Absurd`] unless they are consistent.
pub(crate) fn believe(consistent: bool) -> Result<(), RestoreError> {
    if consistent { Ok(()) } else { Err(RestoreError::Absurd) }
}

/// Checks that `diagonal` holds sums of squares, up to the rounding of a change of frame.
///
/// # Errors
/// [`RestoreError::Absurd`].
pub(crate) fn check_sums_of_squares<T: Scalar>(
    diagonal: impl IntoIterator<Item = T>,
) -> Result<(), RestoreError> {
    let range = |[least, most]: [T; 2], d: T| [least.min(d), most.max(d)];
    let [least, most] = diagonal.into_iter().fold([T::ZERO; 2], range);
    believe(-least <= T::lit(NEGATIVE) * most)
}
