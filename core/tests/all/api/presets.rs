//! Calibrators with the cameras of the scene.

use stereo_selfcal::{Calibrator, Config, Extrinsics, FactoryCalibration, Scalar};

use crate::api::scene::cameras;

pub(crate) fn with<T: Scalar, const N: usize>(config: Config) -> Calibrator<T, N> {
    Calibrator::new(config, &FactoryCalibration::guess(cameras()))
}

/// Calibrator of the robust preset, with extrinsics of a calibration.
pub(crate) fn calibrated(extrinsics: Extrinsics<f32>) -> Calibrator<f32, 256> {
    Calibrator::new(Config::robust(), &FactoryCalibration::new(cameras(), extrinsics))
}

/// Calibrator of the paper preset.
pub(crate) fn calibrator<T: Scalar>() -> Calibrator<T, 256> {
    with(Config::paper())
}

/// Calibrator of the robust preset.
pub(crate) fn robust<T: Scalar>() -> Calibrator<T, 256> {
    with(Config::robust())
}
