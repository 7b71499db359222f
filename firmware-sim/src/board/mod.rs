//! Drivers of the emulated boards, QEMU's mps2-an386 and mps2-an500: timer, flash, exit and reset.
//!
//! No other part of the firmware accesses registers.

mod fault;
pub mod interrupts;
mod nor_flash;
mod timer;

pub use nor_flash::{FlashError, NorFlash};
pub use timer::Timer;

/// Ends the run. The emulator's exit status is 0 for a success, 1 otherwise.
pub fn exit(success: bool) -> ! {
    semihosting::process::exit(i32::from(!success))
}

/// Resets the controller. Only the flash keeps its content.
pub fn reset() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
