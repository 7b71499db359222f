//! Snapshots and factory records, written and read.

use core::hint::black_box;

use stereo_selfcal::{Calibrator, FactoryCalibration};

use crate::show;

pub(crate) fn all(calibrator: &mut Calibrator<f32, 256>) {
    show(calibrator.config());
    show(calibrator.factory());
    let buffer = black_box([0; Calibrator::<f32, 256>::SNAPSHOT_BYTES]);
    let record = buffer.get(..black_box(0)).unwrap_or_default();
    show(calibrator.snapshot());
    show(calibrator.restore(record));
    if let Some(made) = calibrator.factory_calibration() {
        show(made.to_record());
        calibrator.install(&made);
    }
    show(FactoryCalibration::<f32>::from_record(record));
}
