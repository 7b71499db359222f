//! The frame that is coming in.

use super::crc::FrameCrc;
use super::header::FrameHeader;
use super::record::Record;
use crate::batch::correspondence::Correspondence;

/// What is made of a frame if its CRC is right.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fate {
    /// It is handed out.
    Taken,
    /// It has been before.
    Repeat,
    /// What it was to go into does not want it.
    Refused,
    /// It has a record that is not understood.
    Foreign,
}

/// A frame between its header and its end.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub(super) header: FrameHeader,
    pub(super) fate: Fate,
    crc: FrameCrc,
    records_left: u16,
    /// The start of a record, or of the frame's CRC.
    part: [u8; Record::BYTES],
    held: u8,
}

/// What a byte or a record of the body came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// Nothing to tell yet.
    None,
    /// A correspondence, not to be believed yet.
    Match(Correspondence<f32>),
    /// The end; whether the CRC is right.
    End(bool),
}

impl Frame {
    pub(super) fn new(header: FrameHeader, bytes: &[u8; FrameHeader::BYTES], fate: Fate) -> Self {
        let crc = FrameCrc::new(bytes);
        let records_left = header.count;
        Self { header, fate, crc, records_left, part: [0; Record::BYTES], held: 0 }
    }

    /// Whether a record's first byte comes next.
    #[inline(always)]
    pub(super) fn is_at_record(&self) -> bool {
        self.held == 0 && self.records_left > 0
    }

    /// Bytes to the end.
    pub(super) fn bytes_left(&self) -> usize {
        (usize::from(self.records_left) * Record::BYTES + FrameCrc::BYTES)
            .saturating_sub(self.held.into())
    }

    /// Whether something of it has been handed out.
    pub(super) fn is_known(&self) -> bool {
        matches!(self.fate, Fate::Taken | Fate::Foreign)
    }

    /// One more byte.
    pub(super) fn push(&mut self, byte: u8) -> Step {
        if let Some(place) = self.part.get_mut(usize::from(self.held)) {
            *place = byte;
        }
        self.held = self.held.saturating_add(1);
        let wanted = if self.records_left > 0 { Record::BYTES } else { FrameCrc::BYTES };
        if usize::from(self.held) < wanted {
            return Step::None;
        }
        self.held = 0;
        if self.records_left > 0 {
            let record = self.part;
            return self.record(&record);
        }
        let [c0, c1, c2, c3, ..] = self.part;
        Step::End(u32::from_le_bytes([c0, c1, c2, c3]) == self.crc.value())
    }

    /// One more record.
    #[inline(always)]
    pub(super) fn record(&mut self, bytes: &[u8; Record::BYTES]) -> Step {
        self.crc.add(bytes);
        self.records_left = self.records_left.saturating_sub(1);
        if self.fate != Fate::Taken {
            return Step::None;
        }
        let Ok(record) = Record::from_bytes(bytes) else {
            self.fate = Fate::Foreign;
            return Step::None;
        };
        Step::Match(record.decode(&self.header))
    }
}
