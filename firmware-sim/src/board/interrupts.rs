//! Interrupts that firmware may handle, as a device crate would name them, and their vectors.

use cortex_m::interrupt::InterruptNumber;

/// Bits of a priority that the controller has.
pub const NVIC_PRIO_BITS: u8 = 3;

/// Vectors up to the last interrupt that may be handled.
const VECTORS: usize = Interrupt::TIMER0 as usize + 1;

/// The timer's. What the UART and the others of the board would raise stays off.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u16)]
pub enum Interrupt {
    /// Of [`super::Timer`].
    TIMER0 = 8,
}

// As the scheduler calls it.
pub use Interrupt as interrupt;

// SAFETY: the number is that of the board.
unsafe impl InterruptNumber for Interrupt {
    fn number(self) -> u16 {
        self as u16
    }
}

type Handler = unsafe extern "C" fn();

// SAFETY: `device.x` names a handler where the firmware has none.
unsafe extern "C" {
    fn TIMER0();
}

// SAFETY: the runtime reads the section as the vectors of interrupts 0 and up; an empty one is zero.
#[unsafe(link_section = ".vector_table.interrupts")]
#[unsafe(no_mangle)]
#[doc(hidden)]
pub static __INTERRUPTS: [Option<Handler>; VECTORS] = {
    let mut vectors: [Option<Handler>; VECTORS] = [None; VECTORS];
    vectors[Interrupt::TIMER0 as usize] = Some(TIMER0);
    vectors
};
