//! All that a firmware calls of the facade, for the size of it: nothing here is meant to be run.
//!
//! Inputs come out of `black_box`, so that nothing is folded away.

#![no_std]
#![no_main]

use core::hint::black_box;

use panic_halt as _;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Correspondence, Intrinsics, Lens, RadialTangential,
};

#[cortex_m_rt::entry]
fn main() -> ! {
    static mut CALIBRATOR: Calibrator<f32, 256> = Calibrator::new(Config::robust());
    let calibrator: &mut Calibrator<f32, 256> = CALIBRATOR;
    loop {
        if let Some(cameras) = cameras() {
            calibrator.set_cameras(cameras);
        }
        take_a_pair(calibrator);
        let _ = black_box(calibrator.apply());
        let _ = black_box(calibrator.undo());
        if black_box(false) {
            calibrator.reset();
        }
    }
}

fn number() -> f32 {
    black_box(0.0)
}

fn cameras() -> Option<Cameras<f32>> {
    let intrinsics = Intrinsics {
        focal: black_box([0.0; 2]),
        principal: black_box([0.0; 2]),
        size: black_box([0; 2]),
    };
    let distorted = RadialTangential::try_new(black_box([0.0; 5])).map(Lens::RadialTangential);
    let lens = if black_box(false) { distorted.ok()? } else { Lens::Pinhole };
    let camera = Camera::try_new(intrinsics, lens).ok()?;
    Some(Cameras { left: camera, right: camera })
}

fn take_a_pair(calibrator: &mut Calibrator<f32, 256>) {
    for _ in 0..256 {
        let _ = black_box(calibrator.push(&Correspondence {
            left: [number(), number()],
            right: [number(), number()],
            score: number(),
            grid_step: number(),
        }));
    }
    let mut begun = calibrator.begin_pair().is_ok();
    while begun {
        match calibrator.advance_pair() {
            Ok(None) => (),
            Ok(Some(report)) => {
                let _ = black_box(calibrator.fuse());
                begun = false;
            }
            Err(_) => begun = false,
        }
    }
    black_box(calibrator.health());
    black_box(calibrator.state());
    calibrator.clear_pair();
}
