//! A bus that hands out given bytes and then fails: the SPI mock at hand cannot fail.

use core::convert::Infallible;
use std::collections::VecDeque;
use std::vec::Vec;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use stereo_selfcal::Correspondence;
use zerocopy::IntoBytes;

use crate::frame::{FrameHeader, Record};

/// The bus failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BusFault;

impl spi::Error for BusFault {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

/// Bytes to be read, and how many reads succeed.
pub(crate) struct TestBus {
    bytes: VecDeque<u8>,
    reads: usize,
}

impl TestBus {
    pub(crate) fn new(bytes: Vec<u8>, reads: usize) -> Self {
        Self { bytes: bytes.into(), reads }
    }
}

impl spi::ErrorType for TestBus {
    type Error = BusFault;
}

impl SpiDevice for TestBus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusFault> {
        for operation in operations {
            let Operation::Read(buffer) = operation else { panic!("the driver only reads") };
            self.reads = self.reads.checked_sub(1).ok_or(BusFault)?;
            for byte in buffer.iter_mut() {
                *byte = self.bytes.pop_front().expect("no more than was sent is read");
            }
        }
        Ok(())
    }
}

/// Data-ready that is always high.
pub(crate) struct AlwaysReady;

impl digital::ErrorType for AlwaysReady {
    type Error = Infallible;
}

impl InputPin for AlwaysReady {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(true)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(false)
    }
}

/// The `i`-th of records that are all different, and of a scene that determines all directions.
pub(crate) fn record(i: u16) -> Record {
    let [u, v] = [i * 37 % 900 + 700, i * 71 % 1100].map(f32::from);
    let disparity = f32::from(i * 13 % 97) + 20.0;
    let c = Correspondence {
        left: [u, v],
        right: [u - disparity, v + 1.5],
        score: 0.5,
        grid_step: 0.0,
    };
    Record::encode(&c).expect("in range")
}

/// A frame of those records, as bytes.
pub(crate) fn frame(sequence: u32, records: impl ExactSizeIterator<Item = Record>) -> Vec<u8> {
    let count = records.len().try_into().expect("within a frame");
    let mut bytes = FrameHeader { sequence, count }.encode().to_vec();
    records.for_each(|record| bytes.extend_from_slice(record.as_bytes()));
    bytes
}
