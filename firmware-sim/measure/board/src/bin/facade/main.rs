//! Calls the whole facade, for its size. Not meant to be run.

#![no_std]
#![no_main]

mod calls;

use panic_halt as _;
use stereo_selfcal::{Calibrator, Config};

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut CALIBRATOR: Calibrator<f32, 256> = Calibrator::new(Config::robust());
    let calibrator: &mut Calibrator<f32, 256> = CALIBRATOR;
    loop {
        calls::all(calibrator);
    }
}
