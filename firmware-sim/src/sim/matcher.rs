//! A matcher made of recorded data: SPI device and data-ready line over one queue of bytes.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use firmware_sim::Matcher;
use firmware_sim::frame::{FrameHeader, RESOLUTION_PX, Record};
use host_tests::dataset::Match;
use stereo_selfcal::Correspondence;
use zerocopy::IntoBytes;

type Wire = Rc<RefCell<VecDeque<u8>>>;

/// What an idle bus reads as.
const IDLE: u8 = 0xff;

/// The matcher's side of the bus.
#[derive(Debug, Default)]
pub(crate) struct SimMatcher {
    wire: Wire,
}

impl SimMatcher {
    /// The controller's side of the bus.
    pub(crate) fn driver(&self) -> Matcher<SimSpi, SimReady> {
        Matcher::new(SimSpi(Rc::clone(&self.wire)), SimReady(Rc::clone(&self.wire)))
    }

    /// Puts a pair on the bus as one frame and raises data-ready.
    pub(crate) fn send(&self, sequence: u32, pair: &[Match]) {
        self.wire.borrow_mut().extend(frame(sequence, pair));
    }
}

/// A pair as one frame. A match that no frame can carry (beyond its range, or beyond its 65535 records)
/// stays behind.
pub(crate) fn frame(sequence: u32, pair: &[Match]) -> Vec<u8> {
    let records: Vec<Record> = pair.iter().filter_map(record).take(u16::MAX.into()).collect();
    let count = u16::try_from(records.len()).unwrap_or(u16::MAX);
    [&FrameHeader { sequence, count }.encode()[..], records.as_bytes()].concat()
}

/// On the grid of the wire, which is then the grid of the coordinates too.
fn record(m: &Match) -> Option<Record> {
    let exact: Correspondence<f32> = m.correspondence();
    let grid_step = exact.grid_step.max(RESOLUTION_PX);
    Record::encode(&Correspondence { grid_step, ..exact }).ok()
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
