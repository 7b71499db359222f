//! Encoder and decoder of records: words and `f32` in order.

use super::{LAYOUT, MAGIC};
use crate::checksum;
use crate::error::RestoreError;
use crate::scalar::Scalar;

/// Consecutive numbers of a record: their count, and the least and the largest value of each.
pub(crate) type Range = (usize, f32, f32);

/// Returns the length of the numbers of these ranges, bytes.
pub(crate) const fn bytes_of(mut ranges: &[Range]) -> usize {
    let mut bytes = 0;
    while let [(count, _, _), rest @ ..] = ranges {
        (bytes, ranges) = (bytes + 4 * *count, rest);
    }
    bytes
}

/// Writer into a record of fixed length.
pub(crate) struct Writer<'a> {
    pub(crate) rest: &'a mut [u8],
}

impl<'a> Writer<'a> {
    /// Writes the header.
    ///
    /// * `x`, `y`: two bytes whose meaning depends on the kind.
    pub(crate) fn begin(rest: &'a mut [u8], kind: u8, [x, y]: [u8; 2]) -> Self {
        let mut writer = Self { rest };
        writer.word(u32::from_le_bytes(MAGIC));
        writer.word(u32::from_le_bytes([LAYOUT, kind, x, y]));
        writer
    }

    #[inline(never)]
    pub(crate) fn word(&mut self, word: u32) {
        if let Some((place, rest)) = core::mem::take(&mut self.rest).split_first_chunk_mut() {
            *place = word.to_le_bytes();
            self.rest = rest;
        }
    }

    /// Writes numbers in order, as `f32`.
    #[inline(never)]
    pub(crate) fn numbers<T: Scalar>(&mut self, numbers: &[T]) {
        for number in numbers {
            self.word(number.to_single().to_bits());
        }
    }
}

/// Moves each number that is out of its range to the nearer end of the range, and a NaN to the lower end.
#[inline(never)]
pub(crate) fn limit(numbers: &mut [u8], ranges: &[Range]) {
    let mut words = numbers.as_chunks_mut().0.iter_mut();
    for (count, least, most) in ranges {
        for word in words.by_ref().take(*count) {
            *word = f32::from_le_bytes(*word).max(*least).min(*most).to_le_bytes();
        }
    }
}

/// Sets the last four bytes of a record to the checksum of the bytes before.
pub(crate) fn seal(record: &mut [u8]) {
    if let Some((content, sum)) = record.split_last_chunk_mut() {
        *sum = checksum::of_record(content).to_le_bytes();
    }
}

/// Reader of the words of a record, up to its checksum.
#[derive(Clone)]
pub(crate) struct Reader<'a> {
    pub(crate) rest: &'a [u8],
}

impl<'a> Reader<'a> {
    /// Checks checksum, header and length. Returns a reader of the content after the header, and the last two bytes of
    /// the header.
    ///
    /// # Errors
    /// [`RestoreError::Damaged`], [`RestoreError::Foreign`], [`RestoreError::Layout`].
    #[inline(never)]
    pub(crate) fn begin(
        record: &'a [u8],
        kind: u8,
        length: usize,
    ) -> Result<(Self, [u8; 2]), RestoreError> {
        let (content, sum) = record.split_last_chunk().ok_or(RestoreError::Damaged)?;
        let is_whole = checksum::of_record(content) == u32::from_le_bytes(*sum);
        let mut reader = Self { rest: content };
        let magic = reader.word().to_le_bytes();
        let [layout, found, x, y] = reader.word().to_le_bytes();
        match () {
            () if !is_whole => Err(RestoreError::Damaged),
            () if magic != MAGIC => Err(RestoreError::Foreign),
            () if layout != LAYOUT => Err(RestoreError::Layout(layout)),
            () if found != kind => Err(RestoreError::Foreign),
            () if record.len() != length => Err(RestoreError::Damaged),
            () => Ok((reader, [x, y])),
        }
    }

    /// Returns whether the numbers that follow are within their ranges. Does not advance the reader.
    #[inline(never)]
    pub(crate) fn is_within(&self, ranges: &[Range]) -> bool {
        let mut ahead = self.clone();
        ranges.iter().all(|(count, least, most)| {
            (0..*count).all(|_| (*least..=*most).contains(&f32::from_bits(ahead.word())))
        })
    }

    /// Reads a word. Returns 0 beyond the end, which a reader of a record of the right length does not reach.
    #[inline(never)]
    pub(crate) fn word(&mut self) -> u32 {
        let Some((word, rest)) = self.rest.split_first_chunk() else { return 0 };
        self.rest = rest;
        u32::from_le_bytes(*word)
    }

    /// Reads numbers into their places. The caller has checked their range, or checks it afterwards.
    #[inline(never)]
    pub(crate) fn fill<T: Scalar>(&mut self, places: &mut [T]) {
        for place in places {
            *place = T::single(f32::from_bits(self.word()));
        }
    }

    pub(crate) fn numbers<T: Scalar, const K: usize>(&mut self) -> [T; K] {
        let mut numbers = [T::ZERO; K];
        self.fill(&mut numbers);
        numbers
    }
}
