//! Calls of the facade, for its size. Inputs come from `black_box`, so that the compiler cannot fold them.

use core::hint::black_box;

use static_cell::StaticCell;
use stereo_selfcal::geometry::RadialTangential;
use stereo_selfcal::{
    Calibrator, Camera, Cameras, Config, Correspondence, FactoryCalibration, Intrinsics, Lens,
};

type Rig = Calibrator<f32, 256>;

/// Calls the facade of a static calibrator, and `also`, without an end.
pub(crate) fn run(also: impl Fn(&mut Rig)) -> ! {
    static CALIBRATOR: StaticCell<Rig> = StaticCell::new();
    let factory = loop {
        if let Some(cameras) = cameras() {
            break FactoryCalibration::guess(cameras);
        }
    };
    let calibrator = CALIBRATOR.init_with(|| Calibrator::new(Config::robust(), &factory));
    loop {
        process_pair(calibrator);
        let _ = black_box(calibrator.apply());
        let _ = black_box(calibrator.undo());
        if black_box(false) {
            calibrator.reset();
        }
        also(calibrator);
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

fn process_pair(calibrator: &mut Rig) {
    for _ in 0..256 {
        let _ = black_box(calibrator.push(&Correspondence {
            left: [number(), number()],
            right: [number(), number()],
            score: number(),
            grid_step: number(),
        }));
    }
    while black_box(calibrator.advance_pair()).is_none() {}
    let _ = black_box((calibrator.details(), calibrator.verdict()));
    black_box(calibrator.state());
}
