//! Snapshots and factory records, written and read.

use core::hint::black_box;

use stereo_selfcal::{Calibrator, Cameras, FactoryCalibration};

use crate::{geometry, show};

const ROOM: usize = Calibrator::<f32, 256>::SNAPSHOT_BYTES;

pub(crate) fn all(calibrator: &mut Calibrator<f32, 256>) {
    show(calibrator.config());
    show(calibrator.factory());
    let mut buffer = black_box([0; ROOM]);
    let length = black_box(0);
    show(calibrator.snapshot(buffer.get_mut(..length).unwrap_or_default()));
    show(calibrator.restore(buffer.get(..length).unwrap_or_default()));
    if let Some((cameras, extrinsics)) = calibrator.cameras().copied().zip(geometry::extrinsics()) {
        factory(cameras, extrinsics);
    }
}

fn factory(cameras: Cameras<f32>, extrinsics: stereo_selfcal::Extrinsics<f32>) {
    let mut buffer = black_box([0; FactoryCalibration::<f32>::MAX_BYTES]);
    let length = black_box(0);
    let made = FactoryCalibration { cameras, extrinsics };
    show(made.to_record(buffer.get_mut(..length).unwrap_or_default()));
    let record = buffer.get(..length).unwrap_or_default();
    show(FactoryCalibration::<f32>::from_record(record));
}
