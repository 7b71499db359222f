//! A simulated wire: the test sends bytes, and a driver reads them by SPI with a data-ready pin, or by a UART.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use embedded_io::{Read, ReadReady};

/// Byte that a read of an idle bus returns.
const IDLE: u8 = 0xff;

/// Most bytes in a read of the UART.
const UART_BYTES: usize = 100;

/// Number of remembered accesses.
const REMEMBERED: usize = 32;

/// State of the data-ready line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DataReady {
    /// High while bytes wait.
    #[default]
    Works,
    /// High although no byte waits.
    StuckHigh,
    /// Low although bytes may wait.
    StuckLow,
    /// Reading the pin fails.
    Unreadable,
}

/// An access by the driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Access {
    /// The data-ready pin was read.
    Pin,
    /// A read of this number of bytes: a transaction of the SPI, or a read of the UART.
    Read(usize),
}

/// The wire. Clones are ends of the same wire, for the sender, the bus and the data-ready pin.
#[derive(Debug, Clone, Default)]
pub struct Wire(Rc<RefCell<State>>);

#[derive(Debug, Default)]
struct State {
    waiting: VecDeque<u8>,
    line: DataReady,
    accesses: VecDeque<Access>,
    /// Number of reads before the one that fails; `None` if no read fails.
    good_reads: Option<usize>,
    /// Whether a read beyond the waiting bytes is a fault of the driver.
    exact: bool,
}

impl Wire {
    /// A wire that panics if the driver reads more bytes than wait.
    #[must_use]
    pub fn exact() -> Self {
        Self(Rc::new(RefCell::new(State { exact: true, ..State::default() })))
    }

    /// Puts bytes on the wire.
    pub fn send(&self, bytes: impl IntoIterator<Item = u8>) {
        self.0.borrow_mut().waiting.extend(bytes);
    }

    /// Number of bytes that wait.
    #[must_use]
    pub fn waiting(&self) -> usize {
        self.0.borrow().waiting.len()
    }

    /// Sets the state of the data-ready line.
    pub fn set_ready(&self, line: DataReady) {
        self.0.borrow_mut().line = line;
    }

    /// Makes one read fail after `reads` good ones. The bytes of the failed read are lost.
    pub fn fail_after(&self, reads: usize) {
        self.0.borrow_mut().good_reads = Some(reads);
    }

    /// The last accesses of the driver, at most 32.
    #[must_use]
    pub fn accesses(&self) -> Vec<Access> {
        self.0.borrow().accesses.iter().copied().collect()
    }
}

impl State {
    fn note(&mut self, access: Access) {
        if self.accesses.len() == REMEMBERED {
            self.accesses.pop_front();
        }
        self.accesses.push_back(access);
    }

    /// Moves the bytes that wait into the buffer, as many as fit, and returns their number. `None` if the read fails.
    fn read(&mut self, buffer: &mut [u8]) -> Option<usize> {
        self.note(Access::Read(buffer.len()));
        assert!(!self.exact || buffer.len() <= self.waiting.len(), "a read of more than was sent");
        let count = buffer.len().min(self.waiting.len());
        for (place, byte) in buffer.iter_mut().zip(self.waiting.drain(..count)) {
            *place = byte;
        }
        let reads = self.good_reads.take();
        self.good_reads = reads.and_then(|reads| reads.checked_sub(1));
        (reads != Some(0)).then_some(count)
    }
}

impl spi::ErrorType for Wire {
    type Error = spi::ErrorKind;
}

/// It panics if the driver does anything but one read in a transaction.
impl SpiDevice for Wire {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), spi::ErrorKind> {
        let [Operation::Read(buffer)] = operations else { panic!("not one read: {operations:?}") };
        buffer.fill(IDLE);
        self.0.borrow_mut().read(buffer).map(|_| ()).ok_or(spi::ErrorKind::Overrun)
    }
}

impl digital::ErrorType for Wire {
    type Error = digital::ErrorKind;
}

impl InputPin for Wire {
    fn is_high(&mut self) -> Result<bool, digital::ErrorKind> {
        let mut state = self.0.borrow_mut();
        state.note(Access::Pin);
        match state.line {
            DataReady::Works => Ok(!state.waiting.is_empty()),
            DataReady::StuckHigh => Ok(true),
            DataReady::StuckLow => Ok(false),
            DataReady::Unreadable => Err(digital::ErrorKind::Other),
        }
    }

    fn is_low(&mut self) -> Result<bool, digital::ErrorKind> {
        self.is_high().map(|high| !high)
    }
}

impl embedded_io::ErrorType for Wire {
    type Error = embedded_io::ErrorKind;
}

/// A UART with at most 100 bytes per read.
impl Read for Wire {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize, embedded_io::ErrorKind> {
        let most = buffer.len().min(UART_BYTES);
        self.0.borrow_mut().read(&mut buffer[..most]).ok_or(embedded_io::ErrorKind::Other)
    }
}

impl ReadReady for Wire {
    fn read_ready(&mut self) -> Result<bool, embedded_io::ErrorKind> {
        Ok(self.waiting() > 0)
    }
}
