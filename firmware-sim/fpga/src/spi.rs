//! The controller's pins: an SPI device and a data-ready pin over the simulated framer.

use std::cell::RefCell;
use std::convert::Infallible;
use std::rc::Rc;

use embedded_hal::digital::{self, InputPin};
use embedded_hal::spi::{self, Operation, SpiDevice};

use crate::bench::Bench;

/// Half a period of SCK: four cycles of the clock that samples it.
const HALF_SCK: u64 = 32;

/// Clocks `bits` of a transfer, with chip select low. Returns the bits that were read.
fn clock_bits(bench: &mut Bench, bits: u32) -> u8 {
    let mut byte = 0;
    for _ in 0..bits {
        bench.run(HALF_SCK);
        byte = byte << 1 | u8::from(bench.outputs.miso);
        bench.inputs.sck = true;
        bench.run(HALF_SCK);
        bench.inputs.sck = false;
    }
    byte
}

/// Reads `bytes` and then `bits` of one more byte, in one transaction in mode 0.
pub fn transfer(bench: &mut Bench, bytes: &mut [u8], bits: u32) {
    bench.inputs.cs_n = false;
    bytes.fill_with(|| clock_bits(bench, 8));
    clock_bits(bench, bits);
    bench.run(HALF_SCK);
    bench.inputs.cs_n = true;
    bench.run(2 * HALF_SCK);
}

/// The bus.
#[derive(Debug, Clone)]
pub struct Spi(pub Rc<RefCell<Bench>>);

impl spi::ErrorType for Spi {
    type Error = Infallible;
}

impl SpiDevice for Spi {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Infallible> {
        for operation in operations {
            if let Operation::Read(bytes) = operation {
                transfer(&mut self.0.borrow_mut(), bytes, 0);
            }
        }
        Ok(())
    }
}

/// The data-ready pin. Time passes while it is polled.
#[derive(Debug, Clone)]
pub struct Ready(pub Rc<RefCell<Bench>>);

impl digital::ErrorType for Ready {
    type Error = Infallible;
}

impl InputPin for Ready {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let mut bench = self.0.borrow_mut();
        bench.run(HALF_SCK);
        Ok(bench.outputs.m_available)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        Ok(!self.is_high()?)
    }
}
