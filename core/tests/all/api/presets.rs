//! Calibrators with the cameras of [`super::scene`].

use stereo_selfcal::{Calibrator, Config, Extrinsics, FactoryCalibration, Scalar};

use crate::api::scene::cameras;

/// Calibrator of a configuration, with a guess of the extrinsics.
pub(crate) fn with<T: Scalar, const N: usize>(config: Config) -> Calibrator<T, N> {
    Calibrator::new(config, &FactoryCalibration::guess(cameras()))
}

/// Calibrator with factory extrinsics that a calibration has measured.
pub(crate) fn calibrated(extrinsics: Extrinsics<f32>) -> Calibrator<f32, 256> {
    Calibrator::new(Config::robust(), &FactoryCalibration::new(cameras(), extrinsics))
}

/// Calibrator with a guess of the extrinsics. It may arm by its rows alone, because a guess does not
/// confirm the yaw.
pub(crate) fn robust<T: Scalar>() -> Calibrator<T, 256> {
    with(ROWS_ALONE)
}

/// Parameters of a rig that uses no metric depth.
pub(crate) const ROWS_ALONE: Config = match Config::robust().with_depth_limit_px(f32::INFINITY) {
    Ok(config) => config,
    Err(_) => panic!("the limit is valid"),
};
