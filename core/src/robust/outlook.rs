//! A pose, and what correspondences are weighed by there.

use super::NOISE_PX;
use super::constraint::Frame;
use super::leverage::Leverage;
use super::weighing::{Loss, Weighing};
use crate::error::PairError;
use crate::lanes::Lanes;
use crate::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// A pose that correspondences are weighed at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Outlook<T: Scalar> {
    pub(super) focal: T,
    pub(super) noise_floor: T,
    pub(super) needed: u32,
    pub(super) start: RectifyingRotations<T>,
    pub(super) pose: RectifyingRotations<T>,
    pub(super) noise: T,
    pub(super) leverage: Option<Leverage<T>>,
    /// Unknowns that the correspondences determine rather than the prior, 0 to 5.
    pub(super) fitted: T,
    /// Unit depth.
    pub(super) min_disparity: T,
}

impl<T: Scalar> Outlook<T> {
    /// What correspondences at the pose are weighed with.
    #[inline(always)]
    pub(super) fn weighing<L: Lanes<T>>(
        &self,
        lanes: L,
        loss: Loss<L::Value>,
    ) -> Weighing<L::Value> {
        let Self { focal, noise, .. } = *self;
        Weighing {
            frame: Frame::at(lanes, &self.pose),
            loss,
            leverage: self.leverage.as_ref().map(|leverage| leverage.beside(lanes)),
            focal_squared: lanes.all(focal * focal),
            unit_squared: lanes.all(T::ONE / (focal * focal)),
            noise_squared: lanes.all(noise * noise),
            min_disparity: lanes.all(self.min_disparity),
        }
    }

    /// # Errors
    /// [`PairError::TooFew`].
    pub(super) fn check(&self, usable: u32) -> Result<(), PairError> {
        if usable < self.needed {
            Err(PairError::TooFew { usable, needed: self.needed })
        } else {
            Ok(())
        }
    }

    /// Noise of a coordinate, px, by the squares of so many residuals within 2 standard deviations.
    pub(super) fn noise_of(&self, near_squares: T, near: u32) -> T {
        let count = T::count(near.max(1));
        // The fit has taken up as much of them as it has freedom.
        let free = (count - self.fitted).max(count * T::HALF);
        let floor = self.noise_floor * self.noise_floor;
        let noise = (near_squares / free).max(floor).sqrt();
        noise.min(T::lit(NOISE_PX[1])).max(self.noise_floor)
    }
}
