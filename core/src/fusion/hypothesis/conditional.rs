//! Conditional estimates from a hypothesis: `R` for a given baseline, and the lens.

use nalgebra::{Vector3, Vector5};

use super::Hypothesis;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::lens_terms::LensEquations;
use crate::config::Context;
use crate::depth::pose::RowsPose;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::OPTIMUM_STEPS;

impl<T: Scalar> Hypothesis<T> {
    /// Fills the normal equations of the lens at the pose, without the vibration of single pairs. Returns the equations
    /// of the extrinsics.
    #[inline(never)]
    pub(in crate::fusion) fn fill_lens(
        &self,
        mut equations: LensEquations<'_, T>,
    ) -> BiasedEquations<T> {
        let pose = &self.pose_at_rest(&self.pose).unwrap_or(self.pose);
        self.framed_sums().fill_lens(pose, equations.reborrow());
        let mut biased = self.framed_sums().biased_at(pose);
        if let Some(marginal) = self.mode.marginal() {
            let mean = marginal.variances.scaled(T::ONE / T::count(self.pairs.max(1)));
            equations.marginalise(&mean, &mut biased);
        }
        biased
    }

    /// Returns the extrinsics with the baseline in use and the optimal `R` for it. They are applied while the estimate
    /// of the baseline is doubtful. If the right camera has turned, the baseline has turned with it, so it is held in
    /// the left camera if that fits clearly better than in the right one. `None` if there is no valid optimum, if the
    /// optimum fits clearly worse than the extrinsics in use, or if it is beyond the limit for extrinsics in use. The
    /// last two happen if the descent leaves the range of its linearisation.
    ///
    /// * `in_use`: the pose in use as rows show it; `t`: its unit baseline, which the result has up to rounding unless
    ///   the right camera has turned.
    #[inline(never)]
    pub(crate) fn with_baseline_of(
        &self,
        in_use: &RowsPose<T>,
        t: &Vector3<T>,
        context: &Context<'_, T>,
    ) -> Option<Extrinsics<T>> {
        let used = in_use.rotations();
        let mut held = self.with_baseline(used, t, context)?;
        let t = held.rotation() * used.extrinsics().ok()?.rotation().inverse_transform_vector(t);
        if let Some(turned) = self.with_baseline_turned(&held, &t, context)
            && self.fits_clearly_better_at(&(&turned).into(), &(&held).into())
        {
            held = turned;
        }
        let is_worse = self.fits_clearly_better_at(used, &(&held).into());
        (!is_worse && context.allows_in_use(&held)).then_some(held)
    }

    /// Returns the extrinsics with another baseline and the optimal `R` for it.
    #[inline(never)]
    fn with_baseline_turned(
        &self,
        held: &Extrinsics<T>,
        t: &Vector3<T>,
        context: &Context<'_, T>,
    ) -> Option<Extrinsics<T>> {
        let target = Extrinsics::try_new(held.rotation().matrix(), t).ok()?;
        self.with_baseline(&(&target).into(), t, context)
    }

    /// Returns the extrinsics with the baseline `t` of `target` and the optimal `R` for it.
    #[inline(never)]
    fn with_baseline(
        &self,
        target: &RectifyingRotations<T>,
        t: &Vector3<T>,
        context: &Context<'_, T>,
    ) -> Option<Extrinsics<T>> {
        let found = self.descend_with_baseline_of(target, context)?;
        Extrinsics::try_new(found.rotation().matrix(), t).ok()
    }

    /// Returns the optimum of `R` for the baseline of `target`. Out of line, so that its sums leave the stack before
    /// those of the comparison need it.
    #[inline(never)]
    fn descend_with_baseline_of(
        &self,
        target: &RectifyingRotations<T>,
        context: &Context<'_, T>,
    ) -> Option<Extrinsics<T>> {
        let mut pose = self.pose;
        let steps = if self.is_rigid() { OPTIMUM_STEPS } else { 1 };
        for _ in 0..steps {
            pose = pose.stepped_by(&self.step_with_baseline_of(target, &pose, context)?)?;
        }
        pose.extrinsics().ok()
    }

    /// Returns the step from a pose to the optimum of `R` for the baseline of `target`, rad.
    #[inline(never)]
    fn step_with_baseline_of(
        &self,
        target: &RectifyingRotations<T>,
        pose: &RectifyingRotations<T>,
        context: &Context<'_, T>,
    ) -> Option<Vector5<T>> {
        let to_target = pose.unknowns_to(target);
        let across = Vector5::new(T::ZERO, T::ZERO, T::ZERO, to_target.w, to_target.a);
        let mut normal = match self.mode.marginal() {
            Some(marginal) => marginal.sum,
            None => self.framed_sums().at(pose),
        };
        context.add_prior(pose, &mut normal);
        Some(normal.about(&across).rotation_only().step()? + across)
    }
}
