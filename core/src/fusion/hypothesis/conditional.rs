//! What a hypothesis says with something else given: of `R` with a baseline, of the lens.

use nalgebra::Vector5;

use super::Hypothesis;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::lens_terms::LensTerms;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::OPTIMUM_STEPS;

impl<T: Scalar> Hypothesis<T> {
    /// Fills the normal equations of the lens at the pose, and returns those of the extrinsics.
    #[inline(never)]
    pub(in crate::fusion) fn fill_lens(&self, mut terms: LensTerms<'_, T>) -> BiasedEquations<T> {
        let sums = self.sums();
        sums.fill_lens(&self.frame, &self.pose, terms.reborrow());
        let mut biased = sums.biased_at_pose(&self.frame, &self.pose);
        if !self.is_rigid() {
            let mean = self.marginal.variances.scaled(T::ONE / T::count(self.pairs.max(1)));
            terms.marginalise(&mean, &mut biased);
        }
        biased
    }

    /// Optimum of `R` for a given baseline, where the estimated baseline is doubtful.
    #[inline(never)]
    pub(crate) fn with_baseline_of(&self, given: &Extrinsics<T>) -> Option<Extrinsics<T>> {
        let target = RectifyingRotations::from(given);
        let mut pose = self.pose;
        if self.marginal.is_used() {
            let to_target = pose.unknowns_to(&target);
            let across = Vector5::new(T::ZERO, T::ZERO, T::ZERO, to_target.w, to_target.a);
            let d = self.marginal.total().about(&across).rotation_only().step()? + across;
            let held = pose.stepped_by(&d)?.extrinsics().ok()?;
            return Extrinsics::try_new(held.rotation().matrix(), given.translation()).ok();
        }
        let sums = self.sums();
        for _ in 0..OPTIMUM_STEPS {
            let to_target = pose.unknowns_to(&target);
            let across = Vector5::new(T::ZERO, T::ZERO, T::ZERO, to_target.w, to_target.a);
            let normal = sums.at_pose(&self.frame, &pose).about(&across);
            let d = normal.rotation_only().step()? + across;
            pose = pose.stepped_by(&d)?;
        }
        Extrinsics::try_new(pose.extrinsics().ok()?.rotation().matrix(), given.translation()).ok()
    }
}
