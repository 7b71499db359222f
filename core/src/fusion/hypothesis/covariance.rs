//! Covariances of a hypothesis: for the comparison with a pair, for noise alone, and for the report.

use super::Hypothesis;
use crate::algebra::information::StandardDeviations;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::scalar::Scalar;
use crate::thresholds::MAX_LOCKED_SD_RAD;

impl<T: Scalar> Hypothesis<T> {
    /// Returns the covariance for the comparison with a pair, rad^2. It is widened along the drift. If the image halves
    /// disagree, it is widened in all directions, because a pair that weights the image regions differently may differ
    /// in any direction.
    #[inline(never)]
    pub(super) fn covariance(&self, context: &Context<'_, T>) -> Option<Symmetric5<T>> {
        Some(self.with_motion(
            &self.covariance_of_noise(context)?.scaled(self.halves.widening()),
            context,
        ))
    }

    /// Returns a covariance with the drift added, and with the part of the vibration that the sums do not include.
    fn with_motion(&self, covariance: &Symmetric5<T>, context: &Context<'_, T>) -> Symmetric5<T> {
        let mut covariance = *covariance;
        covariance.add_outer_out_of_line(T::ONE, &self.drift.into());
        if self.is_rigid() {
            // The pairs were weighted as for a rigid rig, so the covariance does not contain the variance of their mean
            // vibration.
            let pairs = self.pairs.clamp(1, context.config.memory_pairs.max(1));
            context.vibration.scaled(T::ONE / T::count(pairs)).add_to(&mut covariance);
        }
        covariance
    }

    /// Returns the covariance of the estimate due to noise alone, rad^2: the inverse of the information of pairs and
    /// prior.
    pub(in crate::fusion) fn covariance_of_noise(
        &self,
        context: &Context<'_, T>,
    ) -> Option<Symmetric5<T>> {
        let mut joint = self.information.0;
        joint.add_diagonal(context.prior);
        joint.inverse()
    }

    /// Returns the covariance for the report, rad^2. It includes the drift, the scatter of the pairs, and the bias that
    /// the image halves show. This bias is the same in all pairs, so their scatter does not show it.
    pub(crate) fn reported_covariance(&self, context: &Context<'_, T>) -> Option<Symmetric5<T>> {
        let noise = self.covariance_of_noise(context)?;
        let mut covariance = self.with_motion(&noise, context).scaled(self.reduced_chi_square());
        self.halves.widen(&mut covariance, context);
        Some(covariance)
    }

    /// Returns the standard deviations for the report, rad.
    pub(in crate::fusion) fn deviations(
        &self,
        context: &Context<'_, T>,
    ) -> Option<StandardDeviations<T>> {
        Some(StandardDeviations::of(&self.reported_covariance(context)?))
    }

    /// Returns whether the reported standard deviation of `R` is small enough to lock.
    pub(in crate::fusion) fn is_certain(&self, context: &Context<'_, T>) -> bool {
        let most = T::lit(MAX_LOCKED_SD_RAD);
        self.deviations(context).is_some_and(|sd| sd.rotation <= most)
    }
}
