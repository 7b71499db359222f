//! Preprocessing for all methods: RANSAC, and the scale of the noise.
//!
//! A pair in which RANSAC finds no pose is passed on whole, with the expected noise.

use super::method::{MIN_NOISE_PX, Setting, usable};
use super::pose::Pose;
use super::ransac::{inliers, sampson};
use rigs::data::Rays;
use sim::stats::median;

/// The pairs of a recording after RANSAC, and the noise of their inliers.
#[derive(Debug, Clone, PartialEq)]
pub struct Front {
    /// Inliers, pair by pair.
    pub inliers: Vec<Vec<Rays>>,
    /// Standard deviation of a coordinate, px, pair by pair, from the median of the inliers' Sampson residuals; the
    /// expected noise where RANSAC finds no pose.
    noise_px: Vec<f64>,
}

impl Front {
    /// Preprocesses pairs.
    ///
    /// * `setting`: start, focal length and expected noise. RANSAC refuses poses that are far from the start.
    #[must_use]
    pub fn new(pairs: &[Vec<Rays>], setting: &Setting) -> Self {
        let of_pair = |(rays, seed): (&Vec<Rays>, u64)| {
            let rays = usable(rays);
            let found = inliers(&rays, setting, setting.noise(), seed);
            let Some((pose, kept)) = found else { return (rays, setting.noise_px) };
            let noise_px = noise(&pose, &kept) * setting.focal;
            (kept, noise_px)
        };
        let (inliers, noise_px) = pairs.iter().zip(0..).map(of_pair).unzip();
        Self { inliers, noise_px }
    }

    /// The preprocessing of one of the pairs.
    #[must_use]
    pub fn pair(&self, k: usize) -> Self {
        let one = |rays: Option<&Vec<Rays>>| rays.into_iter().cloned().collect();
        Self {
            inliers: one(self.inliers.get(k)),
            noise_px: self.noise_px.get(k).copied().into_iter().collect(),
        }
    }

    /// Standard deviation of a coordinate, px: the median over the pairs, at least 0.01 px.
    #[must_use]
    pub fn noise_px(&self) -> f64 {
        median(self.noise_px.iter().copied()).unwrap_or_default().max(MIN_NOISE_PX)
    }
}

/// Standard deviation of a coordinate at unit depth. It equals the standard deviation of a Sampson residual, and
/// follows from the median of the residuals.
fn noise(pose: &Pose, inliers: &[Rays]) -> f64 {
    let e = pose.essential().e;
    1.4826 * median(inliers.iter().map(|rays| sampson(&e, rays).abs())).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rivals::tests::{pairs, scene, setting};

    #[test]
    fn outliers_are_removed_and_the_noise_of_the_others_is_found() {
        for noise_px in [0.15, 0.3] {
            let pairs = pairs(&scene(noise_px, 0.4), 3);
            let front = Front::new(&pairs, &setting());
            for (all, kept) in pairs.iter().zip(&front.inliers) {
                let share = kept.len() * 100 / all.len();
                assert!((50..72).contains(&share), "{share} %");
            }
            let found = front.noise_px() / noise_px;
            assert!((0.8..1.25).contains(&found), "{found}");
        }
    }
}
