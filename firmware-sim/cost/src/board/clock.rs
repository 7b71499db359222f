//! Counts instructions with the board's timer, or cycles with QEMU's plugin `cycles`.
//!
//! With `-icount shift=10` an instruction takes 1024 ns of virtual time. A tick of the timer is 40 ns, so
//! an instruction is 25.6 ticks. The timer wraps after 168 million instructions. The plugin counts cycles in a word of
//! the flash, which is zero without it. The program prints both as instructions.

use core::ptr;

/// The first CMSDK timer of mps2-an386 and mps2-an500.
const TIMER: *mut u32 = ptr::without_provenance_mut(0x4000_0000);
const CONTROL: usize = 0;
const VALUE: usize = 1;
const RELOAD: usize = 2;

/// The word of the plugin. It counts down, as the timer does.
const CYCLES: *mut u32 = ptr::without_provenance_mut(0x003f_fffc);

const TICK_NS: u64 = 40;
const INSTRUCTION_NS: u64 = 1024;

/// The running timer or the plugin, by the value that it counts down.
pub(crate) struct Clock(*mut u32);

impl Clock {
    pub(crate) fn start() -> Self {
        // SAFETY: a word of the flash, which the linker leaves unused.
        if unsafe { CYCLES.read_volatile() } != 0 {
            return Self(CYCLES);
        }
        for (register, value) in [(RELOAD, u32::MAX), (VALUE, u32::MAX), (CONTROL, 1)] {
            // SAFETY: the timer's registers, which nothing else on the board uses.
            unsafe { TIMER.add(register).write_volatile(value) };
        }
        Self(TIMER.wrapping_add(VALUE))
    }

    /// Ticks since the start. Wraps around.
    #[inline(always)]
    #[expect(clippy::inline_always, reason = "a call would add to the measured instructions")]
    pub(crate) fn ticks(&self) -> u32 {
        // SAFETY: as in `start`; a read has no side effect.
        let value = unsafe { self.0.read_volatile() };
        u32::MAX.wrapping_sub(value)
    }

    /// Converts ticks to instructions, rounded. A tick of the plugin is a cycle.
    pub(crate) fn instructions(&self, ticks: u32) -> u32 {
        if self.0 == CYCLES {
            return ticks;
        }
        let nearest = (u64::from(ticks) * TICK_NS + INSTRUCTION_NS / 2) / INSTRUCTION_NS;
        u32::try_from(nearest).unwrap_or(u32::MAX)
    }
}
