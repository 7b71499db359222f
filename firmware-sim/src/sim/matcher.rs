//! A matcher made of recorded data: SPI device and data-ready line over one queue of bytes.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use host_tests::dataset::Match;
use host_tests::wire::Sender;
use stereo_selfcal::link::FpgaMatcher;

type Wire = Rc<RefCell<VecDeque<u8>>>;

/// What an idle bus reads as.
const IDLE: u8 = 0xff;

/// The matcher's side of the bus.
#[derive(Debug)]
pub(crate) struct SimMatcher {
    wire: Wire,
    sender: Sender,
}

impl SimMatcher {
    /// A matcher with nothing to send yet.
    pub(crate) fn new(sender: Sender) -> Self {
        Self { wire: Wire::default(), sender }
    }

    /// The controller's side of the bus.
    pub(crate) fn driver(&self) -> FpgaMatcher<SimSpi, SimReady> {
        FpgaMatcher::new(SimSpi(Rc::clone(&self.wire)), SimReady(Rc::clone(&self.wire)))
    }

    /// Puts a pair on the bus as one frame and raises data-ready.
    pub(crate) fn send(&self, sequence: u32, pair: &[Match]) {
        self.wire.borrow_mut().extend(self.sender.frame(sequence, pair).0);
    }
}

/// The bus: reads take what has been sent, writes go nowhere.
#[derive(Debug)]
pub(crate) struct SimSpi(Wire);

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

/// Data-ready: high while bytes wait.
#[derive(Debug)]
pub(crate) struct SimReady(Wire);

impl digital::ErrorType for SimReady {
    type Error = Infallible;
}

impl InputPin for SimReady {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(!self.0.borrow().is_empty())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(self.0.borrow().is_empty())
    }
}
