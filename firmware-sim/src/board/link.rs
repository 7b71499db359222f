//! The UART in place of the matcher's bus. `&Link` is both the SPI device and the data-ready line.
//!
//! Reads and writes go to the line. Data-ready is high while a received byte waits. The sender sends whole
//! frames.

use core::cell::Cell;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use thiserror::Error;

use super::{Timer, Uart};

/// Timeout of the sender, ticks: one minute.
const TIMEOUT: u32 = 60 * Timer::HZ;

/// Why an access to the line failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error, defmt::Format)]
pub enum LinkError {
    /// No byte came for a minute.
    #[error("no byte came for a minute")]
    Silent,
    /// The line is half duplex.
    #[error("full-duplex transfers are not supported")]
    Duplex,
}

impl spi::Error for LinkError {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

impl digital::Error for LinkError {
    fn kind(&self) -> digital::ErrorKind {
        digital::ErrorKind::Other
    }
}

/// The line to the host that simulates the matcher.
pub struct Link {
    uart: Uart,
    timer: Timer,
    /// Time of the last byte, ticks.
    last_byte: Cell<u32>,
}

impl Link {
    /// A line over the UART. Its timeout begins now.
    ///
    /// * `timer`: timer of [`Timer::start`].
    #[must_use]
    pub fn new(uart: Uart, timer: Timer) -> Self {
        let last_byte = Cell::new(timer.ticks());
        Self { uart, timer, last_byte }
    }

    /// Sends bytes. Returns when the last is in the transmit register.
    pub fn send(&self, bytes: &[u8]) {
        self.uart.write(bytes);
    }

    /// Whether a byte waits.
    fn poll(&self) -> Result<bool, LinkError> {
        let now = self.timer.ticks();
        if self.uart.has_byte() {
            self.last_byte.set(now);
            return Ok(true);
        }
        if now.wrapping_sub(self.last_byte.get()) > TIMEOUT {
            return Err(LinkError::Silent);
        }
        Ok(false)
    }

    fn fill(&self, buffer: &mut [u8]) -> Result<(), LinkError> {
        for place in buffer {
            while !self.poll()? {}
            *place = self.uart.read().unwrap_or_default();
        }
        Ok(())
    }
}

impl spi::ErrorType for &Link {
    type Error = LinkError;
}

impl SpiDevice for &Link {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), LinkError> {
        for operation in operations {
            match operation {
                Operation::Read(buffer) => self.fill(buffer)?,
                Operation::Write(bytes) => self.send(bytes),
                Operation::DelayNs(_) => (),
                Operation::Transfer(..) | Operation::TransferInPlace(_) => {
                    return Err(LinkError::Duplex);
                }
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for &Link {
    type Error = LinkError;
}

impl InputPin for &Link {
    fn is_high(&mut self) -> Result<bool, LinkError> {
        self.poll()
    }

    fn is_low(&mut self) -> Result<bool, LinkError> {
        Ok(!self.poll()?)
    }
}
