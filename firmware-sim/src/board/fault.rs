//! A fault ends the run, where the default would hang it.

use cortex_m_rt::{ExceptionFrame, exception};

/// Also where a panic ends, after its message.
// SAFETY: it never returns, so nothing runs on with the state that faulted.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    defmt::error!("hard fault at {=u32:#010x}", frame.pc());
    super::exit(false)
}
