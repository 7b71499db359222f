//! CMSDK timer 0, which counts down.

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

    /// Interrupts every `ticks` ticks.
    #[must_use]
    pub fn every(ticks: u32) -> Self {
        // SAFETY: the board has these 32-bit registers at this address, always.
        let registers = unsafe { &*(TIMER0 as *const Registers) };
        registers.control.set(0);
        registers.reload.set(ticks);
        registers.value.set(ticks);
        registers.control.set(ENABLE | INTERRUPT_ENABLE);
        Self { registers }
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
