//! `facade` without the core: the difference is the size of the core.

#![no_std]
#![no_main]

use core::hint::black_box;

use panic_halt as _;

#[cortex_m_rt::entry]
fn main() -> ! {
    loop {
        black_box(black_box(0.0_f32));
    }
}
