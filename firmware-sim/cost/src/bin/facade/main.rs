//! The facade of the estimator, for its size. Not meant to be run.

#![no_std]
#![no_main]

mod calls;

use panic_halt as _;

#[cortex_m_rt::entry]
fn main() -> ! {
    calls::run(|_| ())
}
