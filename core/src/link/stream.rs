//! Driver of a matcher on a stream of bytes: a UART, or a ring that DMA fills.

use embedded_io::{Read, ReadReady};
use thiserror::Error;

use super::counters::Counters;
use super::read_buffer::{ReadBuffer, ReadStatus, until};
use super::sink::{FrameRefusal, FrameSink, Received};

/// Why a call gave no frame. Call again: the decoder keeps its place, and finds the next frame where
/// bytes are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StreamError<E> {
    /// The stream failed. Where bytes were lost to an overrun, say so with
    /// [`StreamMatcher::note_overrun`].
    #[error("stream: {0:?}")]
    Stream(E),
    /// The stream has ended. Open it anew.
    #[error("the stream has ended")]
    Ended,
    /// The frame was not taken; see there for what to do.
    #[error("frame not taken: {0}")]
    Refused(#[from] FrameRefusal),
    /// The time was over before a frame was whole.
    #[error("no frame within the time given")]
    TimedOut,
}

/// A matcher on a stream of bytes. Below 512 bytes of RAM.
///
/// * `R`: an [`embedded_io::Read`] that holds what comes in while nobody reads.
#[derive(Debug)]
pub struct StreamMatcher<R> {
    stream: R,
    buffer: ReadBuffer,
}

impl<R> StreamMatcher<R> {
    /// A driver; nothing is read yet.
    pub const fn new(stream: R) -> Self {
        Self { stream, buffer: ReadBuffer::new() }
    }

    /// What the link has been through.
    pub fn counters(&self) -> &Counters {
        self.buffer.decoder.counters()
    }

    /// Counts an overrun that the caller knows of: a ring that was lapped, a UART that says so.
    pub fn note_overrun(&mut self) {
        self.buffer.decoder.note_overrun();
    }

    /// The stream.
    pub fn release(self) -> R {
        self.stream
    }
}

impl<R: Read> StreamMatcher<R> {
    /// Reads once, up to 256 bytes; blocks as the stream does, until there is one.
    ///
    /// # Errors
    /// [`StreamError`], but for [`StreamError::TimedOut`].
    pub fn read(&mut self, sink: &mut impl FrameSink) -> Result<ReadStatus, StreamError<R::Error>> {
        match self.buffer.resume(sink)? {
            Some(received) => Ok(ReadStatus::Frame(received)),
            None => self.transfer(sink),
        }
    }

    fn transfer(&mut self, sink: &mut impl FrameSink) -> Result<ReadStatus, StreamError<R::Error>> {
        match self.stream.read(self.buffer.room()).map_err(StreamError::Stream)? {
            0 => Err(StreamError::Ended),
            count => Ok(self.buffer.filled(count, sink)?),
        }
    }
}

impl<R: Read + ReadReady> StreamMatcher<R> {
    /// Reads once if something waits; does not block.
    ///
    /// # Errors
    /// [`StreamError`], but for [`StreamError::TimedOut`].
    pub fn poll(&mut self, sink: &mut impl FrameSink) -> Result<ReadStatus, StreamError<R::Error>> {
        if let Some(received) = self.buffer.resume(sink)? {
            return Ok(ReadStatus::Frame(received));
        }
        if !self.stream.read_ready().map_err(StreamError::Stream)? {
            return Ok(ReadStatus::Idle);
        }
        self.transfer(sink)
    }

    /// Polls until a frame is whole.
    ///
    /// * `expired`: asked after each read or look at the stream; whether to give up.
    ///
    /// # Errors
    /// [`StreamError`]. After [`StreamError::TimedOut`] the next call reads on where this one stopped.
    pub fn poll_until(
        &mut self,
        sink: &mut impl FrameSink,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, StreamError<R::Error>> {
        until(expired, || self.poll(sink))?.ok_or(StreamError::TimedOut)
    }
}
