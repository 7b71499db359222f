//! Moments with the frame that they belong to, at any pose.

use super::disparity_noise::{BaselineNoise, BiasedEquations};
use super::moments::{Coefficients, Moments, dot};
use super::normal_equations::NormalEquations;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Moments, and the pose whose rectified frame is their frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FramedMoments<'a, T: Scalar> {
    pub(super) moments: &'a Moments<T>,
    pub(super) frame: &'a RectifyingRotations<T>,
}

impl<T: Scalar> Moments<T> {
    /// Returns the moments with their frame.
    ///
    /// * `frame`: pose whose rectified frame is the frame of the sums.
    pub(crate) fn in_frame_of<'a>(
        &'a self,
        frame: &'a RectifyingRotations<T>,
    ) -> FramedMoments<'a, T> {
        FramedMoments { moments: self, frame }
    }
}

impl<T: Scalar> FramedMoments<'_, T> {
    /// Returns the normal equations of the cost at a pose, noise of disparities included.
    ///
    /// * `pose`: any pose. The part from `M` is exact for frozen weights; the offset of the gradient is exact to first
    ///   order.
    pub(crate) fn at(self, pose: &RectifyingRotations<T>) -> NormalEquations<T> {
        self.biased_at(pose).normal
    }

    /// Returns the equations of [`Self::at`] with the noise that they include.
    #[inline(never)]
    pub(crate) fn biased_at(self, pose: &RectifyingRotations<T>) -> BiasedEquations<T> {
        let mut normal = self.plain_at(pose);
        let n = self.moments.noise_tensor_at(self.frame, pose);
        let [.., by_forward, by_down] = &mut normal.gradient.data.0[0];
        *by_forward -= n.m31;
        *by_down += n.m21;
        BiasedEquations { normal, noise: BaselineNoise([n.m33, -n.m32, n.m22]) }
    }

    /// Returns the equations of [`Self::at`] without the noise of disparities.
    pub(crate) fn debiased_at(self, pose: &RectifyingRotations<T>) -> NormalEquations<T> {
        self.biased_at(pose).debiased()
    }

    /// Returns the equations of [`Self::at`] without the offset of the gradient with respect to the baseline.
    fn plain_at(self, pose: &RectifyingRotations<T>) -> NormalEquations<T> {
        let (mut coefficients, mut normal) = (Coefficients::NONE, NormalEquations::ZERO);
        coefficients.add(self.frame, pose);
        self.moments.fill(&coefficients, &mut normal);
        normal
    }

    /// Returns the weighted sum of squared constraints at a pose, `e^T M e`.
    #[inline(never)]
    pub(crate) fn cost_at(self, pose: &RectifyingRotations<T>) -> T {
        let mut coefficients = Coefficients::NONE;
        coefficients.add(self.frame, pose);
        dot(&coefficients.of_offset, &self.moments.times_without_lens(&coefficients.of_offset))
    }
}
