//! Ends the run on a fault. The default handler loops forever.

use cortex_m_rt::{ExceptionFrame, exception};

/// A panic ends here too, after its message.
// SAFETY: never returns, so no code runs with the faulted state.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    defmt::error!("hard fault at {=u32:#010x}", frame.pc());
    super::exit(false)
}
