//! Frame being received: its records and its CRC.

use super::crc::FrameCrc;
use super::header::{FrameHeader, Scales};
use super::layout::{CRC_BYTES, HEADER_BYTES, MAGIC, RECORD_BYTES, record_words};
use super::record::MatchRecord;
use crate::batch::correspondence::Correspondence;

/// Treatment of the frame that is being received.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Disposition {
    /// The matches are handed out as they arrive.
    Accepted,
    /// The sequence number is the one of the last whole frame: the frame is dropped.
    Repeated,
    /// The sink has refused the frame: it is dropped.
    Refused,
}

/// Body of a frame, from its header to its CRC.
#[derive(Debug, Clone)]
pub(super) struct FrameBody {
    pub(super) header: FrameHeader,
    pub(super) disposition: Disposition,
    scales: Scales,
    crc: FrameCrc,
    records_left: u16,
    /// First `held` bytes of the current record or of the CRC.
    partial: [u8; RECORD_BYTES],
    held: u8,
}

/// Effect of bytes of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// Nothing to hand out.
    None,
    /// Correspondence and its track, unverified.
    Match(Correspondence<f32>, u16),
    /// The frame has ended. True if its CRC is correct.
    End(bool),
}

impl FrameBody {
    pub(super) fn new(
        header: FrameHeader,
        bytes: &[u8; HEADER_BYTES],
        disposition: Disposition,
    ) -> Self {
        let (scales, crc) = (header.scales(), FrameCrc::new(bytes));
        let records_left = header.count;
        Self { header, disposition, scales, crc, records_left, partial: [0; RECORD_BYTES], held: 0 }
    }

    /// Returns whether the next byte is the first of a record.
    #[inline(always)]
    fn is_at_record(&self) -> bool {
        self.held == 0 && self.records_left > 0
    }

    /// Returns the number of bytes to the end of the frame.
    pub(super) fn bytes_left(&self) -> usize {
        (usize::from(self.records_left) * RECORD_BYTES + CRC_BYTES).saturating_sub(self.held.into())
    }

    /// Returns whether matches of the frame may have been handed out.
    pub(super) fn was_handed_out(&self) -> bool {
        self.disposition == Disposition::Accepted
    }

    /// Returns the place of the missing bytes of the current record or of the CRC.
    #[inline(always)]
    pub(super) fn room(&mut self) -> &mut [u8] {
        let wanted = self.wanted();
        self.partial.get_mut(self.held.into()..wanted).unwrap_or_default()
    }

    /// Takes the first `bytes` bytes of [`Self::room`], which the caller has filled.
    pub(super) fn take_filled(&mut self, bytes: usize) -> Step {
        self.held = self.held.saturating_add(u8::try_from(bytes).unwrap_or(u8::MAX));
        if usize::from(self.held) < self.wanted() {
            return Step::None;
        }
        self.held = 0;
        if self.records_left > 0 {
            let record = record_words(&self.partial);
            self.crc.add_words(record);
            self.records_left = self.records_left.saturating_sub(1);
            if self.disposition != Disposition::Accepted {
                return Step::None;
            }
            let record = MatchRecord::from_words(record);
            return Step::Match(record.scaled(&self.scales), record.track());
        }
        let [c0, c1, c2, c3, ..] = self.partial;
        Step::End(u32::from_le_bytes([c0, c1, c2, c3]) == self.crc.value())
    }

    /// Returns the length of the current record or of the CRC, bytes.
    fn wanted(&self) -> usize {
        if self.records_left > 0 { RECORD_BYTES } else { CRC_BYTES }
    }

    /// Takes records in one piece from the front of `bytes`, up to the last record or to a record that may hold the
    /// start of a header.
    ///
    /// * `most`: largest number of records.
    /// * `take`: called with each correspondence that is handed out, and with its track; both are unverified.
    #[inline(always)]
    pub(super) fn take_records(
        &mut self,
        bytes: &mut &[u8],
        most: usize,
        mut take: impl FnMut(&Correspondence<f32>, u16),
    ) {
        if !self.is_at_record() {
            return;
        }
        let records = bytes.as_chunks().0;
        let most = most.min(self.records_left.into());
        let records = records.get(..most).unwrap_or(records);
        // Local variables, because fields of `self` would be loaded and stored for each record.
        let (mut crc, scales) = (self.crc.clone(), self.scales);
        let is_accepted = self.disposition == Disposition::Accepted;
        let mut left = records;
        while let [record, next @ ..] = left {
            let words = record_words(record);
            let end = RECORD_BYTES * records.len().saturating_sub(next.len());
            if may_have_first_two_bytes(words) && has_first_two_bytes(words, bytes.get(end)) {
                break;
            }
            left = next;
            crc.add_words(words);
            if is_accepted {
                let record = MatchRecord::from_words(words);
                take(&record.scaled(&scales), record.track());
            }
        }
        let taken = records.len().saturating_sub(left.len());
        *bytes = bytes.get(RECORD_BYTES * taken..).unwrap_or_default();
        let taken = u16::try_from(taken).unwrap_or(u16::MAX);
        self.records_left = self.records_left.saturating_sub(taken);
        self.crc = crc;
    }
}

/// Returns a word that marks each zero byte of `word` in its top bit. A byte of value 1 above a zero byte is marked,
/// too.
#[inline(always)]
fn zero_bytes(word: u32) -> u32 {
    const ONES: u32 = u32::from_ne_bytes([1; 4]);
    const TOPS: u32 = u32::from_ne_bytes([0x80; 4]);
    word.wrapping_sub(ONES) & !word & TOPS
}

/// Returns whether a record may hold the first two bytes of the magic, or may end with the first of them. Only every
/// second byte is tested, in two words at once. This is enough, because one of the two magic bytes is at a tested
/// place, and the test ignores the one bit in which they differ. One random record in 16 passes.
#[inline(always)]
fn may_have_first_two_bytes([a, b, c, d]: [u32; 4]) -> bool {
    const SAME: u32 = !(FIRST ^ SECOND);
    const UPPER: u32 = 0xff00_ff00 & SAME;
    const LOWER: u32 = 0x00ff_00ff & SAME;
    const { assert!((FIRST ^ SECOND).count_ones() == 4) };
    let in_words =
        |one: u32, other: u32| zero_bytes((one & UPPER | other >> 8 & LOWER) ^ (FIRST & SAME));
    in_words(a, b) | in_words(c, d) != 0
}

/// Returns whether a record holds the first two bytes of the magic, the second one possibly in `next`. It is true for
/// every record that holds them, and rarely true for other records.
///
/// * `next`: byte after the record; `None` if it has not been received.
#[cold]
#[inline(never)]
fn has_first_two_bytes([a, b, c, d]: [u32; 4], next: Option<&u8>) -> bool {
    // A byte that has not been received may be the second byte of the magic.
    let next = next.copied().unwrap_or(MAGIC[1]);
    [(a, b), (b, c), (c, d), (d, next.into())].into_iter().any(|(word, next)| {
        let seconds = word >> 8 | next << 24;
        zero_bytes(word ^ FIRST) & zero_bytes(seconds ^ SECOND) != 0
    })
}

/// The first and the second byte of the magic, each repeated in all bytes of a word.
const FIRST: u32 = u32::from_ne_bytes([MAGIC[0]; 4]);
const SECOND: u32 = u32::from_ne_bytes([MAGIC[1]; 4]);

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{Rng, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_header_that_starts_at_any_byte_passes_both_tests_and_few_random_records_the_first() {
        let words = |bytes: &[u8; RECORD_BYTES + 1]| record_words(bytes.first_chunk().unwrap());
        let passes = |bytes: &[u8; RECORD_BYTES + 1], next: Option<&u8>| {
            may_have_first_two_bytes(words(bytes)) && has_first_two_bytes(words(bytes), next)
        };
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let mut passed = 0;
        for i in 0..16_000 {
            let mut bytes = [0; RECORD_BYTES + 1];
            rng.fill_bytes(&mut bytes);
            passed += u32::from(may_have_first_two_bytes(words(&bytes)));
            let place = i % RECORD_BYTES;
            bytes[place..place + 2].copy_from_slice(&MAGIC[..2]);
            assert!(passes(&bytes, bytes.last()), "{bytes:?}");
            assert!(place < RECORD_BYTES - 1 || passes(&bytes, None));
            bytes[place + 1] = 0;
            bytes[place] = 0;
            let starts = bytes.windows(2).any(|two| two == &MAGIC[..2]);
            assert_eq!(passes(&bytes, bytes.last()), starts, "{bytes:?}");
        }
        assert!((900..1100).contains(&passed), "{passed}");
    }
}
