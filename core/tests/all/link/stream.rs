//! Frames as sent, and frames as received from a stream.

use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{Decoder, Event, FrameCrc, FrameHeader, MatchRecord, Received};

/// Content of a frame.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Frame {
    pub(crate) header: FrameHeader,
    pub(crate) matches: Vec<Correspondence<f32>>,
}

pub(crate) const HEADER: FrameHeader = FrameHeader {
    timestamp_us: 0x0123_4567_89ab_cdef,
    sequence: 0,
    count: 0,
    image_size: [1920, 1200],
    grid_step: 256,
    fraction_bits: 8,
    pyramid_ratio: 77,
    dropped_before: false,
    more_found: false,
};

impl Frame {
    /// Frame of `count` generated matches.
    pub(crate) fn plain(sequence: u32, count: u16) -> Self {
        let header = FrameHeader { sequence, count, ..HEADER };
        let matches = (0..count).map(|i| {
            let [u, v] = [i * 37 % 1800 + 100, i * 71 % 1200].map(f32::from);
            Correspondence {
                left: [u + 0.25, v],
                right: [u - 50.5, v + 1.5],
                score: 1.0,
                grid_step: header.grid_step_px((i % 8) as u8),
            }
        });
        Self { header, matches: matches.collect() }
    }

    pub(crate) fn bytes(&self) -> Vec<u8> {
        let records = self.matches.iter().map(|c| MatchRecord::encode(c, &self.header).unwrap());
        let records: Vec<_> = records.map(|record| record.to_bytes()).collect();
        sealed(&self.header.encode().unwrap(), &records)
    }

    /// The frame as received by a sink that takes every match.
    pub(crate) fn whole(&self) -> Received {
        Received { header: self.header, taken: self.matches.len() }
    }
}

/// Header, records and frame CRC.
pub(crate) fn sealed(
    header: &[u8; FrameHeader::BYTES],
    records: &[[u8; MatchRecord::BYTES]],
) -> Vec<u8> {
    let mut crc = FrameCrc::new(header);
    for record in records {
        crc.add(record);
    }
    [&header[..], records.as_flattened(), &crc.value().to_le_bytes()].concat()
}

/// Events of a stream that is fed in the given pieces.
pub(crate) fn events<'a>(
    decoder: &mut Decoder,
    pieces: impl IntoIterator<Item = &'a [u8]>,
) -> Vec<Event> {
    let mut events = Vec::new();
    for mut piece in pieces {
        events.extend(core::iter::from_fn(|| decoder.next(&mut piece)));
        assert!(piece.is_empty());
    }
    events
}

/// Whole frames among the events, and the number of frames that are discarded after an intact header.
pub(crate) fn whole(events: &[Event]) -> (Vec<Frame>, usize) {
    let (mut frames, mut discarded) = (Vec::new(), 0);
    let mut open: Option<Frame> = None;
    for event in events {
        match event {
            Event::Started(header) => {
                assert!(open.is_none(), "a frame starts inside another");
                open = Some(Frame { header: *header, matches: Vec::new() });
            }
            Event::Match(c, _) => open.as_mut().unwrap().matches.push(*c),
            Event::Finished(header) => {
                let frame = open.take().unwrap();
                assert_eq!(frame.header, *header);
                frames.push(frame);
            }
            Event::Discarded => {
                open.take().unwrap();
                discarded += 1;
            }
        }
    }
    (frames, discarded)
}

/// Whole frames of a stream that is fed in one piece, the number of frames that are discarded after an intact header, and
/// the decoder after the stream.
pub(crate) fn received(bytes: &[u8]) -> (Vec<Frame>, usize, Decoder) {
    let mut decoder = Decoder::new();
    let (frames, discarded) = whole(&events(&mut decoder, [bytes]));
    (frames, discarded, decoder)
}
