//! CMSDK UART 0, polled.

use vcell::VolatileCell;

const UART0: usize = 0x4000_4000;

const TRANSMIT_FULL: u32 = 1;
const RECEIVE_FULL: u32 = 1 << 1;
const ENABLE_BOTH: u32 = 0b11;

/// The smallest valid value. The emulator ignores the baud rate.
const BAUD_DIVIDER: u32 = 16;

#[repr(C)]
struct Registers {
    data: VolatileCell<u32>,
    state: VolatileCell<u32>,
    control: VolatileCell<u32>,
    interrupt: VolatileCell<u32>,
    baud_divider: VolatileCell<u32>,
}

/// The UART. All values share the one UART.
pub struct Uart {
    registers: &'static Registers,
}

impl Uart {
    /// Enables transmitter and receiver.
    #[must_use]
    pub fn start() -> Self {
        // SAFETY: the board has these 32-bit registers at this address, always.
        let registers = unsafe { &*(UART0 as *const Registers) };
        registers.baud_divider.set(BAUD_DIVIDER);
        registers.control.set(ENABLE_BOTH);
        Self { registers }
    }

    /// Whether a received byte waits.
    #[must_use]
    pub fn has_byte(&self) -> bool {
        self.registers.state.get() & RECEIVE_FULL != 0
    }

    /// Reads the received byte. The receiver holds one byte.
    #[must_use]
    pub fn read(&self) -> Option<u8> {
        let [byte, ..] = self.has_byte().then(|| self.registers.data.get())?.to_le_bytes();
        Some(byte)
    }

    /// Sends bytes. Returns when the last is in the transmit register.
    pub fn write(&self, bytes: &[u8]) {
        for &byte in bytes {
            while self.registers.state.get() & TRANSMIT_FULL != 0 {}
            self.registers.data.set(byte.into());
        }
    }
}
