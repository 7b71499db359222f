//! The calibrator of this controller: `f32`, capacity and preset.
//!
//! Concrete types: a library build for the target compiles the core's `f32` code.

use stereo_selfcal::{Calibrator, Cameras, Config, Fused, PairError, PairReport, Refusal};

/// Correspondences per pair that fit the batch.
pub const CAPACITY: usize = 512;

/// The controller's calibrator. RAM: 20 bytes per correspondence and 3.2 kB.
pub type Controller = Calibrator<f32, CAPACITY>;

/// A controller with these cameras, at the factory extrinsics `R = I`, `t = (-1, 0, 0)`.
#[must_use]
pub fn start(cameras: Cameras<f32>) -> Controller {
    start_with(Config::robust(), cameras)
}

/// As [`start`], with automatic apply while the estimate is locked.
#[must_use]
pub fn start_automatic(cameras: Cameras<f32>) -> Controller {
    start_with(Config::robust().with_automatic_apply(true), cameras)
}

fn start_with(config: Config, cameras: Cameras<f32>) -> Controller {
    let mut controller = Controller::new(config);
    controller.set_cameras(cameras);
    controller
}

/// Solves and fuses the controller's batch in one call. Returns the report and the result of the fusion.
///
/// # Errors
/// [`PairError`]. The batch is kept.
pub fn solve_and_fuse(
    controller: &mut Controller,
) -> Result<(PairReport<f32>, Result<Fused, Refusal>), PairError> {
    let report = controller.solve_pair()?;
    Ok((report, controller.fuse()))
}
