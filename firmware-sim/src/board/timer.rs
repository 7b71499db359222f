//! CMSDK timer 0, which counts down at 25 MHz.

use vcell::VolatileCell;

const TIMER0: usize = 0x4000_0000;

const ENABLE: u32 = 1;
const INTERRUPT_ENABLE: u32 = 1 << 3;

#[repr(C)]
struct Registers {
    control: VolatileCell<u32>,
    value: VolatileCell<u32>,
    reload: VolatileCell<u32>,
    /// A write clears the interrupt.
    interrupt: VolatileCell<u32>,
}

/// The timer. All values share the settings of the one timer.
pub struct Timer {
    registers: &'static Registers,
}

// SAFETY: each access of a register is one word access, which is valid at any priority.
unsafe impl Send for Timer {}

impl Timer {
    /// Tick rate, Hz.
    pub const HZ: u32 = 25_000_000;

    /// Counts through all 32 bits without an interrupt. Wraps every 172 s.
    #[must_use]
    pub fn start() -> Self {
        Self::with(u32::MAX, ENABLE)
    }

    /// Interrupts every `ticks` ticks.
    #[must_use]
    pub fn every(ticks: u32) -> Self {
        Self::with(ticks, ENABLE | INTERRUPT_ENABLE)
    }

    fn with(reload: u32, control: u32) -> Self {
        // SAFETY: the board has these 32-bit registers at this address, always.
        let registers = unsafe { &*(TIMER0 as *const Registers) };
        registers.control.set(0);
        registers.reload.set(reload);
        registers.value.set(reload);
        registers.control.set(control);
        Self { registers }
    }

    /// Number of ticks since the start of a timer of [`Timer::start`]. Wraps around.
    #[must_use]
    pub fn ticks(&self) -> u32 {
        !self.registers.value.get()
    }

    /// Clears the interrupt.
    pub fn acknowledge(&self) {
        self.registers.interrupt.set(1);
    }

    /// Stops the timer and its interrupts.
    pub fn stop(&self) {
        self.registers.control.set(0);
        self.acknowledge();
    }
}
