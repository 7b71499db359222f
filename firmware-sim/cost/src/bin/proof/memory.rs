//! Snapshots and factory records, written and read.

use core::hint::black_box;

use stereo_selfcal::{Calibrator, Cameras, FactoryCalibration};

use crate::{geometry, number, show};

pub(crate) fn all(calibrator: &mut Calibrator<f32, 256>) {
    let buffer = black_box([0; Calibrator::<f32, 256>::SNAPSHOT_BYTES]);
    let record = buffer.get(..black_box(0)).unwrap_or_default();
    show(calibrator.snapshot());
    show(calibrator.restore(record));
    show(FactoryCalibration::<f32>::from_record(record));
}

pub(crate) fn made(cameras: Cameras<f32>) -> FactoryCalibration<f32> {
    let guess = FactoryCalibration::guess(cameras);
    let made = geometry::extrinsics().map(|found| FactoryCalibration::new(cameras, found));
    let made = made.unwrap_or(guess);
    let made = if black_box(false) { made.without_yaw() } else { made };
    let made = made.with_yaw_sd_rad(number()).unwrap_or(made);
    let made = made.with_baseline_m(number()).unwrap_or(made);
    show((made.yaw_sd_rad(), made.baseline_m(), made.to_record()));
    made
}
