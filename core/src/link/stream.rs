//! Matcher on a byte stream: a UART, or a ring that DMA fills.

use core::convert::Infallible;

use embedded_io::{Read, ReadReady};

use super::receiver::{FrameReceiver, ReadySource, ReceiveError, Source};

/// Driver of a matcher on a byte stream.
///
/// * `R`: an [`embedded_io::Read`] that buffers the bytes that arrive between reads.
pub type StreamMatcher<R> = FrameReceiver<StreamSource<R>>;

/// Byte stream.
#[derive(Debug)]
pub struct StreamSource<R>(R);

impl<R> StreamMatcher<R> {
    /// Returns a driver over a stream. The stream is not read yet.
    pub const fn new(stream: R) -> Self {
        Self::over(StreamSource(stream))
    }

    /// Returns the stream.
    pub fn release(self) -> R {
        self.source.0
    }
}

impl<R: Read> Source for StreamSource<R> {
    type Error = R::Error;

    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, R::Error> {
        self.0.read(bytes)
    }
}

impl<R: Read + ReadReady> ReadySource for StreamSource<R> {
    type ReadyError = Infallible;

    fn is_ready(&mut self) -> Result<bool, ReceiveError<R::Error, Infallible>> {
        self.0.read_ready().map_err(ReceiveError::Bus)
    }
}
