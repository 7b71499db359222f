//! Depths of the points of a scene.

use anyhow::{Result, ensure};
use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

/// Depth of the points along the left optical axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected [nearest, farthest], {near, share, far} or {on_axis, slope}"
)]
pub enum Depth {
    /// Log-uniform from the nearest to the farthest, in baselines.
    LogUniform([f64; 2]),
    /// A share of the points is near, the others are far; both parts are log-uniform.
    Mixture {
        /// Nearest and farthest of the near points, in baselines.
        near: [f64; 2],
        /// Share of near points, 0 to 1.
        share: f64,
        /// Nearest and farthest of the other points, in baselines.
        far: [f64; 2],
    },
    /// All points on one plane, with normal `(slope, 1)` in the left camera frame.
    Plane {
        /// Depth at which the left optical axis meets the plane, in baselines.
        on_axis: f64,
        /// Tangents of the slant of the plane in x and y; 0 is fronto-parallel.
        slope: [f64; 2],
    },
}

impl Depth {
    /// Checks the parameters.
    ///
    /// # Errors
    /// Names the parameter that is out of range.
    pub(crate) fn check(self) -> Result<()> {
        let check = |[near, far]: [f64; 2]| {
            ensure!(near > 0.0 && far >= near && far.is_finite(), "depth must be 0 < near <= far");
            Ok(())
        };
        match self {
            Self::LogUniform(range) => check(range)?,
            Self::Mixture { near, share, far } => {
                check(near)?;
                check(far)?;
                ensure!((0.0..=1.0).contains(&share), "share of near points must be from 0 to 1");
            }
            Self::Plane { on_axis, slope: [x, y] } => {
                ensure!(on_axis > 0.0 && on_axis.is_finite(), "depth must be above 0");
                ensure!(x.is_finite() && y.is_finite(), "slope must be finite");
            }
        }
        Ok(())
    }

    /// The near and the far part of a mixture, or the depth itself.
    pub(crate) fn parts(self) -> Vec<Self> {
        match self {
            Self::Mixture { near, far, .. } => vec![Self::LogUniform(near), Self::LogUniform(far)],
            Self::LogUniform(_) | Self::Plane { .. } => vec![self],
        }
    }

    /// The part that the next point belongs to. It is drawn before the test whether both cameras see the point, so the
    /// share of near points holds for visible points.
    pub(crate) fn part(self, rng: &mut ChaCha8Rng) -> Self {
        match self {
            Self::Mixture { near, share, far } => {
                Self::LogUniform(if rng.random::<f64>() < share { near } else { far })
            }
            Self::LogUniform(_) | Self::Plane { .. } => self,
        }
    }

    /// The depths multiplied by a factor.
    pub(crate) fn times(self, factor: f64) -> Self {
        match self {
            Self::LogUniform(range) => Self::LogUniform(range.map(|z| z * factor)),
            Self::Mixture { near, share, far } => {
                let [near, far] = [near, far].map(|range| range.map(|z| z * factor));
                Self::Mixture { near, share, far }
            }
            Self::Plane { on_axis, slope } => Self::Plane { on_axis: on_axis * factor, slope },
        }
    }

    /// Depth, in baselines, of a random point on a left ray; `None` if the ray misses the plane.
    ///
    /// * `ray`: at unit depth.
    pub(crate) fn along(self, ray: &Vector3<f64>, rng: &mut ChaCha8Rng) -> Option<f64> {
        match self {
            Self::Mixture { .. } => self.part(rng).along(ray, rng),
            Self::LogUniform(range) => {
                let [near, far] = range.map(libm::log);
                Some(libm::exp(near + (far - near) * rng.random::<f64>()))
            }
            Self::Plane { on_axis, slope: [x, y] } => {
                let inverse = (1.0 + x * ray.x + y * ray.y) / on_axis;
                (inverse > 0.0).then(|| inverse.recip())
            }
        }
    }
}
