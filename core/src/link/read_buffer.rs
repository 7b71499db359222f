//! Read buffer in front of the decoder.

use core::ops::Range;

use super::decoder::Decoder;
use super::sink::{FrameRefusal, FrameSink, Received};

/// Longest read, bytes: 16 records, so that the setup of a transfer costs little in comparison.
const CAPACITY: usize = 256;

/// Decoder and the bytes of the last read.
///
/// After damage two frames may end in one read. The bytes after the first frame wait for the next call.
#[derive(Debug)]
pub(super) struct ReadBuffer {
    pub(super) decoder: Decoder,
    bytes: [u8; CAPACITY],
    /// Range of `bytes` not decoded yet.
    unread: Range<usize>,
}

impl ReadBuffer {
    pub(super) const fn new() -> Self {
        Self { decoder: Decoder::new(), bytes: [0; CAPACITY], unread: 0..0 }
    }

    /// Returns the space for the next read: up to the end of the current frame or of the next header, at most
    /// [`CAPACITY`] bytes.
    pub(super) fn space(&mut self) -> &mut [u8] {
        let wanted = self.decoder.bytes_wanted().min(CAPACITY);
        self.bytes.get_mut(..wanted).unwrap_or_default()
    }

    /// Decodes a read of `count` bytes; returns a whole frame if one ends in it.
    pub(super) fn received(
        &mut self,
        count: usize,
        sink: &mut impl FrameSink,
    ) -> Result<Option<Received>, FrameRefusal> {
        self.unread = 0..count;
        self.decode(sink)
    }

    /// Decodes the rest of the last read; returns a whole frame if one ends in it.
    ///
    /// # Errors
    /// [`FrameRefusal::Busy`] while the sink is busy: nothing is decoded. Otherwise the refusal of the sink.
    pub(super) fn pending(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<Option<Received>, FrameRefusal> {
        if sink.is_busy() { Err(FrameRefusal::Busy) } else { self.decode(sink) }
    }

    fn decode(&mut self, sink: &mut impl FrameSink) -> Result<Option<Received>, FrameRefusal> {
        let mut bytes = self.bytes.get(self.unread.clone()).unwrap_or_default();
        let received = self.decoder.feed(&mut bytes, sink);
        self.unread.start = self.unread.end.saturating_sub(bytes.len());
        received
    }
}
