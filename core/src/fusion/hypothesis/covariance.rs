//! Covariances of a hypothesis: for the comparison with a pair, by noise alone, and as reported.

use super::Hypothesis;
use crate::algebra::information::StandardDeviations;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::scalar::Scalar;
use crate::thresholds::MAX_LOCKED_SD_RAD;

impl<T: Scalar> Hypothesis<T> {
    /// Covariance for the comparison with a pair, rad^2, widened along the drift. If the image halves disagree, it is
    /// widened in all directions, because a pair with other weights of the regions may differ in any direction.
    #[inline(never)]
    pub(super) fn covariance(&self, context: &Context<'_, T>) -> Option<Symmetric5<T>> {
        Some(self.with_motion(
            &self.covariance_of_noise(context)?.scaled(self.halves.widening()),
            context,
        ))
    }

    /// A covariance with the drift added, and with the vibration that the sums do not include.
    fn with_motion(&self, covariance: &Symmetric5<T>, context: &Context<'_, T>) -> Symmetric5<T> {
        let mut covariance = *covariance;
        covariance.add_outer_out_of_line(T::ONE, &self.drift.into());
        if self.is_rigid() {
            // The pairs were weighed without the vibration, so their mean is off by its remainder.
            let pairs = self.pairs.clamp(1, context.config.memory_pairs.max(1));
            context.vibration.scaled(T::ONE / T::count(pairs)).add_to(&mut covariance);
        }
        covariance
    }

    /// Covariance of the estimate by noise alone, rad^2: without biases, for instance of a lens.
    pub(in crate::fusion) fn covariance_of_noise(
        &self,
        context: &Context<'_, T>,
    ) -> Option<Symmetric5<T>> {
        let mut joint = self.information.0;
        joint.add_diagonal(context.prior);
        joint.inverse()
    }

    /// Reported covariance, rad^2: with the scatter of the pairs, and with the bias that the image halves show, which
    /// does not scatter.
    #[inline(never)]
    pub(crate) fn reported_covariance(&self, context: &Context<'_, T>) -> Option<Symmetric5<T>> {
        let noise = self.covariance_of_noise(context)?;
        let mut covariance = self.with_motion(&noise, context).scaled(self.reduced_chi_square());
        self.halves.widen(&mut covariance, context);
        Some(covariance)
    }

    /// Reported standard deviations, rad.
    pub(in crate::fusion) fn deviations(
        &self,
        context: &Context<'_, T>,
    ) -> Option<StandardDeviations<T>> {
        Some(StandardDeviations::of(&self.reported_covariance(context)?))
    }

    /// Whether the reported deviation of `R` is small enough to lock.
    pub(in crate::fusion) fn is_certain(&self, context: &Context<'_, T>) -> bool {
        let most = T::lit(MAX_LOCKED_SD_RAD);
        self.deviations(context).is_some_and(|sd| sd.rotation <= most)
    }
}
