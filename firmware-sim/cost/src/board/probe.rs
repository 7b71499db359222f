//! Measures one call.

use core::sync::atomic::{Ordering, compiler_fence};

use crate::clock::Clock;
use crate::stack;

/// Cost of a call.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Sample {
    pub(crate) instructions: u32,
    /// Stack below the caller's stack, bytes.
    pub(crate) stack: u32,
}

impl Sample {
    /// The larger value of each.
    pub(crate) fn max(self, other: Self) -> Self {
        Self {
            instructions: self.instructions.max(other.instructions),
            stack: self.stack.max(other.stack),
        }
    }
}

pub(crate) struct Probe {
    clock: Clock,
    /// Ticks of reading the clock.
    overhead: u32,
}

impl Probe {
    pub(crate) fn new() -> Self {
        let mut probe = Self { clock: Clock::start(), overhead: 0 };
        probe.overhead = (0..8).map(|_| probe.ticks(|| ()).1).min().unwrap_or(0);
        probe
    }

    /// Measures `call`: one call of a function that is not inlined.
    #[inline(never)]
    pub(crate) fn run<R>(&self, call: impl FnOnce() -> R) -> (R, Sample) {
        let top = stack::paint();
        let (result, ticks) = self.ticks(call);
        let stack = stack::depth(top);
        (result, Sample { instructions: self.clock.instructions(ticks), stack })
    }

    #[inline(always)]
    #[expect(clippy::inline_always, reason = "its stack frame would count as that of the call")]
    fn ticks<R>(&self, call: impl FnOnce() -> R) -> (R, u32) {
        let start = self.clock.ticks();
        compiler_fence(Ordering::SeqCst);
        let result = call();
        compiler_fence(Ordering::SeqCst);
        let ticks = self.clock.ticks().wrapping_sub(start);
        (result, ticks.saturating_sub(self.overhead))
    }
}
