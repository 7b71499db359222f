//! Calibrators that know the cameras of the scene.

use stereo_selfcal::{Calibrator, Config, Scalar};

use crate::api::scene::cameras;

pub(crate) fn with<T: Scalar>(config: Config) -> Calibrator<T, 256> {
    let mut calibrator = Calibrator::new(config);
    calibrator.set_cameras(cameras());
    calibrator
}

/// Of the paper preset.
pub(crate) fn calibrator<T: Scalar>() -> Calibrator<T, 256> {
    with(Config::paper())
}

/// Of the robust preset.
pub(crate) fn robust<T: Scalar>() -> Calibrator<T, 256> {
    with(Config::robust())
}
