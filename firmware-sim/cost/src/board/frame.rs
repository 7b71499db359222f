//! Decodes a frame of the wire, and streams that take more work than frames.

use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{
    Decoder, FrameCrc, FrameHeader, FrameRefusal, FrameSink, MatchRecord, Received,
};

use crate::calls::{self, CAPACITY};
use crate::probe::{Probe, Sample};
use crate::scene::HEADER;

/// Bytes of a frame of `count` matches.
pub(crate) const fn bytes(count: usize) -> usize {
    FrameHeader::BYTES + count * MatchRecord::BYTES + FrameCrc::BYTES
}

/// Discards the matches, so that only the decoder is measured.
struct DiscardingSink;

impl FrameSink for DiscardingSink {
    fn start(&mut self, _: &FrameHeader) -> Result<(), FrameRefusal> {
        Ok(())
    }

    #[inline(never)]
    fn take(&mut self, correspondence: &Correspondence<f32>, _: u16) {
        core::hint::black_box(correspondence);
    }

    fn finish(&mut self) -> usize {
        0
    }

    fn discard(&mut self) {}
}

/// Writes a frame; returns its header.
///
/// # Panics
/// If the matches do not fit.
pub(crate) fn encode(sequence: u32, records: &[MatchRecord], bytes: &mut [u8]) -> FrameHeader {
    let count = records.len().try_into().expect("within a frame");
    let header = FrameHeader { count, sequence, ..HEADER };
    let start = header.encode().expect("valid");
    let mut crc = FrameCrc::new(&start);
    let (body, _) = bytes[FrameHeader::BYTES..].as_chunks_mut();
    for (place, record) in body.iter_mut().zip(records) {
        *place = record.to_bytes();
        crc.add(place);
    }
    bytes[..FrameHeader::BYTES].copy_from_slice(&start);
    let end = header.frame_bytes();
    bytes[end - FrameCrc::BYTES..end].copy_from_slice(&crc.value().to_le_bytes());
    header
}

/// Decodes a frame from one contiguous slice.
///
/// # Panics
/// If the frame is not decoded.
pub(crate) fn decode(probe: &Probe, records: &[MatchRecord]) -> Sample {
    let mut bytes = [0; bytes(CAPACITY)];
    let header = encode(HEADER.sequence, records, &mut bytes);
    let mut decoder = Decoder::new();
    let mut rest = bytes.as_slice();
    let (fed, sample) = probe.run(|| calls::feed(&mut decoder, &mut rest, &mut DiscardingSink));
    assert_eq!(fed, Ok(Some(Received { header, taken: 0 })));
    sample
}

/// Content of a stream without a whole frame.
#[derive(Clone, Copy)]
pub(crate) enum Damaged {
    /// The magic of a header repeatedly: a header may start in each fourth byte.
    Magics,
    /// Headers of empty frames without the checksum of the frame.
    Headers,
}

/// Instructions of decoding a stream without a whole frame, and its length in records.
///
/// # Panics
/// If a frame is decoded.
pub(crate) fn decode_damaged(probe: &Probe, damaged: Damaged) -> (u32, usize) {
    const RECORDS: usize = CAPACITY;
    let header = FrameHeader { count: 0, ..HEADER }.encode().expect("valid");
    let mut bytes = [0; RECORDS * MatchRecord::BYTES];
    let again = match damaged {
        Damaged::Magics => &header[..4],
        Damaged::Headers => &header,
    };
    bytes.iter_mut().zip(again.iter().cycle()).for_each(|(to, from)| *to = *from);
    let mut decoder = Decoder::new();
    let mut rest = bytes.as_slice();
    let (fed, sample) = probe.run(|| calls::feed(&mut decoder, &mut rest, &mut DiscardingSink));
    assert_eq!(fed, Ok(None));
    (sample.instructions, RECORDS)
}
