//! Counts instructions with the board's timer.
//!
//! With `-icount shift=10` an instruction takes 1024 ns of virtual time. A tick of the timer is 40 ns, so
//! an instruction is 25.6 ticks. The timer wraps after 168 million instructions.

use core::ptr;

/// The first CMSDK timer of mps2-an386 and mps2-an500.
const TIMER: *mut u32 = ptr::without_provenance_mut(0x4000_0000);
const CONTROL: usize = 0;
const VALUE: usize = 1;
const RELOAD: usize = 2;

const TICK_NS: u64 = 40;
const INSTRUCTION_NS: u64 = 1024;

/// The running timer, by its registers.
pub(crate) struct Clock(*mut u32);

impl Clock {
    pub(crate) fn start() -> Self {
        for (register, value) in [(RELOAD, u32::MAX), (VALUE, u32::MAX), (CONTROL, 1)] {
            // SAFETY: the timer's registers, which nothing else on the board uses.
            unsafe { TIMER.add(register).write_volatile(value) };
        }
        Self(TIMER)
    }

    /// Ticks since the start. Wraps around.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call would add to the measured instructions")]
    pub(crate) fn ticks(&self) -> u32 {
        // SAFETY: as in `start`; a read has no side effect.
        let value = unsafe { self.0.add(VALUE).read_volatile() };
        u32::MAX.wrapping_sub(value)
    }
}

/// Converts ticks to instructions, rounded.
pub(crate) fn instructions(ticks: u32) -> u32 {
    let nearest = (u64::from(ticks) * TICK_NS + INSTRUCTION_NS / 2) / INSTRUCTION_NS;
    u32::try_from(nearest).unwrap_or(u32::MAX)
}
