//! Must not link: one panic is reachable. It shows that `proof` detects a panic.

#![no_std]
#![no_main]

#[path = "proof/detector.rs"]
mod detector;

use core::hint::black_box;

#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        black_box(black_box([0_u8; 4]).as_slice()[black_box(5)]);
    }
}
