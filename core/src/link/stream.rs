//! Driver of a matcher on a stream of bytes: a UART, or a ring that DMA fills.

use embedded_io::{Read, ReadReady};
use thiserror::Error;

use super::counters::Counters;
use super::inlet::{Inlet, Polled, until};
use super::intake::{FrameRefusal, Intake, Received};

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

codes! {
    StreamError[E] { Stream = 1160, Ended = 1161, TimedOut = 1162, Refused { 0: why } = why.code() }
}

/// A matcher on a stream of bytes. Below 512 bytes of RAM.
///
/// * `R`: an [`embedded_io::Read`] that holds what comes in while nobody reads.
#[derive(Debug)]
pub struct StreamMatcher<R> {
    stream: R,
    inlet: Inlet,
}

impl<R> StreamMatcher<R> {
    /// A driver; nothing is read yet.
    pub const fn new(stream: R) -> Self {
        Self { stream, inlet: Inlet::new() }
    }

    /// What the link has been through.
    pub fn counters(&self) -> &Counters {
        self.inlet.decoder.counters()
    }

    /// Counts an overrun that the caller knows of: a ring that was lapped, a UART that says so.
    pub fn note_overrun(&mut self) {
        self.inlet.decoder.note_overrun();
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
    pub fn read(&mut self, intake: &mut impl Intake) -> Result<Polled, StreamError<R::Error>> {
        match self.inlet.resume(intake)? {
            Some(received) => Ok(Polled::Frame(received)),
            None => self.transfer(intake),
        }
    }

    fn transfer(&mut self, intake: &mut impl Intake) -> Result<Polled, StreamError<R::Error>> {
        match self.stream.read(self.inlet.room()).map_err(StreamError::Stream)? {
            0 => Err(StreamError::Ended),
            count => Ok(self.inlet.filled(count, intake)?),
        }
    }
}

impl<R: Read + ReadReady> StreamMatcher<R> {
    /// Reads once if something waits; does not block.
    ///
    /// # Errors
    /// [`StreamError`], but for [`StreamError::TimedOut`].
    pub fn poll(&mut self, intake: &mut impl Intake) -> Result<Polled, StreamError<R::Error>> {
        if let Some(received) = self.inlet.resume(intake)? {
            return Ok(Polled::Frame(received));
        }
        if !self.stream.read_ready().map_err(StreamError::Stream)? {
            return Ok(Polled::Idle);
        }
        self.transfer(intake)
    }

    /// Polls until a frame is whole.
    ///
    /// * `expired`: asked after each read or look at the stream; whether to give up.
    ///
    /// # Errors
    /// [`StreamError`]. After [`StreamError::TimedOut`] the next call reads on where this one stopped.
    pub fn poll_until(
        &mut self,
        intake: &mut impl Intake,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, StreamError<R::Error>> {
        until(expired, || self.poll(intake))?.ok_or(StreamError::TimedOut)
    }
}
