//! Frame being received: its records and its CRC.

use super::crc::FrameCrc;
use super::header::{FrameHeader, Scales};
use super::layout::{CRC_BYTES, HEADER_BYTES, RECORD_BYTES, record_words};
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
}

impl FrameBody {
    pub(super) fn new(
        header: FrameHeader,
        bytes: &[u8; HEADER_BYTES],
        disposition: Disposition,
    ) -> Self {
        let (scales, crc) = (header.scales(), FrameCrc::new(bytes));
        let records_left = header.count;
        Self { header, disposition, scales, crc, records_left }
    }

    /// Returns the number of bytes to the end of the frame, counted from the start of the next record or of the CRC.
    pub(super) fn bytes_left(&self) -> usize {
        usize::from(self.records_left) * RECORD_BYTES + CRC_BYTES
    }

    /// Returns the length of the next record, or of the CRC after the last one, bytes.
    pub(super) fn wanted(&self) -> usize {
        if self.records_left > 0 { RECORD_BYTES } else { CRC_BYTES }
    }

    /// Returns whether all records have been taken.
    pub(super) fn is_at_crc(&self) -> bool {
        self.records_left == 0
    }

    /// Returns whether `bytes` are the CRC of the frame.
    pub(super) fn is_crc(&self, bytes: &[u8]) -> bool {
        *bytes == self.crc.value().to_le_bytes()
    }

    /// Takes whole records from the front of `bytes`, up to the last record.
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
        let records = bytes.as_chunks().0;
        let most = most.min(self.records_left.into());
        let records = records.get(..most).unwrap_or(records);
        // Local variables, because fields of `self` would be loaded and stored for each record.
        let (mut crc, scales) = (self.crc.clone(), self.scales);
        let is_accepted = self.disposition == Disposition::Accepted;
        for record in records {
            let words = record_words(record);
            crc.add_words(words);
            if is_accepted {
                let record = MatchRecord::from_words(words);
                take(&record.scaled(&scales), record.track());
            }
        }
        *bytes = bytes.get(records.as_flattened().len()..).unwrap_or_default();
        let taken = u16::try_from(records.len()).unwrap_or(u16::MAX);
        self.records_left = self.records_left.saturating_sub(taken);
        self.crc = crc;
    }
}
