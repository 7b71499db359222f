//! `facade` with records and the flash store: the difference is their size. Not meant to be run.

#![no_std]
#![no_main]

#[path = "facade/calls.rs"]
mod calls;
#[path = "proof/store.rs"]
mod store;

use core::hint::black_box;

use panic_halt as _;

#[cortex_m_rt::entry]
fn main() -> ! {
    calls::run(store::all)
}

/// Keeps a result from being optimised away.
fn show<V>(value: V) {
    black_box(value);
}
