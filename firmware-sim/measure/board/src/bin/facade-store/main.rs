//! `facade` with records and the flash store: the difference is their size. Not meant to be run.

#![no_std]
#![no_main]

#[path = "../facade/calls.rs"]
mod calls;
#[path = "../proof/store.rs"]
mod store;

use core::hint::black_box;

use panic_halt as _;
use stereo_selfcal::{Calibrator, Config};

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut CALIBRATOR: Calibrator<f32, 256> = Calibrator::new(Config::robust());
    let calibrator: &mut Calibrator<f32, 256> = CALIBRATOR;
    loop {
        calls::all(calibrator);
        store::all(calibrator);
    }
}

/// Keeps a result from being optimised away.
fn show<V>(value: V) {
    black_box(value);
}
