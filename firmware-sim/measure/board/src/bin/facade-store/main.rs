//! `facade` with records and the flash store: the difference is their size. Not meant to be run.

#![no_std]
#![no_main]

#[path = "../facade/calls.rs"]
mod calls;
#[path = "../proof/store.rs"]
mod store;

use core::hint::black_box;

use panic_halt as _;
use static_cell::StaticCell;
use stereo_selfcal::{Calibrator, Config, FactoryCalibration};

#[cortex_m_rt::entry]
fn main() -> ! {
    static CALIBRATOR: StaticCell<Calibrator<f32, 256>> = StaticCell::new();
    let factory = loop {
        if let Some(cameras) = calls::cameras() {
            break FactoryCalibration::guess(cameras);
        }
    };
    let calibrator = CALIBRATOR.init_with(|| Calibrator::new(Config::robust(), &factory));
    loop {
        calls::all(calibrator);
        store::all(calibrator);
    }
}

/// Keeps a result from being optimised away.
fn show<V>(value: V) {
    black_box(value);
}
