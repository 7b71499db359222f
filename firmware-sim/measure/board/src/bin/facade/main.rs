//! Calls the whole facade, for its size. Not meant to be run.

#![no_std]
#![no_main]

mod calls;

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
    }
}
