//! Driver of a matcher on SPI with a data-ready pin.

use core::convert::Infallible;

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;

use super::counters::Counters;
use super::read_buffer::{ReadBuffer, ReadStatus, ReceiveError, until};
use super::sink::{FrameSink, Received};

/// Driver of a matcher on SPI with chip select and a data-ready pin. Below 512 bytes of RAM.
///
/// * `SPI`: an [`SpiDevice`]; reads at most 256 bytes a transaction.
/// * `RDY`: an [`InputPin`], high while a whole frame waits. Any type, `()` too, for a caller with an
///   interrupt, who uses [`FpgaMatcher::read`].
///
/// ```
/// # use embedded_hal::{digital::InputPin, spi::SpiDevice};
/// # use stereo_selfcal::{Calibrator, link::{FpgaMatcher, ReadStatus}};
/// # fn step<S: SpiDevice, P: InputPin>(matcher: &mut FpgaMatcher<S, P>, calibrator: &mut Calibrator<f32, 256>) {
/// match matcher.poll(calibrator) {
///     Ok(ReadStatus::Frame(frame)) => (),                // the batch holds this frame: solve it
///     Ok(ReadStatus::Partial | ReadStatus::Idle) => (),  // call again later
///     Err(why) => (),                                    // log it, and call again
/// }
/// # }
/// ```
#[derive(Debug)]
pub struct FpgaMatcher<SPI, RDY> {
    spi: SPI,
    ready: RDY,
    buffer: ReadBuffer,
}

impl<SPI, RDY> FpgaMatcher<SPI, RDY> {
    /// Driver over a bus, which is not accessed yet.
    pub const fn new(spi: SPI, ready: RDY) -> Self {
        Self { spi, ready, buffer: ReadBuffer::new() }
    }

    /// Statistics of the link.
    pub fn counters(&self) -> &Counters {
        self.buffer.decoder.counters()
    }

    /// Counts an overrun that the caller detected.
    pub fn note_overrun(&mut self) {
        self.buffer.decoder.note_overrun();
    }

    /// Returns the bus and the pin.
    pub fn release(self) -> (SPI, RDY) {
        (self.spi, self.ready)
    }
}

/// For a caller whom an interrupt tells that a frame waits.
impl<SPI: SpiDevice, RDY> FpgaMatcher<SPI, RDY> {
    /// Reads without checking data-ready: at most one transaction. Call until the frame is whole, or
    /// as often as the longest expected frame takes: see [`FrameHeader::frame_bytes`].
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Refused`].
    ///
    /// [`FrameHeader::frame_bytes`]: super::FrameHeader::frame_bytes
    pub fn read(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, ReceiveError<SPI::Error, Infallible>> {
        self.buffer.advance(sink, |bytes| transfer(&mut self.spi, bytes))
    }

    /// Reads until a frame is whole.
    ///
    /// * `expired`: called after each transaction; `true` ends the wait.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Refused`], [`ReceiveError::TimedOut`].
    pub fn read_until(
        &mut self,
        sink: &mut impl FrameSink,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, ReceiveError<SPI::Error, Infallible>> {
        until(expired, || self.read(sink))
    }
}

/// For a caller who polls the data-ready pin.
impl<SPI: SpiDevice, RDY: InputPin> FpgaMatcher<SPI, RDY> {
    /// Reads if data-ready is high: at most one sample of the pin and one transaction.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ready`], [`ReceiveError::Refused`].
    pub fn poll(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<ReadStatus, ReceiveError<SPI::Error, RDY::Error>> {
        let Self { spi, ready, buffer } = self;
        buffer.advance(sink, |bytes| match ready.is_high() {
            Ok(true) => transfer(spi, bytes),
            Ok(false) => Ok(None),
            Err(error) => Err(ReceiveError::Ready(error)),
        })
    }

    /// Polls until a frame is whole.
    ///
    /// * `expired`: called after each poll; `true` ends the wait.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ready`], [`ReceiveError::Refused`],
    /// [`ReceiveError::TimedOut`].
    pub fn poll_until(
        &mut self,
        sink: &mut impl FrameSink,
        expired: impl FnMut() -> bool,
    ) -> Result<Received, ReceiveError<SPI::Error, RDY::Error>> {
        until(expired, || self.poll(sink))
    }
}

/// Fills `bytes` in one transaction.
fn transfer<SPI: SpiDevice, P>(
    spi: &mut SPI,
    bytes: &mut [u8],
) -> Result<Option<usize>, ReceiveError<SPI::Error, P>> {
    spi.read(bytes).map_err(ReceiveError::Bus)?;
    Ok(Some(bytes.len()))
}

#[cfg(feature = "async")]
impl<SPI: embedded_hal_async::spi::SpiDevice, RDY: embedded_hal_async::digital::Wait>
    FpgaMatcher<SPI, RDY>
{
    /// Waits until a frame is whole. Cancel-safe: the future may be dropped at any await, for a
    /// time-out; the next call continues, and resynchronises if a transaction was broken off.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ready`], [`ReceiveError::Refused`].
    pub async fn receive(
        &mut self,
        sink: &mut impl FrameSink,
    ) -> Result<Received, ReceiveError<SPI::Error, RDY::Error>> {
        if let Some(frame) = self.buffer.pending(sink)? {
            return Ok(frame);
        }
        loop {
            self.ready.wait_for_high().await.map_err(ReceiveError::Ready)?;
            let space = self.buffer.space();
            let count = space.len();
            self.spi.read(space).await.map_err(ReceiveError::Bus)?;
            if let ReadStatus::Frame(frame) = self.buffer.received(count, sink)? {
                return Ok(frame);
            }
        }
    }
}
