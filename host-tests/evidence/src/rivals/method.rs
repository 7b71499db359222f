//! Input and output of a method.

use nalgebra::Vector3;
use stereo_selfcal::Extrinsics;

use super::tuning::Tuning;
use rigs::data::Rays;

/// Input of a method in addition to the correspondences.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Extrinsics that the method starts from.
    pub start: Extrinsics<f64>,
    /// Mean focal length, px.
    pub focal: f64,
    /// Expected standard deviation of a coordinate, px.
    pub noise_px: f64,
    /// Settings that a comparison varies.
    pub tuning: Tuning,
}

impl Setting {
    /// Expected standard deviation of a coordinate at unit depth. The px value is at least [`MIN_NOISE_PX`], because
    /// methods divide by it.
    pub(super) fn noise(&self) -> f64 {
        self.noise_px.max(MIN_NOISE_PX) / self.focal
    }
}

/// A method that estimates extrinsics from correspondences.
pub trait Method: Sync {
    /// Short name for a column of a table.
    fn name(&self) -> &'static str;

    /// Publication and equations, and departures from them.
    fn source(&self) -> &'static str;

    /// The estimate from all pairs up to each pair; `None` before the first estimate.
    ///
    /// * `pairs`: undistorted rays at unit depth, inliers and outliers.
    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>>;

    /// The estimate from all pairs together; `None` without an estimate.
    fn fused(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Option<Extrinsics<f64>> {
        self.running(pairs, setting).pop().flatten()
    }
}

/// Smallest accepted noise, px.
pub(super) const MIN_NOISE_PX: f64 = 0.01;

/// Largest `|x|` or `|y|` of an accepted ray at unit depth: 87 degrees off the axis.
const MAX_SLOPE: f64 = 20.0;

/// The correspondences whose rays are both finite, at unit depth, and within the view of a lens.
pub(super) fn usable(rays: &[Rays]) -> Vec<Rays> {
    let usable = |ray: &Vector3<f64>| {
        (ray.z - 1.0).abs() < 1e-9 && ray.x.abs() <= MAX_SLOPE && ray.y.abs() <= MAX_SLOPE
    };
    rays.iter().filter(|pair| pair.iter().all(usable)).copied().collect()
}
