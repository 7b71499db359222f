//! Measures the stack of a call: paints the stack below the caller before it and scans it after.

use core::ptr;

use cortex_m::register::msp;

/// Painted depth, bytes.
const WINDOW: u32 = 48 * 1024;
const WORD: u32 = 4;
const PAINT: u32 = 0xA5C3_5A3C;

/// Paints the stack below the calling function. Returns the address of the lowest byte of its stack.
#[inline(always)]
#[expect(clippy::inline_always, reason = "a call would return through painted stack")]
pub(crate) fn paint() -> u32 {
    let top = msp::read();
    let mut at = top - WINDOW;
    while at < top {
        // SAFETY: RAM below the stack pointer is unused: no interrupt is enabled, nothing is called.
        unsafe { address(at).write_volatile(PAINT) };
        at += WORD;
    }
    top
}

/// Depth below `top` of the lowest byte that a call has written.
///
/// # Panics
/// If the whole window is written.
pub(crate) fn depth(top: u32) -> u32 {
    let mut at = top - WINDOW;
    // SAFETY: words of RAM, only read.
    while at < top && unsafe { address(at).read_volatile() } == PAINT {
        at += WORD;
    }
    assert!(at > top - WINDOW, "a call needs more than {WINDOW} bytes of stack");
    top - at
}

fn address(at: u32) -> *mut u32 {
    ptr::with_exposed_provenance_mut(usize::try_from(at).unwrap_or_default())
}
