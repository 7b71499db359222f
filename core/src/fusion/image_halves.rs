//! Estimates of the image halves, compared (`ESTIMATOR.md`, section 15): matches with a common bias in one region move
//! the estimate and leave small residuals.

use nalgebra::Vector5;

use crate::algebra::disparity_noise::{BaselineNoise, BiasedEquations};
use crate::algebra::information::{Information, StandardDeviations};
use crate::config::{Context, LensPrior};
use crate::pair::evaluate::PairMeasurement;
use crate::scalar::Scalar;
use crate::thresholds::{HEALTHY_DISAGREEMENT, MAX_MODEL_ERROR, MAX_TOLD_DISAGREEMENT};

/// Normal equations of image halves, about the pose of the hypothesis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImageHalves<T> {
    /// Whole image, left half, upper half.
    parts: [BiasedEquations<T>; 3],
    /// Pairs in the sums, and those of distinct scenes: repetition shows a bias, and cannot average it out.
    pairs: [u32; 2],
    /// `sqrt(chi^2 / 5)` between the estimates of two halves, the larger of both splits.
    disagreement: T,
}

impl<T: Scalar> ImageHalves<T> {
    pub(super) const NONE: Self =
        Self { parts: [BiasedEquations::ZERO; 3], pairs: [0; 2], disagreement: T::ZERO };

    /// Shifts the sums after a step of the pose. A long step drops them: they are models of first order.
    ///
    /// * `moved`: the step, rad; `sd`: of the estimate.
    pub(super) fn follow(
        &mut self,
        moved: &Vector5<T>,
        sd: &StandardDeviations<T>,
        context: &Context<'_, T>,
    ) {
        let turn = moved.fixed_rows::<3>(0).norm();
        let shift = moved.fixed_rows::<2>(3).norm();
        let most = T::lit(MAX_MODEL_ERROR);
        if turn * (turn + shift) > most * sd.rotation || shift * shift > most * sd.translation {
            *self = Self::NONE;
            return;
        }
        let [pairs, _] = self.pairs;
        let fading = context.fading(pairs);
        self.parts.iter_mut().for_each(|part| *part = part.about(moved).scaled(fading));
    }

    /// Fades where each pair is about its own optimum: the halves of a pair are shaken alike.
    pub(super) fn fade(&mut self, context: &Context<'_, T>) {
        let [pairs, _] = self.pairs;
        let fading = context.fading(pairs);
        self.parts.iter_mut().for_each(|part| *part = part.scaled(fading));
    }

    /// Adds a pair.
    ///
    /// * `to_pose`: step from the pose of the measurement to that of the hypothesis, rad.
    pub(super) fn add(
        &mut self,
        measurement: &PairMeasurement<T>,
        to_pose: &Vector5<T>,
        repeated: bool,
        context: &Context<'_, T>,
    ) {
        if repeated && context.config.lens_prior != LensPrior::NONE {
            return;
        }
        let [all, left, upper] = &mut self.parts;
        let whole = measurement.moments.biased_at_frame();
        all.add(&whole.about(to_pose));
        let pitch = |h: &Information<T>| h.0.diagonal()[0];
        let weight = pitch(&whole.normal.information).max(T::EPSILON);
        for (sum, half) in [left, upper].into_iter().zip(&measurement.halves) {
            // Noise is shared by weight, which information about pitch measures.
            let share = pitch(&half.information) / weight;
            let noise = BaselineNoise(whole.noise.0.map(|n| n * share));
            sum.add(&BiasedEquations { normal: *half, noise }.about(to_pose));
        }
        let [pairs, distinct] = self.pairs;
        self.pairs = [pairs.saturating_add(1), distinct.saturating_add(u32::from(!repeated))];
        self.disagreement = self.compare(context);
    }

    /// Disagreement, in standard deviations per degree of freedom.
    pub(super) fn disagreement(&self) -> T {
        self.disagreement
    }

    /// Factor of the covariance, at least 1. The disagreement is of all pairs, the covariance of distinct ones.
    pub(super) fn widening(&self) -> T {
        let [pairs, distinct] = self.pairs.map(|n| T::count(n.max(1)));
        if self.disagreement > T::lit(HEALTHY_DISAGREEMENT) {
            (self.disagreement * self.disagreement * (distinct / pairs)).max(T::ONE)
        } else {
            T::ONE
        }
    }

    /// Larger disagreement of left and right half, and of upper and lower half.
    #[inline(never)]
    fn compare(&self, context: &Context<'_, T>) -> T {
        let [all, left, upper] = &self.parts;
        let Some(x) = all.debiased().with_prior(context.prior).step() else {
            return T::ZERO;
        };
        // About the joint optimum: the prior pulls neither half away from the other.
        let distance = |half: &BiasedEquations<T>| {
            let one = half.debiased().about(&x).with_prior(context.prior);
            let other = all.minus(half).debiased().about(&x).with_prior(context.prior);
            one.distance(&other).unwrap_or(T::ZERO)
        };
        let larger = (distance(left).max(distance(upper)).max(T::ZERO) / T::lit(5.0)).sqrt();
        larger.min(T::lit(MAX_TOLD_DISAGREEMENT))
    }

    /// Information about the turn of `R` about x in each sum.
    #[cfg(test)]
    pub(super) fn pitch(&self) -> [T; 3] {
        self.parts.map(|part| part.normal.information.matrix().m11)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disagreement_widens_by_its_square_and_the_share_of_distinct_scenes() {
        let widening = |disagreement, pairs| {
            ImageHalves { pairs, disagreement, ..ImageHalves::<f64>::NONE }.widening()
        };
        assert_eq!(widening(3.0, [10, 10]), 9.0);
        assert_eq!(widening(3.0, [10, 5]), 4.5);
        assert_eq!(widening(3.0, [100, 1]), 1.0);
        assert_eq!(widening(HEALTHY_DISAGREEMENT, [10, 10]), 1.0);
    }
}
