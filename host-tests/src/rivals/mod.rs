//! The methods that ours are compared with, each written from its publication alone, in `f64`.

use stereo_selfcal::Extrinsics;

use crate::oracle::Rays;

/// What a method may know beside the correspondences.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// Where it starts.
    pub start: Extrinsics<f64>,
    /// Mean focal length, px: what a pixel is at unit depth.
    pub focal: f64,
    /// Expected noise of a coordinate, px.
    pub noise_px: f64,
}

/// A way from correspondences to extrinsics.
pub trait Method: Sync {
    /// Short, for a column of a table.
    fn name(&self) -> &'static str;

    /// What it is after: publication, equations, and where it departs from them.
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
