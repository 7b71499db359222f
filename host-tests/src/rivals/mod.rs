//! The methods that ours are compared with, in `f64`: those of the literature and common practice.
//!
//! Each is written independently of the core, from what is known of its publication; what had to be
//! filled in or was left out stands in its file, and in [`Method::source`].

mod bundle;
mod cauchy;
mod dang;
mod epipolar;
mod filter;
mod five_point;
mod fusion;
mod hansen;
mod ling_shen;
mod minimise;
mod mueller_block;
mod mueller_ukf;
mod ours;
mod pose;
mod ransac;
#[cfg(test)]
mod tests;

use anyhow::{Context, Result};
use nalgebra::Vector3;
use stereo_selfcal::Extrinsics;

use crate::oracle::Rays;

pub use bundle::Bundle;
pub use cauchy::Cauchy;
pub use dang::Dang;
pub use hansen::Hansen;
pub use ling_shen::LingShen;
pub use mueller_block::MuellerBlock;
pub use mueller_ukf::MuellerUkf;
pub use ours::{Paper, Robust};
pub use ransac::Ransac;

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

impl Setting {
    /// Expected noise of a coordinate at unit depth; above 0, as scales are divided by it.
    fn noise(&self) -> f64 {
        self.noise_px.max(MIN_NOISE_PX) / self.focal
    }
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

/// All of them, in the order of a table's columns: ours, then by the year of publication, then what
/// is common practice.
#[must_use]
pub fn all() -> Vec<Box<dyn Method>> {
    vec![
        Box::new(Robust),
        Box::new(Paper),
        Box::new(Dang),
        Box::new(Hansen),
        Box::new(LingShen),
        Box::new(MuellerUkf),
        Box::new(MuellerBlock),
        Box::new(Cauchy),
        Box::new(Ransac),
        Box::new(Bundle),
    ]
}

/// The method of that name.
///
/// # Errors
/// Lists the names there are.
pub fn by_name(name: &str) -> Result<Box<dyn Method>> {
    let all = all();
    let names: Vec<&str> = all.iter().map(|method| method.name()).collect();
    let names = names.join(", ");
    let found = all.into_iter().find(|method| method.name() == name);
    found.with_context(|| format!("no method is called {name}; there are: {names}"))
}

/// Smallest noise believed, px.
const MIN_NOISE_PX: f64 = 0.01;

/// Largest slope of a ray that counts, unit depth: 87 degrees off the axis.
const MAX_SLOPE: f64 = 20.0;

/// The correspondences of which both rays are finite, at unit depth, and within what a lens sees.
fn usable(rays: &[Rays]) -> Vec<Rays> {
    let usable = |ray: &Vector3<f64>| {
        (ray.z - 1.0).abs() < 1e-9 && ray.x.abs() <= MAX_SLOPE && ray.y.abs() <= MAX_SLOPE
    };
    rays.iter().filter(|pair| pair.iter().all(usable)).copied().collect()
}
