//! Witnesses of the mount yaw.

use core::hint::black_box;

use stereo_selfcal::Calibrator;
use stereo_selfcal::batch::RayPair;
use stereo_selfcal::depth::{Range, RangeReading};

use crate::{number, numbers, show};

pub(crate) fn all(calibrator: &mut Calibrator<f32, 256>) {
    show(calibrator.push_range(&reading()).map_err(|error| error.code()));
    motion(calibrator);
}

fn reading() -> RangeReading<f32> {
    let range = if black_box(false) { Range::AlongAxis } else { Range::AlongRay };
    RangeReading {
        pixel: numbers(),
        right: black_box(false).then(numbers),
        range: range(number()),
        sd_m: number(),
    }
}

/// Pushes tracked matches, whose number is unknown to the compiler.
fn motion(calibrator: &mut Calibrator<f32, 256>) {
    if let Some(pair) = RayPair::try_new(numbers(), numbers()) {
        let tracked = black_box([[pair; 2]; 16]);
        let length = black_box(0);
        let tracked = black_box(tracked.get(..length).unwrap_or_default());
        show(calibrator.push_motion(tracked).map_err(|error| error.code()));
    }
}
