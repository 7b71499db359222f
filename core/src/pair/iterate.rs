//! Linearisation point of a pass, and the noise scale of its residuals (`ESTIMATOR.md`, section 7).

use super::constraint::PoseTerms;
use super::leverage::Leverage;
use super::weighting::{Loss, Weighting};
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::MAX_NOISE_PX;

/// A pose, with settings and the noise scale of its residuals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Iterate<T: Scalar> {
    /// Mean focal length of the cameras, px.
    pub(super) focal: T,
    /// Smallest noise of a coordinate, px.
    pub(super) noise_floor: T,
    /// Number of correspondences that a solution needs.
    pub(super) needed: u16,
    /// Start of the search or track.
    pub(super) start: RectifyingRotations<T>,
    /// Pose reached so far.
    pub(super) pose: RectifyingRotations<T>,
    /// Noise of a coordinate, px.
    pub(super) noise: T,
    /// Limit of Tukey's loss, in units of the loss.
    pub(super) tukey: T,
    /// Limit on the leverage of a correspondence; `None` while no limit is known.
    pub(super) leverage: Option<Leverage<T>>,
    /// Effective number of unknowns that are determined by the correspondences and not by the prior, 0 to 5.
    pub(super) fitted: T,
    /// Smallest disparity of a weighted correspondence, unit depth; below zero. An annealing ignores it.
    pub(super) min_disparity: T,
}

impl<T: Scalar> Iterate<T> {
    /// Returns the weighting at the pose with a given loss.
    pub(super) fn weighting(&self, loss: Loss<T>) -> Weighting<T> {
        let Self { focal, noise, tukey, .. } = *self;
        Weighting {
            pose: PoseTerms::at(&self.pose),
            loss,
            leverage: self.leverage,
            focal_squared: focal * focal,
            unit_squared: T::ONE / (focal * focal),
            noise_squared: noise * noise,
            tukey_squared: tukey * tukey,
            min_disparity: self.min_disparity,
        }
    }

    /// Checks the number of usable correspondences.
    ///
    /// # Errors
    /// [`Rejection::TooFew`] below [`Iterate::needed`].
    pub(super) fn check(&self, usable: T) -> Result<(), Rejection> {
        let (usable, needed) = (usable.to_u16().into(), self.needed.into());
        if usable < needed { Err(Rejection::TooFew { usable, needed }) } else { Ok(()) }
    }

    /// Returns the noise of a coordinate, px, between the floor and [`MAX_NOISE_PX`].
    ///
    /// * `near_squares`: sum of the variance estimates from the near residuals, px^2; `near`: number of residuals
    ///   within 2 units of the loss.
    pub(super) fn noise_of(&self, near_squares: T, near: T) -> T {
        // The fit absorbs one degree of freedom for each unknown that it determines.
        let free = (near - self.fitted).max(T::ONE);
        let floor = self.noise_floor * self.noise_floor;
        let noise = (near_squares / free).max(floor).sqrt();
        noise.min(T::lit(MAX_NOISE_PX)).max(self.noise_floor)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rectification::tests::pose;

    #[test]
    fn noise_is_over_the_degrees_of_freedom_and_within_its_bounds() {
        let pose = pose([0.0; 3], [0.0; 2]);
        let iterate = Iterate {
            focal: 500.0,
            noise_floor: 0.15,
            needed: 12,
            start: pose,
            pose,
            noise: 1.5,
            tukey: 4.685,
            leverage: None,
            fitted: 4.0,
            min_disparity: 0.0,
        };
        assert!((iterate.noise_of(24.0, 28.0) - 1.0).abs() < 1e-12);
        // At least one degree of freedom is assumed, even for few residuals.
        assert!((iterate.noise_of(1.0, 4.0) - 1.0).abs() < 1e-12);
        assert_eq!(iterate.noise_of(0.0, 28.0), 0.15);
        assert_eq!(iterate.noise_of(-1.0, 28.0), 0.15);
        assert_eq!(iterate.noise_of(1e6, 28.0), MAX_NOISE_PX);
    }
}
