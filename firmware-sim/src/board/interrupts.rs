//! Interrupts of the board and their vectors, named as in a device crate.

use cortex_m::interrupt::InterruptNumber;

/// Number of priority bits of the interrupt controller.
pub const NVIC_PRIO_BITS: u8 = 3;

/// Number of vectors, up to the last interrupt.
const VECTORS: usize = Interrupt::TIMER0 as usize + 1;

/// Interrupts with a handler. The others of the board stay disabled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// Interrupt of [`super::Timer`].
    TIMER0 = 8,
}

// The name that RTIC expects.
pub use Interrupt as interrupt;

// SAFETY: the number belongs to the board.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

/// Enables an interrupt. RTIC does so itself.
pub fn enable(interrupt: Interrupt) {
    // SAFETY: no critical section here masks a single interrupt, so this breaks none.
    unsafe { cortex_m::peripheral::NVIC::unmask(interrupt) }
}

type Handler = unsafe extern "C" fn();

// SAFETY: `device.x` names a handler for each interrupt.
unsafe extern "C" {
    fn TIMER0();
}

// SAFETY: the runtime reads the section as the vectors of interrupts 0 and up; an unused one is zero.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
#[doc(hidden)]
pub static __INTERRUPTS: [Option<Handler>; VECTORS] = {
    let mut vectors: [Option<Handler>; VECTORS] = [None; VECTORS];
    let [.., last] = &mut vectors;
    *last = Some(TIMER0);
    vectors
};
