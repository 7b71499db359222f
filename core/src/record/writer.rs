//! Encoder of records.

use super::{Kind, LAYOUT, MAGIC};
use crate::checksum;
use crate::geometry::extrinsics::Extrinsics;
use crate::scalar::Scalar;

/// Writer into a record of fixed length.
pub(super) struct Writer<'a> {
    rest: &'a mut [u8],
}

impl<'a> Writer<'a> {
    /// Writer without a header, for a fingerprint.
    pub(super) fn plain(rest: &'a mut [u8]) -> Self {
        Self { rest }
    }

    /// Writes the header.
    ///
    /// * `more`: two bytes that the kind gives a meaning.
    pub(super) fn begin(rest: &'a mut [u8], kind: Kind, more: [u8; 2]) -> Self {
        let mut writer = Self { rest };
        let ([a, b, c, d], [x, y]) = (MAGIC, more);
        writer.bytes([a, b, c, d, LAYOUT, kind.number(), x, y]);
        writer
    }

    fn bytes<const B: usize>(&mut self, bytes: [u8; B]) {
        if let Some((place, rest)) = core::mem::take(&mut self.rest).split_first_chunk_mut() {
            *place = bytes;
            self.rest = rest;
        }
    }

    #[inline(never)]
    pub(super) fn word(&mut self, word: u32) {
        self.bytes(word.to_le_bytes());
    }

    /// Writes numbers in order, as `f32`.
    #[inline(never)]
    pub(super) fn numbers<T: Scalar>(&mut self, numbers: &[T]) {
        for number in numbers {
            self.word(number.to_single().to_bits());
        }
    }

    /// Writes `R` row by row, then `t`.
    pub(super) fn extrinsics<T: Scalar>(&mut self, of: &Extrinsics<T>) {
        self.numbers(&of.rotation_row_major());
        let [t] = of.translation().into_inner().data.0;
        self.numbers(&t);
    }
}

/// Sets the last four bytes of a record to the checksum of those before.
pub(super) fn seal(record: &mut [u8]) {
    if let Some((content, sum)) = record.split_last_chunk_mut() {
        *sum = checksum::of_record(content).to_le_bytes();
    }
}
