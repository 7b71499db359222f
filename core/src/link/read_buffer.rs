//! Common part of the drivers: a read buffer in front of the decoder.

use core::ops::Range;

use thiserror::Error;

use super::decoder::Decoder;
use super::sink::{FrameRefusal, FrameSink, Received};

/// Longest read, bytes: 16 records, so that the setup of a transfer costs little in comparison.
const CAPACITY: usize = 256;

/// Progress of a driver after one call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReadStatus {
    /// No data is waiting; nothing was read.
    Idle,
    /// Data was read and no frame is whole yet. Call again.
    Partial,
    /// A frame is whole and in the sink.
    Frame(Received),
}

/// Why a driver returned no frame. Call again: the decoder resynchronises where bytes are missing.
///
/// `E`: error of the bus or stream. `P`: error of the data-ready pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReceiveError<E, P> {
    /// The bus or stream failed; the bytes of this read are lost. Report a receive overrun with
    /// `note_overrun`.
    #[error("bus: {0:?}")]
    Bus(E),
    /// The data-ready pin could not be read. Nothing is lost.
    #[error("data-ready pin: {0:?}")]
    Ready(P),
    /// The stream has ended. Open it again.
    #[error("the stream has ended")]
    Ended,
    /// The sink refused the frame; see [`FrameRefusal`] for the action.
    #[error("frame refused: {0}")]
    Refused(#[from] FrameRefusal),
    /// The time expired before a frame was whole. The next call continues with that frame.
    #[error("no frame within the time given")]
    TimedOut,
}

/// Decoder and the bytes of the last read.
///
/// After damage two frames may end in one read: the bytes after the first wait for the next call.
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

    /// Space for the next read: up to the end of the current frame or of the next header.
    pub(super) fn space(&mut self) -> &mut [u8] {
        let wanted = self.decoder.bytes_wanted().min(CAPACITY);
        self.bytes.get_mut(..wanted).unwrap_or_default()
    }

    /// Decodes the first `count` bytes of the buffer after a read.
    pub(super) fn received(
        &mut self,
        count: usize,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, FrameRefusal> {
        self.unread = 0..count;
        Ok(self.decode(sink)?.map_or(ReadStatus::Partial, ReadStatus::Frame))
    }

    /// Decodes the rest of the last read; a whole frame, if one ends in it.
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

    /// Decodes the rest of the last read, else the bytes of one new read.
    ///
    /// * `read`: fills the buffer; number of bytes read, `None` if no data is waiting.
    pub(super) fn advance<E, P>(
        &mut self,
        sink: &mut impl FrameSink,
        read: impl FnOnce(&mut [u8]) -> Result<Option<usize>, ReceiveError<E, P>>,
    ) -> Result<ReadStatus, ReceiveError<E, P>> {
        if let Some(frame) = self.pending(sink)? {
            return Ok(ReadStatus::Frame(frame));
        }
        match read(self.space())? {
            Some(count) => Ok(self.received(count, sink)?),
            None => Ok(ReadStatus::Idle),
        }
    }
}

/// Repeats `step` until a frame is whole; [`ReceiveError::TimedOut`] once `expired`, which is called
/// after each step.
pub(super) fn until<E, P>(
    mut expired: impl FnMut() -> bool,
    mut step: impl FnMut() -> Result<ReadStatus, ReceiveError<E, P>>,
) -> Result<Received, ReceiveError<E, P>> {
    loop {
        if let ReadStatus::Frame(frame) = step()? {
            return Ok(frame);
        }
        if expired() {
            return Err(ReceiveError::TimedOut);
        }
    }
}
