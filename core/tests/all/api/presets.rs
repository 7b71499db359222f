//! Calibrators with the cameras of [`super::scene`].

use stereo_selfcal::{Calibrator, Config, Extrinsics, FactoryCalibration, Scalar};

use crate::api::scene::cameras;

/// Calibrator of a configuration, with a guess of the extrinsics.
pub(crate) fn with<T: Scalar, const N: usize>(config: Config) -> Calibrator<T, N> {
    Calibrator::new(config, &FactoryCalibration::guess(cameras()))
}

/// Calibrator of the robust preset, with factory extrinsics that a calibration has measured.
pub(crate) fn calibrated(extrinsics: Extrinsics<f32>) -> Calibrator<f32, 256> {
    Calibrator::new(Config::robust(), &FactoryCalibration::new(cameras(), extrinsics))
}

/// Calibrator of the paper preset, with a guess of the extrinsics.
pub(crate) fn calibrator<T: Scalar>() -> Calibrator<T, 256> {
    with(Config::paper())
}

/// Calibrator of the robust preset, with a guess of the extrinsics.
pub(crate) fn robust<T: Scalar>() -> Calibrator<T, 256> {
    with(Config::robust())
}
