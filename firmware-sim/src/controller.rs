//! The calibrator as this controller has it: `f32`, its capacity, its preset.
//!
//! Concrete on purpose: a library build for the target compiles the core's `f32` code with it.

use stereo_selfcal::{Calibrator, Cameras, Config, Fused, PairError, PairReport, Refusal};

/// Correspondences a pair that the controller has room for.
pub const CAPACITY: usize = 512;

/// The controller's calibrator. RAM: 20 bytes a correspondence and 3.2 kB.
pub type Controller = Calibrator<f32, CAPACITY>;

/// A controller for these cameras, at the factory extrinsics `R = I`, `t = (-1, 0, 0)`.
#[must_use]
pub fn start(cameras: Cameras<f32>) -> Controller {
    start_with(Config::robust(), cameras)
}

/// The same, which puts its estimate into use by itself while that is locked.
#[must_use]
pub fn start_automatic(cameras: Cameras<f32>) -> Controller {
    start_with(Config::robust().with_automatic_apply(true), cameras)
}

fn start_with(config: Config, cameras: Cameras<f32>) -> Controller {
    let mut controller = Controller::new(config);
    controller.set_cameras(cameras);
    controller
}

/// Solves and fuses the controller's batch in one call, for loops that can afford it: the report, and
/// whether it was fused.
///
/// # Errors
/// [`PairError`]; the batch is kept.
pub fn solve_and_fuse(
    controller: &mut Controller,
) -> Result<(PairReport<f32>, Result<Fused, Refusal>), PairError> {
    let report = controller.solve_pair()?;
    Ok((report, controller.fuse()))
}
