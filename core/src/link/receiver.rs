//! Driver of a matcher: reads a byte source into a sink.

use core::convert::Infallible;

use thiserror::Error;

use super::counters::Counters;
use super::read_buffer::ReadBuffer;
use super::sink::{FrameRefusal, FrameSink, Received};

/// Byte source of a driver.
pub trait Source {
    /// Error of the bus or stream.
    type Error;

    /// Reads into `bytes`; returns the number of bytes read, 0 at the end of a stream.
    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, Self::Error>;
}

/// Byte source that knows whether data is waiting.
pub trait ReadySource: Source {
    /// Error of the data-ready pin.
    type ReadyError;

    /// Returns whether data is waiting.
    fn is_ready(&mut self) -> Result<bool, ReceiveError<Self::Error, Self::ReadyError>>;
}

/// Progress of a driver after one call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum ReadStatus {
    /// No data is waiting; nothing was read.
    Idle,
    /// Data was read, but no frame is whole yet: a calibrator has nothing to solve. Call again.
    Partial,
    /// A frame is whole and in the sink.
    Frame(Received),
}

/// Why a driver returned no frame. Call again: the decoder resynchronises after missing bytes.
///
/// `E`: error of the bus or stream. `P`: error of the data-ready pin.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ReceiveError<E, P> {
    /// The bus or stream failed; the bytes of this read are lost. Report a receive overrun with
    /// [`FrameReceiver::note_overrun`].
    #[error("bus: {0:?}")]
    Bus(E),
    /// The data-ready pin could not be read. No data is lost.
    #[error("data-ready pin: {0:?}")]
    Ready(P),
    /// The stream has ended. Open it again.
    #[error("the stream has ended")]
    Ended,
    /// The sink refused the frame; see [`FrameRefusal`] for the action.
    #[error("frame refused: {0}")]
    Refused(#[from] FrameRefusal),
    /// The time expired before a frame was whole. The next call continues with that frame. A calibrator
    /// does not solve its matches until the frame is whole.
    #[error("no frame within the time given")]
    TimedOut,
}

codes! {
    ReceiveError[E, P] {
        Bus = 1150, Ready = 1151, TimedOut = 1152, Ended = 1161, Refused { 0: why } = why.code(),
    }
}

/// Driver of a matcher: [`FpgaMatcher`](super::FpgaMatcher) on SPI, [`StreamMatcher`](super::StreamMatcher) on a byte
/// stream. RAM: less than 512 bytes.
///
/// One read asks for at most 256 bytes, and not beyond the end of the current frame.
#[derive(Debug)]
pub struct FrameReceiver<S> {
    pub(super) source: S,
    pub(super) buffer: ReadBuffer,
}

impl<S> FrameReceiver<S> {
    pub(super) const fn over(source: S) -> Self {
        Self { source, buffer: ReadBuffer::new() }
    }

    /// Returns the statistics of the link.
    pub fn counters(&self) -> &Counters {
        self.buffer.decoder.counters()
    }

    /// Counts an overrun that the caller detected, such as a DMA ring that wrapped or an overrun that a UART reports.
    pub fn note_overrun(&mut self) {
        self.buffer.decoder.note_overrun();
    }
}

impl<S: Source> FrameReceiver<S> {
    /// Reads once, whether data is waiting or not. This is for a caller with an interrupt. The read of a stream may
    /// block.
    ///
    /// Call it until the frame is whole, or as often as the longest expected frame needs: see
    /// [`FrameHeader::frame_bytes`](super::FrameHeader::frame_bytes).
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ended`], [`ReceiveError::Refused`].
    pub fn read(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, ReceiveError<S::Error, Infallible>> {
        refuse_if_busy(sink)?;
        self.transfer(sink)
    }

    /// Reads until a frame is whole, and returns it.
    ///
    /// * `expired`: called after each read that completes no frame; `true` ends the wait.
    ///
    /// # Errors
    /// As [`Self::read`], and [`ReceiveError::TimedOut`].
    pub fn read_until(
        &mut self,
        sink: &mut impl FrameSink,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, ReceiveError<S::Error, Infallible>> {
        until(expired, || self.read(sink))
    }

    fn transfer<P>(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, ReceiveError<S::Error, P>> {
        match self.source.read(self.buffer.space()).map_err(ReceiveError::Bus)? {
            0 => Err(ReceiveError::Ended),
            count => {
                let received = self.buffer.received(count, sink)?;
                Ok(received.map_or(ReadStatus::Partial, ReadStatus::Frame))
            }
        }
    }
}

impl<S: ReadySource> FrameReceiver<S> {
    /// Reads once if data is waiting; does not block.
    ///
    /// # Errors
    /// As [`Self::read`], and [`ReceiveError::Ready`].
    pub fn poll(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, ReceiveError<S::Error, S::ReadyError>> {
        refuse_if_busy(sink)?;
        if self.source.is_ready()? { self.transfer(sink) } else { Ok(ReadStatus::Idle) }
    }

    /// Polls until a frame is whole, and returns it.
    ///
    /// * `expired`: called after each poll that completes no frame; `true` ends the wait.
    ///
    /// # Errors
    /// As [`Self::poll`], and [`ReceiveError::TimedOut`].
    pub fn poll_until(
        &mut self,
        sink: &mut impl FrameSink,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, ReceiveError<S::Error, S::ReadyError>> {
        until(expired, || self.poll(sink))
    }
}

/// Refuses a frame before its bytes are read.
pub(super) fn refuse_if_busy(sink: &impl FrameSink) -> Result<(), FrameRefusal> {
    if sink.is_busy() { Err(FrameRefusal::Busy) } else { Ok(()) }
}

fn until<E, P>(
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
