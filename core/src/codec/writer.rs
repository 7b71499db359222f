//! Numbers to bytes.

use core::mem;

use crate::codec::checksum::{self, Checksum};
use crate::scalar::Scalar;

/// Writes into a buffer, and goes on to count and to sum up once that is full.
pub(crate) struct Writer<'a> {
    room: &'a mut [u8],
    length: usize,
    checksum: Checksum,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(room: &'a mut [u8]) -> Self {
        Self { room, length: 0, checksum: checksum::begin() }
    }

    pub(crate) fn bytes(&mut self, bytes: &[u8]) {
        self.checksum.update(bytes);
        self.put(bytes);
    }

    fn put(&mut self, bytes: &[u8]) {
        self.length = self.length.saturating_add(bytes.len());
        self.room = match mem::take(&mut self.room).split_at_mut_checked(bytes.len()) {
            Some((place, rest)) => {
                place.copy_from_slice(bytes);
                rest
            }
            None => &mut [],
        };
    }

    pub(crate) fn word(&mut self, word: u32) {
        self.bytes(&word.to_le_bytes());
    }

    pub(crate) fn flag(&mut self, flag: bool) {
        self.word(flag.into());
    }

    pub(crate) fn numbers<'n, T: Scalar>(&mut self, numbers: impl IntoIterator<Item = &'n T>) {
        for number in numbers {
            let bytes = number.bits().to_le_bytes();
            self.bytes(bytes.get(..T::BYTES.into()).unwrap_or(&bytes));
        }
    }

    pub(crate) fn number<T: Scalar>(&mut self, number: T) {
        self.numbers(&[number]);
    }

    /// Of all that was written.
    pub(crate) fn checksum(&self) -> u32 {
        self.checksum.clone().finalize()
    }

    /// Appends the checksum; the length of it all, whether there was room or not.
    pub(super) fn finish(mut self) -> usize {
        let checksum = self.checksum();
        self.put(&checksum.to_le_bytes());
        self.length
    }
}
