//! A matcher made of recorded data: SPI device and data-ready line over one queue of bytes.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use stereo_selfcal::link::FpgaMatcher;

use super::sender::Sender;
use crate::data::Match;

type Wire = Rc<RefCell<VecDeque<u8>>>;

/// What an idle bus reads as.
const IDLE: u8 = 0xff;

/// How the data-ready line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DataReady {
    /// High while bytes wait.
    #[default]
    Works,
    /// Though nothing waits.
    StuckHigh,
    /// Whatever waits.
    StuckLow,
}

/// The matcher's side of the bus.
#[derive(Debug)]
pub struct SimMatcher {
    wire: Wire,
    ready: Rc<Cell<DataReady>>,
    sender: Sender,
}

impl SimMatcher {
    /// A matcher with nothing to send yet.
    #[must_use]
    pub fn new(sender: Sender) -> Self {
        Self { wire: Wire::default(), ready: Rc::default(), sender }
    }

    /// The controller's side of the bus.
    #[must_use]
    pub fn driver(&self) -> FpgaMatcher<SimSpi, SimReady> {
        let ready = SimReady { wire: Rc::clone(&self.wire), line: Rc::clone(&self.ready) };
        FpgaMatcher::new(SimSpi(Rc::clone(&self.wire)), ready)
    }

    /// Puts a pair on the bus as one frame and raises data-ready.
    pub fn send(&self, sequence: u32, pair: &[Match]) {
        self.put(self.sender.frame(sequence, pair).0);
    }

    /// Puts bytes on the bus.
    pub fn put(&self, bytes: Vec<u8>) {
        self.wire.borrow_mut().extend(bytes);
    }

    /// Unread bytes.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.wire.borrow().len()
    }

    /// Lets data-ready stick, or work again.
    pub fn set_ready(&self, line: DataReady) {
        self.ready.set(line);
    }
}

/// The bus: reads take sent bytes, writes are discarded.
#[derive(Debug)]
pub struct SimSpi(Wire);

impl spi::ErrorType for SimSpi {
    type Error = Infallible;
}

impl SpiDevice for SimSpi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        let mut wire = self.0.borrow_mut();
        for operation in operations {
            if let Operation::Read(buffer)
            | Operation::Transfer(buffer, _)
            | Operation::TransferInPlace(buffer) = operation
            {
                buffer.fill_with(|| wire.pop_front().unwrap_or(IDLE));
            }
        }
        Ok(())
    }
}

/// The data-ready line.
#[derive(Debug)]
pub struct SimReady {
    wire: Wire,
    line: Rc<Cell<DataReady>>,
}

impl digital::ErrorType for SimReady {
    type Error = Infallible;
}

impl InputPin for SimReady {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(match self.line.get() {
            DataReady::Works => !self.wire.borrow().is_empty(),
            DataReady::StuckHigh => true,
            DataReady::StuckLow => false,
        })
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.is_high()?)
    }
}
