//! Drivers of the emulated boards, QEMU's mps2-an386 and mps2-an500: UART, timer, flash, exit and reset.
//!
//! No other part of the firmware accesses registers.

mod fault;
#[cfg(any(feature = "scheduler", feature = "embassy"))]
pub mod interrupts;
mod link;
mod nor_flash;
mod timer;
mod uart;

pub use link::{Link, LinkError};
pub use nor_flash::{FlashError, NorFlash};
pub use timer::Timer;
pub use uart::Uart;

/// Ends the run. The emulator's exit status is 0 for a success, 1 otherwise.
pub fn exit(success: bool) -> ! {
    semihosting::process::exit(i32::from(!success))
}

/// Resets the controller. Only the flash keeps its content.
pub fn reset() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
