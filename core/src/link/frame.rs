//! Frame being received: its records and its CRC.

use super::crc::FrameCrc;
use super::header::FrameHeader;
use super::layout::{CRC_BYTES, HEADER_BYTES, RECORD_BYTES, record_words};
use super::record::MatchRecord;
use crate::batch::correspondence::Correspondence;

/// Treatment of a frame whose CRC proves correct.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Disposition {
    /// Matches are handed out.
    Accepted,
    /// Same sequence number as the frame before: dropped.
    Repeated,
    /// Refused by the sink: dropped.
    Refused,
    /// Holds a record outside version 1: discarded.
    Unsupported,
}

/// Body of a frame, from its header to its CRC.
#[derive(Debug, Clone)]
pub(super) struct FrameBody {
    pub(super) header: FrameHeader,
    pub(super) disposition: Disposition,
    crc: FrameCrc,
    records_left: u16,
    /// First `held` bytes of the current record or of the CRC.
    partial: [u8; RECORD_BYTES],
    held: u8,
}

/// Effect of a byte or a record of the body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// Nothing to hand out.
    None,
    /// Correspondence, unverified.
    Match(Correspondence<f32>),
    /// End of the frame; whether its CRC is correct.
    End(bool),
}

impl FrameBody {
    pub(super) fn new(
        header: FrameHeader,
        bytes: &[u8; HEADER_BYTES],
        disposition: Disposition,
    ) -> Self {
        let (crc, records_left) = (FrameCrc::new(bytes), header.count);
        Self { header, disposition, crc, records_left, partial: [0; RECORD_BYTES], held: 0 }
    }

    /// Whether the next byte is the first of a record.
    #[inline(always)]
    pub(super) fn is_at_record(&self) -> bool {
        self.held == 0 && self.records_left > 0
    }

    /// Bytes to the end of the frame.
    pub(super) fn bytes_left(&self) -> usize {
        (usize::from(self.records_left) * RECORD_BYTES + CRC_BYTES).saturating_sub(self.held.into())
    }

    /// Whether matches of it may have been handed out.
    pub(super) fn was_handed_out(&self) -> bool {
        matches!(self.disposition, Disposition::Accepted | Disposition::Unsupported)
    }

    /// Takes one byte.
    pub(super) fn push(&mut self, byte: u8) -> Step {
        if let Some(place) = self.partial.get_mut(usize::from(self.held)) {
            *place = byte;
        }
        self.held = self.held.saturating_add(1);
        let wanted = if self.records_left > 0 { RECORD_BYTES } else { CRC_BYTES };
        if usize::from(self.held) < wanted {
            return Step::None;
        }
        self.held = 0;
        if self.records_left > 0 {
            return self.push_record(record_words(&self.partial));
        }
        let [c0, c1, c2, c3, ..] = self.partial;
        Step::End(u32::from_le_bytes([c0, c1, c2, c3]) == self.crc.value())
    }

    /// Takes one whole record, in words.
    #[inline(always)]
    pub(super) fn push_record(&mut self, record: [u32; 4]) -> Step {
        self.crc.add_words(record);
        self.records_left = self.records_left.saturating_sub(1);
        if self.disposition != Disposition::Accepted {
            return Step::None;
        }
        let Ok(record) = MatchRecord::from_words(record) else {
            self.disposition = Disposition::Unsupported;
            return Step::None;
        };
        Step::Match(record.decode(&self.header))
    }
}
