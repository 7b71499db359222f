//! Driver of a matcher on SPI with a data-ready line.

use core::convert::Infallible;

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use thiserror::Error;

use super::counters::Counters;
use super::inlet::{Inlet, Polled, until};
use super::intake::{FrameRefusal, Intake, Received};

/// Why a call gave no frame. Call again: the decoder keeps its place, and finds the next frame where
/// bytes are missing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum FpgaError<S, P> {
    /// The bus failed: what it read is lost.
    #[error("bus: {0:?}")]
    Bus(S),
    /// The data-ready line could not be read. Nothing is lost.
    #[error("data-ready line: {0:?}")]
    Ready(P),
    /// The frame was not taken; see there for what to do.
    #[error("frame not taken: {0}")]
    Refused(#[from] FrameRefusal),
    /// The time was over before a frame was whole.
    #[error("no frame within the time given")]
    TimedOut,
}

codes! {
    FpgaError[S, P] { Bus = 1150, Ready = 1151, TimedOut = 1152, Refused { 0: why } = why.code() }
}

/// A matcher on SPI with chip select and a data-ready line. Below 512 bytes of RAM.
///
/// * `SPI`: an [`SpiDevice`]; the largest read is 256 bytes.
/// * `RDY`: an [`InputPin`], high while a whole frame waits; anything for a caller with an interrupt.
///
/// ```
/// # use embedded_hal::{digital::InputPin, spi::SpiDevice};
/// # use stereo_selfcal::{Calibrator, link::{FpgaMatcher, Polled}};
/// # fn step<S: SpiDevice, P: InputPin>(matcher: &mut FpgaMatcher<S, P>, calibrator: &mut Calibrator<f32, 256>) {
/// match matcher.poll(calibrator) {
///     Ok(Polled::Frame(frame)) => (),              // the batch is this frame: solve it
///     Ok(Polled::Reading | Polled::Idle) => (),    // call again, or do something else
///     Err(why) => (),                              // log it, and call again
/// }
/// # }
/// ```
#[derive(Debug)]
pub struct FpgaMatcher<SPI, RDY> {
    spi: SPI,
    ready: RDY,
    inlet: Inlet,
}

impl<SPI, RDY> FpgaMatcher<SPI, RDY> {
    /// A driver; the bus is not touched.
    pub const fn new(spi: SPI, ready: RDY) -> Self {
        Self { spi, ready, inlet: Inlet::new() }
    }

    /// What the link has been through.
    pub fn counters(&self) -> &Counters {
        self.inlet.decoder.counters()
    }

    /// Counts an overrun that the caller knows of.
    pub fn note_overrun(&mut self) {
        self.inlet.decoder.note_overrun();
    }

    /// The bus and the line.
    pub fn release(self) -> (SPI, RDY) {
        (self.spi, self.ready)
    }
}

/// The caller's interrupt says that a frame waits; `RDY` may be `()`.
impl<SPI: SpiDevice, RDY> FpgaMatcher<SPI, RDY> {
    /// Reads on without a look at data-ready: at most one transaction. Call until the frame is whole,
    /// or as often as the longest frame expected takes, see [`FrameHeader::frame_bytes`].
    ///
    /// # Errors
    /// [`FpgaError`], but for [`FpgaError::Ready`] and [`FpgaError::TimedOut`].
    ///
    /// [`FrameHeader::frame_bytes`]: super::FrameHeader::frame_bytes
    pub fn read(
        &mut self,
        intake: &mut impl Intake,
    ) -> Result<Polled, FpgaError<SPI::Error, Infallible>> {
        match self.inlet.resume(intake)? {
            Some(received) => Ok(Polled::Frame(received)),
            None => self.transfer(intake),
        }
    }

    /// Reads until a frame is whole.
    ///
    /// * `expired`: asked after each transaction; whether to give up.
    ///
    /// # Errors
    /// [`FpgaError`], but for [`FpgaError::Ready`].
    pub fn read_until(
        &mut self,
        intake: &mut impl Intake,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, FpgaError<SPI::Error, Infallible>> {
        until(expired, || self.read(intake))?.ok_or(FpgaError::TimedOut)
    }

    /// One transaction, no further than to the end of a frame or of a header.
    fn transfer<P>(
        &mut self,
        intake: &mut impl Intake,
    ) -> Result<Polled, FpgaError<SPI::Error, P>> {
        let room = self.inlet.room();
        let count = room.len();
        self.spi.read(room).map_err(FpgaError::Bus)?;
        Ok(self.inlet.filled(count, intake)?)
    }
}

/// The data-ready line says whether a frame waits.
impl<SPI: SpiDevice, RDY: InputPin> FpgaMatcher<SPI, RDY> {
    /// Reads on while data-ready is high: at most one look at it and one transaction.
    ///
    /// # Errors
    /// [`FpgaError`], but for [`FpgaError::TimedOut`].
    pub fn poll(
        &mut self,
        intake: &mut impl Intake,
    ) -> Result<Polled, FpgaError<SPI::Error, RDY::Error>> {
        if let Some(received) = self.inlet.resume(intake)? {
            return Ok(Polled::Frame(received));
        }
        if !self.ready.is_high().map_err(FpgaError::Ready)? {
            return Ok(Polled::Idle);
        }
        self.transfer(intake)
    }

    /// Polls until a frame is whole.
    ///
    /// * `expired`: asked after each transaction or look at the line; whether to give up.
    ///
    /// # Errors
    /// [`FpgaError`]. After [`FpgaError::TimedOut`] the next call reads on where this one stopped.
    pub fn poll_until(
        &mut self,
        intake: &mut impl Intake,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, FpgaError<SPI::Error, RDY::Error>> {
        until(expired, || self.poll(intake))?.ok_or(FpgaError::TimedOut)
    }
}

#[cfg(feature = "async")]
impl<SPI: embedded_hal_async::spi::SpiDevice, RDY: embedded_hal_async::digital::Wait>
    FpgaMatcher<SPI, RDY>
{
    /// Waits for frames until one is whole. May be dropped at any await, for a time-out: the next call
    /// reads on, and finds the next frame if a transaction was broken off.
    ///
    /// # Errors
    /// [`FpgaError`], but for [`FpgaError::TimedOut`].
    pub async fn receive(
        &mut self,
        intake: &mut impl Intake,
    ) -> Result<Received, FpgaError<SPI::Error, RDY::Error>> {
        let mut polled = self.inlet.resume(intake)?.map_or(Polled::Idle, Polled::Frame);
        loop {
            if let Polled::Frame(received) = polled {
                return Ok(received);
            }
            self.ready.wait_for_high().await.map_err(FpgaError::Ready)?;
            let room = self.inlet.room();
            let count = room.len();
            self.spi.read(room).await.map_err(FpgaError::Bus)?;
            polled = self.inlet.filled(count, intake)?;
        }
    }
}
