//! How far the points of a scene are.

use anyhow::{Result, ensure};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;

/// Depth of the points along the left optical axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Depth {
    /// Log-uniform from the nearest to the farthest, in baselines.
    LogUniform([f64; 2]),
    /// All on one plane, of normal `(slope, 1)` in the left camera frame.
    Plane {
        /// Depth where the left optical axis meets it, in baselines.
        on_axis: f64,
        /// Tangents of its slant in x and y; 0 is fronto-parallel.
        slope: [f64; 2],
    },
}

impl Depth {
    /// # Errors
    /// If a depth is out of range.
    pub(crate) fn check(self) -> Result<()> {
        match self {
            Self::LogUniform([near, far]) => {
                ensure!(
                    near > 0.0 && far >= near && far.is_finite(),
                    "depth must be 0 < near <= far"
                );
            }
            Self::Plane { on_axis, slope: [x, y] } => {
                ensure!(on_axis > 0.0 && on_axis.is_finite(), "depth must be above 0");
                ensure!(x.is_finite() && y.is_finite(), "slope must be finite");
            }
        }
        Ok(())
    }

    /// All of it so many times as far.
    pub(crate) fn times(self, factor: f64) -> Self {
        match self {
            Self::LogUniform(range) => Self::LogUniform(range.map(|z| z * factor)),
            Self::Plane { on_axis, slope } => Self::Plane { on_axis: on_axis * factor, slope },
        }
    }

    /// Depth of a point on a ray of unit depth; `None` where the ray misses the plane.
    pub(crate) fn along(self, ray: &Vector3<f64>, rng: &mut ChaCha8Rng) -> Option<f64> {
        match self {
            Self::LogUniform(range) => {
                let [near, far] = range.map(f64::ln);
                Some((near + (far - near) * rng.random::<f64>()).exp())
            }
            Self::Plane { on_axis, slope: [x, y] } => {
                let inverse = (1.0 + x * ray.x + y * ray.y) / on_axis;
                (inverse > 0.0).then(|| inverse.recip())
            }
        }
    }
}
