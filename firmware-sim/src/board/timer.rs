//! CMSDK timer 0: counts down at 25 MHz.

use vcell::VolatileCell;

const TIMER0: usize = 0x4000_0000;

const ENABLE: u32 = 1;
const INTERRUPT_ENABLE: u32 = 1 << 3;

#[repr(C)]
struct Registers {
    control: VolatileCell<u32>,
    value: VolatileCell<u32>,
    reload: VolatileCell<u32>,
    /// Written: clears the interrupt.
    interrupt: VolatileCell<u32>,
}

/// The timer. There is one; who makes two of it shares its settings.
pub struct Timer {
    registers: &'static Registers,
}

// SAFETY: the registers may be used from any priority: each access is one of a word, none is kept.
unsafe impl Send for Timer {}

impl Timer {
    /// Ticks in a second.
    pub const HZ: u32 = 25_000_000;

    /// Runs through all 32 bits, without an interrupt: wraps every 171 s.
    #[must_use]
    pub fn start() -> Self {
        Self::with(u32::MAX, ENABLE)
    }

    /// Interrupts every so many ticks.
    #[must_use]
    pub fn every(ticks: u32) -> Self {
        Self::with(ticks, ENABLE | INTERRUPT_ENABLE)
    }

    fn with(reload: u32, control: u32) -> Self {
        // SAFETY: the board has these registers at this address, for good, and all are 32 bits wide.
        let registers = unsafe { &*(TIMER0 as *const Registers) };
        registers.control.set(0);
        registers.reload.set(reload);
        registers.value.set(reload);
        registers.control.set(control);
        Self { registers }
    }

    /// Ticks since some moment; wraps around.
    #[must_use]
    pub fn ticks(&self) -> u32 {
        !self.registers.value.get()
    }

    /// Lets the next interrupt come.
    pub fn acknowledge(&self) {
        self.registers.interrupt.set(1);
    }

    /// No more interrupts.
    pub fn stop(&self) {
        self.registers.control.set(0);
        self.acknowledge();
    }
}
