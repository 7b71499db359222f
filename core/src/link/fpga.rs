//! Matcher on SPI with a data-ready pin.

use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;

use super::receiver::{FrameReceiver, ReadySource, ReceiveError, Source};

/// Driver of a matcher on SPI with chip select and a data-ready pin.
///
/// * `SPI`: an [`SpiDevice`]; [`FrameReceiver::read`] and [`FrameReceiver::poll`] make at most one transaction each.
/// * `RDY`: an [`InputPin`], high while a whole frame waits or is partly read. A caller with an interrupt needs no
///   pin: `RDY` may be `()`, with [`FrameReceiver::read`].
///
/// ```
/// # use embedded_hal::{digital::InputPin, spi::SpiDevice};
/// # use stereo_selfcal::{Calibrator, link::{FpgaMatcher, ReadStatus}};
/// # fn step<S: SpiDevice, P: InputPin>(matcher: &mut FpgaMatcher<S, P>, calibrator: &mut Calibrator<f32, 256>) {
/// match matcher.poll(calibrator) {
///     Ok(ReadStatus::Frame(frame)) => (),               // the batch holds this frame: solve it
///     Ok(ReadStatus::Partial | ReadStatus::Idle) => (), // call again later
///     Err(why) => (),                                   // log it, and call again
/// }
/// # }
/// ```
pub type FpgaMatcher<SPI, RDY> = FrameReceiver<SpiSource<SPI, RDY>>;

/// SPI device and data-ready pin.
#[derive(Debug)]
pub struct SpiSource<SPI, RDY> {
    spi: SPI,
    ready: RDY,
}

impl<SPI, RDY> FpgaMatcher<SPI, RDY> {
    /// Returns a driver over a bus. The bus is not accessed yet.
    pub const fn new(spi: SPI, ready: RDY) -> Self {
        Self::over(SpiSource { spi, ready })
    }

    /// Returns the bus and the pin.
    pub fn release(self) -> (SPI, RDY) {
        (self.source.spi, self.source.ready)
    }
}

impl<SPI: SpiDevice, RDY> Source for SpiSource<SPI, RDY> {
    type Error = SPI::Error;

    fn read(&mut self, bytes: &mut [u8]) -> Result<usize, SPI::Error> {
        self.spi.read(bytes).map(|()| bytes.len())
    }
}

impl<SPI: SpiDevice, RDY: InputPin> ReadySource for SpiSource<SPI, RDY> {
    type ReadyError = RDY::Error;

    fn is_ready(&mut self) -> Result<bool, ReceiveError<SPI::Error, RDY::Error>> {
        self.ready.is_high().map_err(ReceiveError::Ready)
    }
}

#[cfg(feature = "async")]
impl<SPI: embedded_hal_async::spi::SpiDevice, RDY: embedded_hal_async::digital::Wait>
    FpgaMatcher<SPI, RDY>
{
    /// Waits until a frame is whole, and returns it. Cancel-safe: the future may be dropped at any await, for example
    /// after a time-out; the next call continues, and resynchronises after a broken transaction.
    ///
    /// # Errors
    /// [`ReceiveError::Bus`], [`ReceiveError::Ready`], [`ReceiveError::Refused`].
    pub async fn receive(
        &mut self,
        sink: &mut impl super::sink::FrameSink,
    ) -> Result<super::sink::Received, ReceiveError<SPI::Error, RDY::Error>> {
        super::receiver::refuse_if_busy(sink)?;
        loop {
            self.source.ready.wait_for_high().await.map_err(ReceiveError::Ready)?;
            let space = self.buffer.space();
            let count = space.len();
            self.source.spi.read(space).await.map_err(ReceiveError::Bus)?;
            if let Some(frame) = self.buffer.received(count, sink)? {
                return Ok(frame);
            }
        }
    }
}
