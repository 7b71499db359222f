//! A recording in flash instead of the matcher: a simulated bus replays the bytes of its frames.
//!
//! The folder `recording` has that of the data set `opencv_chess_sift`. The build script takes another folder from the
//! variable `RECORDING`. `pil` writes such a folder for any data set.

use core::cell::Cell;
use core::convert::Infallible;
use core::iter;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use stereo_selfcal::link::{FpgaMatcher, FrameHeader};
use stereo_selfcal::{FactoryCalibration, RestoreError};

/// Bytes of all frames.
pub static FRAMES: &[u8] = include_bytes!(concat!(env!("RECORDING"), "/frames.bin"));

/// Record of the cameras and of the true extrinsics.
static FACTORY: &[u8] = include_bytes!(concat!(env!("RECORDING"), "/factory.bin"));

/// Byte that an idle bus reads.
const IDLE: u8 = 0xff;

/// The cameras of the recording, and its true extrinsics: `p_r = R p_l + t`.
///
/// # Errors
/// [`RestoreError`] if the record is damaged.
pub fn factory() -> Result<FactoryCalibration<f32>, RestoreError> {
    FactoryCalibration::from_record(FACTORY)
}

/// Number of pairs of the recording.
#[must_use]
pub fn pairs() -> u32 {
    let bus = ReplayBus::new(FRAMES);
    (0..u32::MAX).find(|_| !bus.skip_frame()).unwrap_or_default()
}

/// A simulated bus that replays frames. A reference to it serves as the SPI device and as the data-ready line.
#[derive(Debug)]
pub struct ReplayBus<'a> {
    rest: Cell<&'a [u8]>,
}

impl<'a> ReplayBus<'a> {
    /// A bus at the start of `frames`.
    #[must_use]
    pub const fn new(frames: &'a [u8]) -> Self {
        Self { rest: Cell::new(frames) }
    }

    /// The driver of a matcher on this bus.
    pub fn driver(&self) -> FpgaMatcher<&Self, &Self> {
        FpgaMatcher::new(self, self)
    }

    /// Skips a frame. Returns whether there was one.
    pub fn skip_frame(&self) -> bool {
        let header = self.rest.get().first_chunk().and_then(|h| FrameHeader::decode(h).ok());
        header.map(|header| self.take(header.frame_bytes())).is_some()
    }

    /// Whether all bytes are read.
    pub fn is_at_end(&self) -> bool {
        self.rest.get().is_empty()
    }

    /// Reads the next `count` bytes, or the rest.
    pub fn take(&self, count: usize) -> &'a [u8] {
        let all = self.rest.get();
        let (taken, rest) = all.split_at_checked(count).unwrap_or((all, &[]));
        self.rest.set(rest);
        taken
    }
}

impl spi::ErrorType for &ReplayBus<'_> {
    type Error = Infallible;
}

impl SpiDevice for &ReplayBus<'_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            if let Operation::Read(buffer)
            | Operation::Transfer(buffer, _)
            | Operation::TransferInPlace(buffer) = operation
            {
                let bytes = self.take(buffer.len()).iter().copied();
                for (place, byte) in buffer.iter_mut().zip(bytes.chain(iter::repeat(IDLE))) {
                    *place = byte;
                }
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for &ReplayBus<'_> {
    type Error = Infallible;
}

impl InputPin for &ReplayBus<'_> {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(!self.is_at_end())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(self.is_at_end())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bus_replays_its_bytes_once_and_is_idle_behind_its_end() {
        let bus = ReplayBus::new(b"abcde");
        let mut bus = &bus;
        let mut bytes = [0; 4];
        assert_eq!(bus.is_high(), Ok(true));
        bus.read(&mut bytes).unwrap();
        assert_eq!(&bytes, b"abcd");
        bus.read(&mut bytes).unwrap();
        assert_eq!(bytes, [b'e', IDLE, IDLE, IDLE]);
        assert_eq!((bus.is_high(), bus.is_low()), (Ok(false), Ok(true)));
    }
}
