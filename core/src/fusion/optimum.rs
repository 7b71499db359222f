//! Optimum of moments and prior on the manifold of extrinsics: `(H + P I) d = -(g - P u)` (`ESTIMATOR.md`, section 12).

use nalgebra::Vector5;

use crate::algebra::information::Information;
use crate::algebra::moments::Moments;
use crate::config::Context;
use crate::error::Refusal;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{LAST_STEP_SQUARED, OPTIMUM_STEPS};

/// The optimum, and the information of the moments there.
#[derive(Debug)]
pub(super) struct Optimum<T: Scalar> {
    pub(super) pose: RectifyingRotations<T>,
    /// Without the prior, 1/rad^2.
    pub(super) information: Information<T>,
}

impl<T: Scalar> Optimum<T> {
    pub(super) const NONE: Self =
        Self { pose: RectifyingRotations::UNSET, information: Information::ZERO };

    /// Descends from the current pose to the optimum, in at most [`OPTIMUM_STEPS`] steps.
    ///
    /// * `frame`: of the moments.
    ///
    /// # Errors
    /// [`Refusal::NoRig`], [`Refusal::CorrectionLimit`].
    #[inline(never)]
    pub(super) fn descend(
        &mut self,
        sums: &Moments<T>,
        frame: &RectifyingRotations<T>,
        context: &Context<'_, T>,
    ) -> Result<(), Refusal> {
        for _ in 0..OPTIMUM_STEPS {
            let step = self.step(sums, frame, context).ok_or(Refusal::NoRig)?;
            if step.norm_squared() <= T::lit(LAST_STEP_SQUARED) {
                break;
            }
        }
        context.check(&self.pose)
    }

    /// Takes one Gauss-Newton step, rad; the information is that before the step. `None` without an admissible step.
    #[inline(never)]
    fn step(
        &mut self,
        sums: &Moments<T>,
        frame: &RectifyingRotations<T>,
        context: &Context<'_, T>,
    ) -> Option<Vector5<T>> {
        let mut normal = sums.debiased_at_pose(frame, &self.pose);
        self.information = normal.information;
        context.add_prior(&self.pose, &mut normal);
        let step = normal.step()?;
        self.pose = self.pose.stepped_by(&step)?;
        Some(step)
    }
}
