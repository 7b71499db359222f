//! Calls of the facade. Inputs come from `black_box`, so that the compiler cannot fold them.

use core::hint::black_box;

use stereo_selfcal::geometry::RadialTangential;
use stereo_selfcal::{Calibrator, Camera, Cameras, Correspondence, Intrinsics, Lens};

pub(crate) fn all(calibrator: &mut Calibrator<f32, 256>) {
    process_pair(calibrator);
    let _ = black_box(calibrator.apply());
    let _ = black_box(calibrator.undo());
    if black_box(false) {
        calibrator.reset();
    }
}

fn number() -> f32 {
    black_box(0.0)
}

pub(crate) fn cameras() -> Option<Cameras<f32>> {
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

fn process_pair(calibrator: &mut Calibrator<f32, 256>) {
    for _ in 0..256 {
        let _ = black_box(calibrator.push(&Correspondence {
            left: [number(), number()],
            right: [number(), number()],
            score: number(),
            grid_step: number(),
        }));
    }
    while black_box(calibrator.advance_pair()).is_none() {}
    let _ = black_box(calibrator.health());
    black_box(calibrator.state());
}
