//! A recording in flash instead of the matcher: a simulated bus replays the bytes of its frames.
//!
//! The build script generates it from the data set `opencv_chess_sift`.

use core::cell::Cell;
use core::convert::Infallible;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use stereo_selfcal::geometry::{CameraError, ExtrinsicsError, RadialTangential};
use stereo_selfcal::link::{FpgaMatcher, FrameHeader};
use stereo_selfcal::{Camera, Cameras, Extrinsics, Intrinsics, Lens, Scalar};

#[expect(clippy::unreadable_literal, missing_docs, reason = "numbers of the data set")]
mod generated {
    include!(concat!(env!("OUT_DIR"), "/recording.rs"));
}

pub use generated::{NAME, PAIRS};

/// Bytes of all frames.
pub static FRAMES: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/frames.bin"));

/// Byte that an idle bus reads.
const IDLE: u8 = 0xff;

/// The cameras of the recording.
///
/// # Errors
/// [`CameraError`] if a camera of the data set is invalid.
pub fn cameras() -> Result<Cameras<f32>, CameraError> {
    Ok(Cameras {
        left: camera(&generated::LEFT, generated::LEFT_LENS)?,
        right: camera(&generated::RIGHT, generated::RIGHT_LENS)?,
    })
}

fn camera(k: &[[f64; 3]; 3], lens: [f64; 5]) -> Result<Camera<f32>, CameraError> {
    let [[fx, _, cx], [_, fy, cy], _] = *k;
    let intrinsics = Intrinsics {
        focal: [fx, fy].map(f32::lit),
        principal: [cx, cy].map(f32::lit),
        size: generated::SIZE,
    };
    let lens = RadialTangential::try_new(lens.map(f32::lit))?;
    Camera::try_new(intrinsics, Lens::RadialTangential(lens))
}

/// The true extrinsics of the data set: `p_r = R p_l + t`.
///
/// # Errors
/// [`ExtrinsicsError`] if the extrinsics of the data set are invalid.
pub fn truth() -> Result<Extrinsics<f32>, ExtrinsicsError> {
    let r = generated::R.map(|row| row.map(f32::lit));
    let columns = core::array::from_fn(|j| r.map(|row| row.get(j).copied().unwrap_or_default()));
    Extrinsics::try_new(&columns.into(), &generated::T.map(f32::lit).into())
}

/// A simulated bus that replays frames. A reference to it serves as the SPI device and as the data-ready line.
#[derive(Debug)]
pub struct ReplayBus {
    rest: Cell<&'static [u8]>,
}

impl ReplayBus {
    /// A bus at the start of `frames`.
    #[must_use]
    pub const fn new(frames: &'static [u8]) -> Self {
        Self { rest: Cell::new(frames) }
    }

    /// The driver of a matcher on this bus.
    pub fn driver(&self) -> FpgaMatcher<&Self, &Self> {
        FpgaMatcher::new(self, self)
    }

    /// Skips `count` frames.
    pub fn skip_frames(&self, count: u32) {
        for _ in 0..count {
            let header = self.rest.get().first_chunk().and_then(|h| FrameHeader::decode(h).ok());
            self.take(header.map_or(0, |header| header.frame_bytes()));
        }
    }

    /// Whether all bytes are read.
    pub fn is_at_end(&self) -> bool {
        self.rest.get().is_empty()
    }

    /// Reads the next `count` bytes, or the rest.
    pub fn take(&self, count: usize) -> &'static [u8] {
        let all = self.rest.get();
        let (taken, rest) = all.split_at_checked(count).unwrap_or((all, &[]));
        self.rest.set(rest);
        taken
    }
}

impl spi::ErrorType for &ReplayBus {
    type Error = Infallible;
}

impl SpiDevice for &ReplayBus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            if let Operation::Read(buffer)
            | Operation::Transfer(buffer, _)
            | Operation::TransferInPlace(buffer) = operation
            {
                let bytes = self.take(buffer.len()).iter().copied();
                for (place, byte) in buffer.iter_mut().zip(bytes.chain(core::iter::repeat(IDLE))) {
                    *place = byte;
                }
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for &ReplayBus {
    type Error = Infallible;
}

impl InputPin for &ReplayBus {
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
