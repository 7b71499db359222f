//! CMSDK UART 0, polled.

use vcell::VolatileCell;

const UART0: usize = 0x4000_4000;

const TRANSMIT_FULL: u32 = 1;
const RECEIVE_FULL: u32 = 1 << 1;
const ENABLE_BOTH: u32 = 0b11;

/// The smallest that the hardware takes; the emulator's line has no rate.
const BAUD_DIVIDER: u32 = 16;

#[repr(C)]
struct Registers {
    data: VolatileCell<u32>,
    state: VolatileCell<u32>,
    control: VolatileCell<u32>,
    interrupt: VolatileCell<u32>,
    baud_divider: VolatileCell<u32>,
}

/// The UART. There is one; who makes two of it shares its bytes.
pub struct Uart {
    registers: &'static Registers,
}

impl Uart {
    /// Turned on, both ways.
    #[must_use]
    pub fn start() -> Self {
        // SAFETY: the board has these registers at this address, for good, and all are 32 bits wide.
        let registers = unsafe { &*(UART0 as *const Registers) };
        registers.baud_divider.set(BAUD_DIVIDER);
        registers.control.set(ENABLE_BOTH);
        Self { registers }
    }

    /// Whether a byte has come in.
    #[must_use]
    pub fn has_byte(&self) -> bool {
        self.registers.state.get() & RECEIVE_FULL != 0
    }

    /// The byte that has come in. Until it is read no further one does.
    #[must_use]
    pub fn read(&self) -> Option<u8> {
        let [byte, ..] = self.has_byte().then(|| self.registers.data.get())?.to_le_bytes();
        Some(byte)
    }

    /// Sends bytes, and waits until the last is on its way.
    pub fn write(&self, bytes: &[u8]) {
        for &byte in bytes {
            while self.registers.state.get() & TRANSMIT_FULL != 0 {}
            self.registers.data.set(byte.into());
        }
    }
}
