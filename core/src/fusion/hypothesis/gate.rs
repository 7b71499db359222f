//! Mahalanobis distance of a pair or of another hypothesis from this hypothesis (`ESTIMATOR.md`, section 12).

use super::Hypothesis;
use crate::config::Context;
use crate::pair::evaluate::{EvaluatedPose, PairMeasurement};
use crate::scalar::Scalar;
use crate::thresholds::{MAX_NIS, VIBRATION_RAD};

impl<T: Scalar> Hypothesis<T> {
    /// Returns the NIS of a pair: the squared Mahalanobis distance of its optimum from the estimate, with the sum of
    /// both covariances and the vibration. For a rigid rig, the NIS without the allowance [`VIBRATION_RAD`] is
    /// chi-square distributed with 5 degrees of freedom; the allowance lowers it.
    pub(in crate::fusion) fn innovation(
        &self,
        measurement: &PairMeasurement<T>,
        context: &Context<'_, T>,
    ) -> Option<T> {
        let pair = measurement.debiased_at(&self.pose, context.share).with_prior(context.prior);
        let (step, covariance) = pair.optimum()?;
        let mut both = covariance.plus(&self.covariance(context)?);
        both.add_diagonal(T::lit(VIBRATION_RAD * VIBRATION_RAD));
        context.vibration.add_to(&mut both);
        both.inverse_form(&step)
    }

    /// Returns whether a pair that was tracked from this hypothesis passes the gate: its residuals have a peak, and its
    /// NIS is below [`MAX_NIS`] times the reduced chi-square.
    ///
    /// * `slack`: further factor of this limit.
    pub(in crate::fusion) fn gate(
        &self,
        evaluated: &EvaluatedPose<T>,
        slack: T,
        context: &Context<'_, T>,
    ) -> bool {
        let limit = T::lit(MAX_NIS) * slack * self.reduced_chi_square();
        evaluated.has_peak()
            && self.innovation(&evaluated.measurement, context).is_some_and(|nis| nis < limit)
    }

    /// Returns whether this hypothesis differs from another one by more than chance: the squared Mahalanobis distance,
    /// with the sum of both covariances, exceeds [`MAX_NIS`] times the reduced chi-square of the other one.
    pub(in crate::fusion) fn departs_from(&self, other: &Self, context: &Context<'_, T>) -> bool {
        let covariances = self.covariance(context).zip(other.covariance(context));
        let apart = self.pose.unknowns_to(&other.pose);
        covariances
            .and_then(|(a, b)| a.plus(&b).inverse_form(&apart))
            .is_some_and(|distance| distance > T::lit(MAX_NIS) * other.reduced_chi_square())
    }
}
