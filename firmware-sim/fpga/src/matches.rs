//! Matches as beats of the stream, and the expected frames.

use stereo_selfcal::link::{Encoder, FrameHeader, MatchRecord};

use crate::bench::Beat;

/// A frame as the matcher finds it.
#[derive(Debug, Clone)]
pub struct Found {
    /// Header, without count and flags.
    pub header: FrameHeader,
    /// Records within range.
    pub records: Vec<[u8; MatchRecord::BYTES]>,
}

impl Found {
    /// The beats of a frame; a frame without matches has one beat without a match.
    #[must_use]
    pub fn beats(&self) -> Vec<Beat> {
        let beat = |record: &[u8; MatchRecord::BYTES], keep| Beat {
            coordinates: [0, 3, 6, 9]
                .map(|at| u32::from_le_bytes([record[at], record[at + 1], record[at + 2], 0])),
            score: u16::from_le_bytes([record[12], record[13]]),
            level: record[14],
            first: false,
            last: false,
            keep,
            header: self.header,
        };
        let mut beats: Vec<Beat> = self.records.iter().map(|record| beat(record, true)).collect();
        if beats.is_empty() {
            beats.push(beat(&[0; MatchRecord::BYTES], false));
        }
        beats[0].first = true;
        let last = beats.len() - 1;
        beats[last].last = true;
        beats
    }

    /// The frame as the core encodes it.
    ///
    /// * `capacity`: capacity of the framer in matches; it keeps the first ones.
    /// * `more`: matches were left out for another reason.
    ///
    /// # Panics
    /// If the header or a record is not valid.
    #[must_use]
    pub fn encoded(&self, capacity: usize, dropped_before: bool, more: bool) -> Vec<u8> {
        let kept = &self.records[..self.records.len().min(capacity)];
        let header = FrameHeader {
            count: kept.len().try_into().expect("a frame has at most 65535"),
            dropped_before,
            more_found: more || kept.len() < self.records.len(),
            ..self.header
        };
        let (mut encoder, start) = Encoder::begin(header).expect("a valid header");
        let mut bytes = start.to_vec();
        for record in kept {
            let record = MatchRecord::from_bytes(record);
            bytes.extend(encoder.push_record(&record).expect("counted"));
        }
        bytes.extend(encoder.finish().expect("counted"));
        bytes
    }
}
