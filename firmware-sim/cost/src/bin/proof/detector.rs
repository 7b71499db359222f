//! A panic handler that does not link if a panic is reachable: it calls a symbol that does not exist.

use core::panic::PanicInfo;

unsafe extern "C" {
    fn a_panic_is_reachable() -> !;
}

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    // SAFETY: never runs: the symbol does not exist, so a caller does not link.
    unsafe { a_panic_is_reachable() }
}
