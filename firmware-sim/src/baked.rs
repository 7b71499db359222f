//! A recording in flash in the matcher's place: the bytes of its frames, handed out as the bus would.
//!
//! The build script bakes it of the data set `opencv_chess_sift`.

use core::cell::Cell;
use core::convert::Infallible;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use stereo_selfcal::link::{FpgaMatcher, FrameHeader};
use stereo_selfcal::{
    Camera, CameraError, Cameras, Extrinsics, ExtrinsicsError, Intrinsics, Lens, RadialTangential,
    Scalar,
};

#[expect(clippy::unreadable_literal, missing_docs, reason = "numbers as the data set has them")]
mod recording {
    include!(concat!(env!("OUT_DIR"), "/recording.rs"));
}

pub use recording::{NAME, PAIRS};

/// All frames, one after the other.
pub static FRAMES: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/frames.bin"));

/// What an idle bus reads as.
const IDLE: u8 = 0xff;

/// The cameras that the recording was made with.
///
/// # Errors
/// [`CameraError`], for a data set whose cameras are none.
pub fn cameras() -> Result<Cameras<f32>, CameraError> {
    Ok(Cameras {
        left: camera(&recording::LEFT, recording::LEFT_LENS)?,
        right: camera(&recording::RIGHT, recording::RIGHT_LENS)?,
    })
}

fn camera(k: &[[f64; 3]; 3], lens: [f64; 5]) -> Result<Camera<f32>, CameraError> {
    let [[fx, _, cx], [_, fy, cy], _] = *k;
    let intrinsics = Intrinsics {
        focal: [fx, fy].map(f32::lit),
        principal: [cx, cy].map(f32::lit),
        size: recording::SIZE,
    };
    let lens = RadialTangential::try_new(lens.map(f32::lit))?;
    Camera::try_new(intrinsics, Lens::RadialTangential(lens))
}

/// The extrinsics that the data set holds for true: `p_r = R p_l + t`.
///
/// # Errors
/// [`ExtrinsicsError`], for a data set whose rig is none.
pub fn truth() -> Result<Extrinsics<f32>, ExtrinsicsError> {
    let r = recording::R.map(|row| row.map(f32::lit));
    let columns = core::array::from_fn(|j| r.map(|row| row.get(j).copied().unwrap_or_default()));
    Extrinsics::try_new(&columns.into(), &recording::T.map(f32::lit).into())
}

/// The bus, at some place in a recording: SPI device and data-ready line by reference.
#[derive(Debug)]
pub struct Tape {
    rest: Cell<&'static [u8]>,
}

impl Tape {
    /// At the start of these frames.
    #[must_use]
    pub const fn new(frames: &'static [u8]) -> Self {
        Self { rest: Cell::new(frames) }
    }

    /// The driver of a matcher that sends them.
    pub fn driver(&self) -> FpgaMatcher<&Self, &Self> {
        FpgaMatcher::new(self, self)
    }

    /// Winds on by so many frames.
    pub fn skip_frames(&self, count: u32) {
        for _ in 0..count {
            let header = self.rest.get().first_chunk().and_then(|h| FrameHeader::decode(h).ok());
            self.take(header.map_or(0, |header| header.frame_bytes()));
        }
    }

    /// Whether all has been read.
    pub fn is_at_end(&self) -> bool {
        self.rest.get().is_empty()
    }

    /// The next so many bytes, or those that are left.
    pub fn take(&self, count: usize) -> &'static [u8] {
        let all = self.rest.get();
        let (taken, rest) = all.split_at_checked(count).unwrap_or((all, &[]));
        self.rest.set(rest);
        taken
    }
}

impl spi::ErrorType for &Tape {
    type Error = Infallible;
}

impl SpiDevice for &Tape {
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

impl digital::ErrorType for &Tape {
    type Error = Infallible;
}

impl InputPin for &Tape {
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
    fn a_tape_hands_out_its_bytes_once_and_is_idle_behind_its_end() {
        let tape = Tape::new(b"abcde");
        let mut bus = &tape;
        let mut bytes = [0; 4];
        assert_eq!(bus.is_high(), Ok(true));
        bus.read(&mut bytes).unwrap();
        assert_eq!(&bytes, b"abcd");
        bus.read(&mut bytes).unwrap();
        assert_eq!(bytes, [b'e', IDLE, IDLE, IDLE]);
        assert_eq!((bus.is_high(), bus.is_low()), (Ok(false), Ok(true)));
    }
}
