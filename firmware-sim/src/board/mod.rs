//! The emulated board, QEMU's mps2-an386 and mps2-an500: UART, timer, flash, and the ways out.
//!
//! The only part of the firmware that touches registers.

mod fault;
#[cfg(feature = "scheduler")]
pub mod interrupts;
mod link;
mod nor_flash;
mod timer;
mod uart;

pub use link::{Link, LinkError};
pub use nor_flash::{FlashError, NorFlash};
pub use timer::Timer;
pub use uart::Uart;

/// Ends the run: the emulator's exit status is 0 after a success, 1 otherwise.
pub fn exit(success: bool) -> ! {
    semihosting::process::exit(i32::from(!success))
}

/// Starts anew, as after a loss of power but for the flash.
pub fn reset() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
