//! The whole facade, for its size. Not meant to be run.

#![no_std]
#![no_main]

use panic_halt as _;

#[cortex_m_rt::entry]
fn main() -> ! {
    cost::run_facade(|_| ())
}
