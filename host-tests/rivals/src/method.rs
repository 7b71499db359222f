//! Input and output of a method.

use nalgebra::Vector3;
use stereo_selfcal::Extrinsics;

use super::tuning::Tuning;
use host_tests::data::Rays;

/// What a method may use beside the correspondences.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Where it starts.
    pub start: Extrinsics<f64>,
    /// Mean focal length, px: what a pixel is at unit depth.
    pub focal: f64,
    /// Expected noise of a coordinate, px.
    pub noise_px: f64,
    /// Settings that a comparison varies.
    pub tuning: Tuning,
}

impl Setting {
    /// Expected noise of a coordinate at unit depth; above 0, as scales are divided by it.
    pub(super) fn noise(&self) -> f64 {
        self.noise_px.max(MIN_NOISE_PX) / self.focal
    }
}

/// A method that estimates extrinsics from correspondences.
pub trait Method: Sync {
    /// Short, for a column of a table.
    fn name(&self) -> &'static str;

    /// Publication and equations, and departures from them.
    fn source(&self) -> &'static str;

    /// The estimate after each pair, all pairs so far together; `None` while there is none.
    ///
    /// * `pairs`: undistorted rays at unit depth, true matches and false ones.
    fn running(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Vec<Option<Extrinsics<f64>>>;

    /// The estimate from all pairs together.
    fn fused(&self, pairs: &[Vec<Rays>], setting: &Setting) -> Option<Extrinsics<f64>> {
        self.running(pairs, setting).pop().flatten()
    }
}

/// Smallest noise believed, px.
pub(super) const MIN_NOISE_PX: f64 = 0.01;

/// Largest slope of a ray that counts, unit depth: 87 degrees off the axis.
const MAX_SLOPE: f64 = 20.0;

/// The correspondences of which both rays are finite, at unit depth, and within what a lens sees.
pub(super) fn usable(rays: &[Rays]) -> Vec<Rays> {
    let usable = |ray: &Vector3<f64>| {
        (ray.z - 1.0).abs() < 1e-9 && ray.x.abs() <= MAX_SLOPE && ray.y.abs() <= MAX_SLOPE
    };
    rays.iter().filter(|pair| pair.iter().all(usable)).copied().collect()
}
