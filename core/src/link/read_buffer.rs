//! What the drivers share: bytes read and not yet decoded, and the decoder.

use super::decoder::Decoder;
use super::sink::{FrameRefusal, FrameSink, Received};

/// Bytes of the longest read: sixteen records, so that setting up a transfer costs little beside it,
/// and still a small part of a controller's RAM.
const CHUNK: usize = 256;

/// What a call of a driver came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReadStatus {
    /// Nothing waits; nothing was read.
    Idle,
    /// Something was read, and no frame is whole yet. Call again.
    Partial,
    /// A frame is whole.
    Frame(Received),
}

/// A decoder, and the bytes of one read.
///
/// After damage two frames can end in one read: what follows the first waits here for the next call.
#[derive(Debug)]
pub(super) struct ReadBuffer {
    pub(super) decoder: Decoder,
    chunk: [u8; CHUNK],
    /// The bytes not yet decoded are `chunk[start..end]`.
    start: usize,
    end: usize,
}

impl ReadBuffer {
    pub(super) const fn new() -> Self {
        Self { decoder: Decoder::new(), chunk: [0; CHUNK], start: 0, end: 0 }
    }

    /// Before a read: what is left of the last one.
    pub(super) fn resume(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<Option<Received>, FrameRefusal> {
        if sink.is_busy() {
            return Err(FrameRefusal::Busy);
        }
        self.decode(sink)
    }

    /// Where the next read goes: no further than to the end of a frame, or of a header.
    pub(super) fn room(&mut self) -> &mut [u8] {
        let wanted = self.decoder.bytes_wanted().min(CHUNK);
        self.chunk.get_mut(..wanted).unwrap_or_default()
    }

    /// After a read of `count` bytes.
    pub(super) fn filled(
        &mut self,
        count: usize,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, FrameRefusal> {
        (self.start, self.end) = (0, count);
        Ok(self.decode(sink)?.map_or(ReadStatus::Partial, ReadStatus::Frame))
    }

    fn decode(&mut self, sink: &mut impl FrameSink) -> Result<Option<Received>, FrameRefusal> {
        let mut bytes = self.chunk.get(self.start..self.end).unwrap_or_default();
        let received = self.decoder.feed(&mut bytes, sink);
        self.start = self.end.saturating_sub(bytes.len());
        received
    }
}

/// Calls `step` until it has a frame; `None` once `expired`, which is asked after each call.
pub(super) fn until<E>(
    mut expired: impl FnMut() -> bool,
    mut step: impl FnMut() -> Result<ReadStatus, E>,
) -> Result<Option<Received>, E> {
    loop {
        if let ReadStatus::Frame(received) = step()? {
            return Ok(Some(received));
        }
        if expired() {
            return Ok(None);
        }
    }
}
