//! A bus that replays given bytes and can fail once. The SPI mock of embedded-hal-mock cannot fail.

use core::cell::{Cell, RefCell};
use core::convert::Infallible;
use std::collections::VecDeque;
use std::vec::Vec;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use stereo_selfcal::Correspondence;
use stereo_selfcal::link::{FpgaMatcher, FrameCrc, FrameHeader, MatchRecord};

/// The bus failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct BusFault;

impl spi::Error for BusFault {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

/// Bytes to read. A reference is the bus; data-ready is high while bytes are left.
pub(crate) struct TestBus {
    bytes: RefCell<VecDeque<u8>>,
    /// Number of reads before the one that fails.
    good_reads: Cell<Option<usize>>,
}

impl TestBus {
    pub(crate) fn new(bytes: Vec<u8>) -> Self {
        Self { bytes: RefCell::new(bytes.into()), good_reads: Cell::new(None) }
    }

    /// Makes one read fail after `reads` others. Its bytes are lost.
    pub(crate) fn failing_after(self, reads: usize) -> Self {
        self.good_reads.set(Some(reads));
        self
    }

    pub(crate) fn driver(&self) -> FpgaMatcher<&Self, &Self> {
        FpgaMatcher::new(self, self)
    }
}

impl spi::ErrorType for &TestBus {
    type Error = BusFault;
}

impl SpiDevice for &TestBus {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), BusFault> {
        for operation in operations {
            let Operation::Read(buffer) = operation else { panic!("the driver only reads") };
            for place in buffer.iter_mut() {
                let byte = self.bytes.borrow_mut().pop_front();
                *place = byte.expect("the driver reads no more than was sent");
            }
            match self.good_reads.take() {
                Some(0) => return Err(BusFault),
                reads => self.good_reads.set(reads.map(|reads| reads - 1)),
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for &TestBus {
    type Error = Infallible;
}

impl InputPin for &TestBus {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(!self.bytes.borrow().is_empty())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(self.bytes.borrow().is_empty())
    }
}

/// The `i`-th match. All are different, and their scene makes all directions observable.
pub(crate) fn correspondence(i: u16) -> Correspondence<f32> {
    let [u, v] = [i * 37 % 900 + 700, i * 71 % 1100].map(f32::from);
    let disparity = f32::from(i * 13 % 97) + 20.0;
    Correspondence {
        left: [u, v],
        right: [u - disparity, v + 1.5],
        // A value of the wire, so that it is not rounded.
        score: 13_107.0 / 65_535.0,
        grid_step: 1.0 / 256.0,
    }
}

/// Encodes a frame of these matches, of images of 1920 x 1200 px.
pub(crate) fn frame(sequence: u32, matches: impl ExactSizeIterator<Item = u16>) -> Vec<u8> {
    let header = FrameHeader {
        timestamp_us: 0,
        sequence,
        count: matches.len().try_into().expect("within a frame"),
        image_size: [1920, 1200],
        grid_step: 0,
        fraction_bits: 8,
        pyramid_ratio: 64,
        dropped_before: false,
        more_found: false,
    };
    let mut bytes = header.encode().expect("a valid header").to_vec();
    let mut crc = FrameCrc::new(bytes.first_chunk().expect("of a header's length"));
    for i in matches {
        let record = MatchRecord::encode(&correspondence(i), &header).expect("in range").to_bytes();
        crc.add(&record);
        bytes.extend(record);
    }
    bytes.extend(crc.value().to_le_bytes());
    bytes
}
