//! Decodes a frame of the wire.

use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{
    Decoder, FrameCrc, FrameHeader, FrameRefusal, FrameSink, MatchRecord, Received,
};

use crate::calls::{self, CAPACITY};
use crate::probe::{Probe, Sample};
use crate::scene::HEADER;

const BYTES: usize = FrameHeader::BYTES + CAPACITY * MatchRecord::BYTES + FrameCrc::BYTES;

/// Discards the matches, so that only the decoder is measured.
struct DiscardingSink;

impl FrameSink for DiscardingSink {
    fn start(&mut self, _: &FrameHeader) -> Result<(), FrameRefusal> {
        Ok(())
    }

    #[inline(never)]
    fn take(&mut self, correspondence: &Correspondence<f32>) {
        core::hint::black_box(correspondence);
    }

    fn finish(&mut self) -> usize {
        0
    }

    fn discard(&mut self) {}
}

/// Decodes a frame from one contiguous slice.
///
/// # Panics
/// If the frame is not decoded.
pub(crate) fn decode(probe: &Probe, records: &[MatchRecord]) -> Sample {
    let count = records.len().try_into().expect("within a frame");
    let header = FrameHeader { count, ..HEADER };
    let start = header.encode().expect("valid");
    let mut crc = FrameCrc::new(&start);
    let mut bytes = [0; BYTES];
    let (body, _) = bytes[FrameHeader::BYTES..].as_chunks_mut();
    for (place, record) in body.iter_mut().zip(records) {
        *place = record.to_bytes();
        crc.add(place);
    }
    bytes[..FrameHeader::BYTES].copy_from_slice(&start);
    let end = header.frame_bytes();
    bytes[end - FrameCrc::BYTES..end].copy_from_slice(&crc.value().to_le_bytes());

    let mut decoder = Decoder::new();
    let mut rest = bytes.as_slice();
    let (fed, sample) = probe.run(|| calls::feed(&mut decoder, &mut rest, &mut DiscardingSink));
    assert_eq!(fed, Ok(Some(Received { header, taken: 0 })));
    sample
}
