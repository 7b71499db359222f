//! The UART in the place of the matcher's bus: SPI device and data-ready line by reference.
//!
//! What is read comes from the line, what is written goes to it; data-ready is high once a byte has
//! come. Whoever sends sends whole frames.

use core::cell::Cell;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use thiserror::Error;

use super::{Timer, Uart};

/// Silence after which the sender is taken for gone, ticks: one minute.
const SILENCE: u32 = 60 * Timer::HZ;

/// Why nothing was read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error, defmt::Format)]
pub enum LinkError {
    /// No byte came for a minute.
    #[error("no byte came for a minute")]
    Silent,
    /// Full duplex is what a UART does not have.
    #[error("bytes cannot be sent and read at once")]
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

/// The line to whoever plays the matcher.
pub struct Link {
    uart: Uart,
    timer: Timer,
    /// When the last byte was seen, ticks.
    heard: Cell<u32>,
}

impl Link {
    /// * `timer`: counts through all its bits.
    #[must_use]
    pub fn new(uart: Uart, timer: Timer) -> Self {
        let heard = Cell::new(timer.ticks());
        Self { uart, timer, heard }
    }

    /// Sends bytes, and waits until the last is on its way.
    pub fn send(&self, bytes: &[u8]) {
        self.uart.write(bytes);
    }

    /// Whether a byte waits.
    fn poll(&self) -> Result<bool, LinkError> {
        let now = self.timer.ticks();
        if self.uart.has_byte() {
            self.heard.set(now);
            return Ok(true);
        }
        if now.wrapping_sub(self.heard.get()) > SILENCE {
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
