//! Driver of a matcher on a byte stream: a UART, or a ring that DMA fills.

use core::convert::Infallible;

use embedded_io::{Read, ReadReady};

use super::counters::Counters;
use super::read_buffer::{ReadBuffer, ReadStatus, ReceiveError, until};
use super::sink::{FrameSink, Received};

/// Driver of a matcher on a byte stream. Below 512 bytes of RAM.
///
/// * `R`: an [`embedded_io::Read`] that buffers the bytes that arrive between reads.
#[derive(Debug)]
pub struct StreamMatcher<R> {
    stream: R,
    buffer: ReadBuffer,
}

impl<R> StreamMatcher<R> {
    /// Driver over a stream, which is not read yet.
    pub const fn new(stream: R) -> Self {
        Self { stream, buffer: ReadBuffer::new() }
    }

    /// Statistics of the link.
    pub fn counters(&self) -> &Counters {
        self.buffer.decoder.counters()
    }

    /// Counts an overrun that the caller detected: a DMA ring that wrapped, a UART that reports it.
    pub fn note_overrun(&mut self) {
        self.buffer.decoder.note_overrun();
    }

    /// Returns the stream.
    pub fn release(self) -> R {
        self.stream
    }
}

impl<R: Read> StreamMatcher<R> {
    /// Reads once, up to 256 bytes; blocks as the stream does until there is at least one.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ended`], [`ReceiveError::Refused`].
    pub fn read(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, ReceiveError<R::Error, Infallible>> {
        self.buffer.advance(sink, |bytes| read(&mut self.stream, bytes))
    }
}

impl<R: Read + ReadReady> StreamMatcher<R> {
    /// Reads once if data is waiting; does not block.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ended`], [`ReceiveError::Refused`].
    pub fn poll(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, ReceiveError<R::Error, Infallible>> {
        let Self { stream, buffer } = self;
        buffer.advance(sink, |bytes| match stream.read_ready() {
            Ok(true) => read(stream, bytes),
            Ok(false) => Ok(None),
            Err(error) => Err(ReceiveError::Bus(error)),
        })
    }

    /// Polls until a frame is whole.
    ///
    /// * `expired`: called after each poll; `true` ends the wait.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ended`], [`ReceiveError::Refused`],
    /// [`ReceiveError::TimedOut`].
    pub fn poll_until(
        &mut self,
        sink: &mut impl FrameSink,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, ReceiveError<R::Error, Infallible>> {
        until(expired, || self.poll(sink))
    }
}

/// Reads at least one byte.
fn read<R: Read>(
    stream: &mut R,
    bytes: &mut [u8],
) -> Result<Option<usize>, ReceiveError<R::Error, Infallible>> {
    match stream.read(bytes).map_err(ReceiveError::Bus)? {
        0 => Err(ReceiveError::Ended),
        count => Ok(Some(count)),
    }
}
