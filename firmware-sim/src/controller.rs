//! The calibrator of this controller: `f32`, capacity and preset.
//!
//! The types are concrete, so that a library build for the target compiles the core's `f32` code.

use stereo_selfcal::{
    Calibrator, Cameras, Config, FactoryCalibration, Fused, Outcome, PairReport, Rejection,
};

/// Correspondences per pair that fit the batch.
pub const CAPACITY: usize = 512;

/// The controller's calibrator. RAM: 23 bytes per correspondence, and 5.2 kB.
pub type Controller = Calibrator<f32, CAPACITY>;

/// A controller with these cameras, at the factory extrinsics `R = I`, `t = (-1, 0, 0)`.
#[must_use]
pub fn start(cameras: Cameras<f32>) -> Controller {
    Controller::new(Config::robust(), &FactoryCalibration::guess(cameras))
}

/// Solves and fuses the controller's batch in one call. Returns the report and the result of the fusion.
///
/// # Errors
/// [`Rejection`] if the pair cannot be solved.
pub fn solve_and_fuse(
    controller: &mut Controller,
) -> Result<(PairReport<f32>, Result<Fused, Rejection>), Rejection> {
    let Outcome { pair, fused } = controller.solve_pair();
    pair.map(|report| (report, fused)).ok_or(fused.err().unwrap_or(Rejection::NotBegun))
}
