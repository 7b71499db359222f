//! How deep a call goes: the stack below the caller is painted before and searched after it.

use core::ptr;

use cortex_m::register::msp;

/// Depth that is painted, bytes.
const WINDOW: u32 = 48 * 1024;
const WORD: u32 = 4;
const PAINT: u32 = 0xA5C3_5A3C;

/// Paints what lies below the stack of the function that this is inlined into; the address of its
/// lowest byte.
#[inline(always)]
#[expect(clippy::inline_always, reason = "a frame of its own would be painted over")]
pub(crate) fn paint() -> u32 {
    let top = msp::read();
    let mut at = top - WINDOW;
    while at < top {
        // SAFETY: RAM below the stack pointer, which nothing owns: no interrupt is on, nothing is called.
        unsafe { address(at).write_volatile(PAINT) };
        at += WORD;
    }
    top
}

/// Bytes below `top` that are not painted any more.
///
/// # Panics
/// If the paint is gone to its end: the window is too small.
pub(crate) fn depth(top: u32) -> u32 {
    let mut at = top - WINDOW;
    // SAFETY: RAM, read as words; what lies below the stack pointer is only read.
    while at < top && unsafe { address(at).read_volatile() } == PAINT {
        at += WORD;
    }
    assert!(at > top - WINDOW, "a call needs more than {WINDOW} bytes of stack");
    top - at
}

fn address(at: u32) -> *mut u32 {
    ptr::with_exposed_provenance_mut(usize::try_from(at).unwrap_or_default())
}
