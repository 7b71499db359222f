//! Read buffer in front of the decoder.

use super::decoder::Decoder;
use super::sink::{FrameRefusal, FrameSink, Received};

/// Longest read, bytes: 16 records, so that the setup of a transfer costs little in comparison.
const CAPACITY: usize = 256;

/// Decoder and the space for a read.
#[derive(Debug)]
pub(super) struct ReadBuffer {
    pub(super) decoder: Decoder,
    bytes: [u8; CAPACITY],
}

impl ReadBuffer {
    pub(super) const fn new() -> Self {
        Self { decoder: Decoder::new(), bytes: [0; CAPACITY] }
    }

    /// Returns the space for the next read: up to the end of the current frame or of the next header, at most
    /// [`CAPACITY`] bytes.
    pub(super) fn space(&mut self) -> &mut [u8] {
        let wanted = self.decoder.bytes_wanted().min(CAPACITY);
        self.bytes.get_mut(..wanted).unwrap_or_default()
    }

    /// Decodes a read of `count` bytes; returns a whole frame if one ends in it. The decoder uses all bytes, because a
    /// frame or a header that ends in the read ends with it.
    pub(super) fn received(
        &mut self,
        count: usize,
        sink: &mut impl FrameSink,
    ) -> Result<Option<Received>, FrameRefusal> {
        self.decoder.feed(&mut self.bytes.get(..count).unwrap_or_default(), sink)
    }
}
