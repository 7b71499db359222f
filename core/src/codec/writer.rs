//! Encoder of records: numbers to bytes.

use core::mem;

use crate::codec::checksum::{self, Checksum};
use crate::scalar::Scalar;

/// Writer into a buffer. In a full buffer it continues length and checksum only, so that the caller
/// learns the length that it needs.
pub(crate) struct Writer<'a> {
    buffer: &'a mut [u8],
    length: usize,
    checksum: Checksum,
}

impl<'a> Writer<'a> {
    /// Writer at the start of a buffer.
    pub(crate) fn new(buffer: &'a mut [u8]) -> Self {
        Self { buffer, length: 0, checksum: checksum::begin() }
    }

    /// Writes bytes.
    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.checksum.update(bytes);
        self.put(bytes);
    }

    /// Writes bytes that the checksum does not cover.
    fn put(&mut self, bytes: &[u8]) {
        self.length = self.length.saturating_add(bytes.len());
        self.buffer = match mem::take(&mut self.buffer).split_at_mut_checked(bytes.len()) {
            Some((place, rest)) => {
                place.copy_from_slice(bytes);
                rest
            }
            None => &mut [],
        };
    }

    /// Writes a `u32`.
    // Out of line: inlined into every field of a record it took 25 kB at opt-level 3.
    #[inline(never)]
    pub(crate) fn word(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }

    /// Writes a `bool` as a word.
    pub(crate) fn flag(&mut self, flag: bool) {
        self.word(flag.into());
    }

    /// Writes numbers in order.
    pub(crate) fn numbers<'n, T: Scalar>(&mut self, numbers: impl IntoIterator<Item = &'n T>) {
        for number in numbers {
            let [a, b, c, d, high @ ..] = number.bits().to_le_bytes();
            self.word(u32::from_le_bytes([a, b, c, d]));
            if T::BYTES == 8 {
                self.word(u32::from_le_bytes(high));
            }
        }
    }

    /// Writes one number.
    pub(crate) fn number<T: Scalar>(&mut self, number: T) {
        self.numbers(&[number]);
    }

    /// Checksum of the bytes written so far.
    pub(crate) fn checksum(&self) -> u32 {
        self.checksum.value()
    }

    /// Appends the checksum and returns the length of the whole record, whether it fits or not.
    pub(super) fn finish(mut self) -> usize {
        let checksum = self.checksum();
        self.put(&checksum.to_le_bytes());
        self.length
    }
}
