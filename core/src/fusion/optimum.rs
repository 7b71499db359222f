//! Optimum of moments and prior over the extrinsics. Each step `d` solves `(H + P I) d = -(g - P u)`, where `u` is the
//! step from the pose to the factory extrinsics (`ESTIMATOR.md`, section 12).

use nalgebra::Vector5;

use crate::algebra::framed_moments::FramedMoments;
use crate::algebra::information::Information;
use crate::algebra::normal_equations::NormalEquations;
use crate::config::Context;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{LAST_STEP_SQUARED, MAX_INCONSISTENCY, MOVED_INFORMATION, OPTIMUM_STEPS};

/// The optimum, and the information of the moments at the optimum.
#[derive(Debug)]
pub(super) struct Optimum<T: Scalar> {
    pub(super) pose: RectifyingRotations<T>,
    /// Information without the prior, 1/rad^2.
    pub(super) information: Information<T>,
}

impl<T: Scalar> Optimum<T> {
    pub(super) const NONE: Self =
        Self { pose: RectifyingRotations::UNSET, information: Information::ZERO };

    /// Descends from the current pose to the optimum in at most [`OPTIMUM_STEPS`] steps.
    ///
    /// # Errors
    /// [`Rejection::NoRig`]: there is no admissible step, the steps end far from the optimum, or the optimum cannot be
    /// rectified.
    /// [`Rejection::CorrectionLimit`]: the optimum is beyond the limit.
    pub(super) fn descend(
        &mut self,
        sums: FramedMoments<'_, T>,
        context: &Context<'_, T>,
    ) -> Result<(), Rejection> {
        for _ in 0..OPTIMUM_STEPS {
            let normal = self.equations(sums, context);
            let step = self.take_step(&normal).ok_or(Rejection::NoRig)?;
            if is_last(&step, &normal) {
                return context.check(&self.pose);
            }
        }
        // The last step was not small, so the information must be computed again at the final pose.
        let normal = self.equations(sums, context);
        if are_at_optimum(&normal) { context.check(&self.pose) } else { Err(Rejection::NoRig) }
    }

    /// Takes one Gauss-Newton step, and returns it, rad. `None` if there is no admissible step.
    fn take_step(&mut self, normal: &NormalEquations<T>) -> Option<Vector5<T>> {
        let step = normal.step()?;
        self.pose = self.pose.stepped_by(&step)?;
        Some(step)
    }

    /// Returns the equations of moments and prior about the pose. Stores the information of the moments.
    #[inline(always)]
    fn equations(
        &mut self,
        sums: FramedMoments<'_, T>,
        context: &Context<'_, T>,
    ) -> NormalEquations<T> {
        let mut normal = sums.debiased_at(&self.pose);
        self.information = normal.information;
        context.add_prior(&self.pose, &mut normal);
        normal
    }
}

/// Returns whether a step is the last one: the next step would be below rounding, and the information on each direction
/// is nearly final. A step of length `d` moves about `d^2` times the information on one direction into another
/// direction.
fn is_last<T: Scalar>(step: &Vector5<T>, normal: &NormalEquations<T>) -> bool {
    let squared = step.norm_squared();
    let known = normal.information.0.diagonal();
    let [least, most] = [T::min, T::max].map(|of| known.into_iter().fold(known[0], of));
    squared <= T::lit(LAST_STEP_SQUARED) && squared * most <= T::lit(MOVED_INFORMATION) * least
}

/// Returns whether the equations have an optimum near the pose that they are about. If a direction is not observed, the
/// step to the optimum is long, or does not exist.
pub(super) fn are_at_optimum<T: Scalar>(normal: &NormalEquations<T>) -> bool {
    let squared = normal.step().map(|step| -step.dot(&normal.gradient));
    squared.is_some_and(|squared| squared <= T::lit(MAX_INCONSISTENCY))
}

#[cfg(test)]
mod tests {
    use super::super::hypothesis::tests::{context, evaluated, truth};
    use super::*;
    use crate::algebra::symmetric5::Symmetric5;

    #[test]
    fn the_information_belongs_to_the_pose_even_if_the_steps_end_early() {
        let context = context();
        let sums = evaluated::<f64>(1).measurement.moments;
        let frame = evaluated::<f64>(1).measurement.pose;
        let from = |off: f64| Optimum {
            pose: truth().stepped_by(&Vector5::repeat(off)).unwrap(),
            ..Optimum::NONE
        };
        for (off, gap) in [(1e-4, 1e-3), (0.2, 1e-12)] {
            let mut optimum = from(off);
            assert_eq!(optimum.descend(sums.in_frame_of(&frame), &context), Ok(()));
            let at_pose = sums.in_frame_of(&frame).debiased_at(&optimum.pose).information;
            for (kept, exact) in optimum.information.0.0.iter().zip(at_pose.0.0) {
                assert!(
                    (kept - exact).abs() <= gap * exact.abs().max(1e3),
                    "{off}: {kept} {exact}"
                );
            }
        }
        assert_eq!(from(0.3).descend(sums.in_frame_of(&frame), &context), Err(Rejection::NoRig));
    }

    #[test]
    fn steps_that_end_far_from_the_optimum_lead_to_no_rig() {
        let information = Information(Symmetric5::of_diagonal([1e6; 5]));
        let of = |deviations: f64| NormalEquations {
            information,
            gradient: Vector5::x() * (deviations * 1e3),
        };
        assert_eq!(
            [0.0, 95.0, 105.0, f64::NAN].map(|d| are_at_optimum(&of(d))),
            [true, true, false, false]
        );
        let free = Information(Symmetric5::of_diagonal([1e6, 1e6, 0.0, 1e6, 1e6]));
        assert!(!are_at_optimum(&NormalEquations { information: free, ..of(0.0) }));
    }

    #[test]
    fn a_step_that_moves_information_into_a_weak_direction_is_not_the_last() {
        let of = |least: f64| NormalEquations {
            information: Information(Symmetric5::of_diagonal([1e12, 1e9, 1e9, least, 1e9])),
            gradient: Vector5::zeros(),
        };
        let last = |step: f64, least: f64| is_last(&Vector5::ith(0, step), &of(least));
        // The step moves an information of 1e12 (1e-5)^2 = 100.
        assert_eq!([2e3, 5e2].map(|least| last(1e-5, least)), [true, false]);
        assert_eq!([0.9e-4, 1.1e-4].map(|step| last(step, 1e9)), [true, false]);
        assert!(!last(f64::NAN, 1e9));
    }
}
