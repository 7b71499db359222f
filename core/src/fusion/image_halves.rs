//! Comparison of the estimates from image halves (`ESTIMATOR.md`, section 15). Matches with a common bias in one image
//! region move the estimate but leave only small residuals, so only this comparison shows the bias.

use nalgebra::Vector5;

use crate::algebra::disparity_noise::{BaselineNoise, BiasedEquations};
use crate::algebra::information::{Information, StandardDeviations};
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::pair::evaluate::PairMeasurement;
use crate::scalar::Scalar;
use crate::thresholds::{HEALTHY_DISAGREEMENT, MAX_MODEL_ERROR, MAX_TOLD_DISAGREEMENT};

/// Normal equations of image halves, about the pose of the hypothesis; for a vibrating rig, about the optimum of each
/// pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ImageHalves<T> {
    /// Equations of the whole image, the left half and the upper half.
    parts: [BiasedEquations<T>; 3],
    /// Number of pairs in the sums, which the fading needs.
    pairs: u32,
    /// `sqrt(chi^2 / 5)` between the estimates of two halves; the larger value of the two splits.
    disagreement: T,
}

impl<T: Scalar> ImageHalves<T> {
    pub(super) const NONE: Self =
        Self { parts: [BiasedEquations::ZERO; 3], pairs: 0, disagreement: T::ZERO };

    /// Shifts the sums to the pose after a step, and fades them. A long step drops the sums, because their equations
    /// are linearised about the pose.
    ///
    /// * `moved`: step of the pose, rad; `sd`: standard deviations of the estimate, rad.
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
        let fading = context.fading(self.pairs);
        self.parts.iter_mut().for_each(|part| *part = part.about(moved).scaled(fading));
    }

    /// Fades the sums of a vibrating rig. They need no shift, because each pair is added about its own optimum:
    /// vibration moves both halves of a pair alike.
    pub(super) fn fade(&mut self, context: &Context<'_, T>) {
        let fading = context.fading(self.pairs);
        self.parts.iter_mut().for_each(|part| *part = part.scaled(fading));
    }

    /// Adds a pair.
    ///
    /// * `to_pose`: step from the pose of the measurement to the pose that the sums are about, rad.
    pub(super) fn add(
        &mut self,
        measurement: &PairMeasurement<T>,
        to_pose: &Vector5<T>,
        context: &Context<'_, T>,
    ) {
        let [all, left, upper] = &mut self.parts;
        let whole = measurement.moments.biased_at_frame().scaled(context.share);
        all.add(&whole.about(to_pose));
        let pitch = |h: &Information<T>| h.0.diagonal()[0];
        let weight = pitch(&whole.normal.information).max(T::EPSILON);
        let halves = measurement.halves.iter().map(|half| half.scaled(context.share));
        for (sum, half) in [left, upper].into_iter().zip(halves) {
            // The noise is divided between the halves in proportion to their weights. The information on pitch measures
            // the weight.
            let share = pitch(&half.information) / weight;
            let noise = BaselineNoise(whole.noise.0.map(|n| n * share));
            sum.add(&BiasedEquations { normal: half, noise }.about(to_pose));
        }
        self.pairs = self.pairs.saturating_add(1);
        (self.disagreement, _) = self.compare(context);
    }

    /// Returns the disagreement, as the root of the chi-square per degree of freedom.
    pub(super) fn disagreement(&self) -> T {
        self.disagreement
    }

    /// Returns whether the halves disagree by no more than chance.
    pub(super) fn agree(&self) -> bool {
        self.disagreement <= T::lit(HEALTHY_DISAGREEMENT)
    }

    /// Returns the factor by which the covariance must grow to cover the disagreement in every direction, at least 1.
    pub(super) fn widening(&self) -> T {
        if self.agree() { T::ONE } else { self.disagreement * self.disagreement }
    }

    /// Widens a covariance, rad^2, if the halves disagree, but only along the shifts of the estimate that the halves
    /// cause. The other directions are as well known as before.
    pub(super) fn widen(&self, covariance: &mut Symmetric5<T>, context: &Context<'_, T>) {
        if !self.agree() {
            let (_, biases) = self.compare(context);
            for bias in biases {
                covariance.add_outer_out_of_line(T::ONE, &bias.into());
            }
        }
    }

    /// Returns the larger of two disagreements, of left and right half and of upper and lower half, and the shifts of
    /// the estimate that they cause, rad.
    ///
    /// At the joint optimum one half has the gradient `g`, the other half `-g`. If the halves differ by chance, the
    /// estimate shifts along `Q g`, where `Q` is its covariance; the shift has as many standard deviations as the
    /// distance between the halves. With an uncertain lens this shift is sufficient, because a bias that the joint
    /// estimate absorbs is a lens error, which the covariance with an uncertain lens includes. With exact lenses either
    /// half may be right, so the shifts are the distances of both halves from the estimate, each divided by `sqrt 2`:
    /// the sum of their squares is then the mean over the halves.
    fn compare(&self, context: &Context<'_, T>) -> (T, [Vector5<T>; 4]) {
        let [all, left, upper] = &self.parts;
        let (mut largest, mut biases) = (T::ZERO, [Vector5::zeros(); 4]);
        let joint = all.debiased().with_prior(context.prior);
        let Some(factor) = joint.information.0.factor(T::ZERO) else { return (largest, biases) };
        // The halves are compared about the joint optimum, where the prior does not pull them apart.
        let x = -factor.solve(&joint.gradient);
        for (biases, half) in biases.as_chunks_mut::<2>().0.iter_mut().zip([left, upper]) {
            let about =
                |half: &BiasedEquations<T>| half.debiased().about(&x).with_prior(context.prior);
            let (one, other) = (about(half), about(&all.minus(half)));
            let optima = one.optimum().zip(other.optimum());
            let Some(((of_one, cov_one), (of_other, cov_other))) = optima else { continue };
            let apart = cov_one.plus(&cov_other).inverse_form(&(of_one - of_other));
            let squared = apart.unwrap_or(T::ZERO).max(T::ZERO);
            largest = largest.max(squared);
            let moved = factor.solve(&one.gradient);
            let own = moved.dot(&one.gradient);
            *biases = if context.has_lens_prior() {
                [moved * (squared / own.max(T::EPSILON)).sqrt(), Vector5::zeros()]
            } else {
                [of_one, of_other].map(|of_half| of_half * T::HALF.sqrt())
            };
        }
        ((largest / T::lit(5.0)).sqrt().min(T::lit(MAX_TOLD_DISAGREEMENT)), biases)
    }

    /// Returns the information on the rotation of `R` about x in each sum, 1/rad^2.
    #[cfg(test)]
    pub(super) fn pitch(&self) -> [T; 3] {
        self.parts.map(|part| part.normal.information.matrix().m11)
    }
}

#[cfg(test)]
mod tests {
    use super::super::hypothesis::tests::context;
    use super::*;
    use crate::algebra::normal_equations::NormalEquations;
    use crate::algebra::symmetric5::Symmetric5;
    use crate::config::Config;
    use crate::geometry::extrinsics::Extrinsics;

    /// Returns image halves with the information of row offsets on pitch and roll; the left half has a bias of pitch,
    /// rad.
    fn biased_in_the_left_half(information: f64, bias: f64) -> ImageHalves<f64> {
        let part = |pitch_and_roll: f64, share: f64| {
            let mut h = Symmetric5::of_diagonal([1.0, 1.0, 1.0 / 3.0, 1.0, 1.0].map(|d| share * d));
            h.0[3] = pitch_and_roll;
            let information = Information(h.scaled(information));
            NormalEquations { information, gradient: Vector5::zeros() }
        };
        // The derivatives of a row offset are `-1` by pitch and `u` by roll. The left half covers `u` from -1 to 0; the
        // upper half covers -1 to 1 with half of the weight.
        let mut left = part(0.25, 0.5);
        left.gradient = -left.information.times(&(Vector5::x() * bias));
        let (mut all, mut upper) = (part(0.0, 1.0), part(0.0, 0.5));
        (all.gradient, upper.gradient) = (left.gradient, left.gradient * 0.5);
        let parts =
            [all, left, upper].map(|normal| BiasedEquations { normal, ..BiasedEquations::ZERO });
        let mut halves = ImageHalves { parts, pairs: 10, ..ImageHalves::NONE };
        (halves.disagreement, _) = halves.compare(&context());
        halves
    }

    #[test]
    fn halves_that_disagree_widen_along_the_disagreement_and_in_no_other_direction() {
        let (information, bias) = (1e12, 3e-4);
        let halves = biased_in_the_left_half(information, bias);
        assert!(!halves.agree());
        let mut covariance = Symmetric5::of_diagonal([0.0; 5]);
        halves.widen(&mut covariance, &context());
        let [pitch, rest @ ..] = covariance.diagonal().map(|d| d.sqrt() / bias);
        assert!((pitch - 0.25).abs() < 1e-3, "{pitch}");
        assert!(rest.iter().all(|d| *d < 1e-6), "{rest:?}");
        assert_eq!(halves.widening(), halves.disagreement * halves.disagreement);
        // The shift has as many standard deviations as the distance between the halves.
        let squared = (pitch * bias).powi(2) * information / 5.0;
        assert!((squared.sqrt() / halves.disagreement - 1.0).abs() < 1e-3, "{squared}");
    }

    #[test]
    fn with_exact_lenses_the_shift_is_the_mean_distance_of_the_halves_from_the_estimate() {
        const EXACT: Config = Config::robust().without_lens_prior();
        let exact = Context::new(&EXACT, &Extrinsics::SIDE_BY_SIDE, 1400.0);
        let bias = 3e-4;
        let halves = biased_in_the_left_half(1e12, bias);
        let mut covariance = Symmetric5::of_diagonal([0.0; 5]);
        halves.widen(&mut covariance, &exact);
        // The estimate has half of the bias in pitch, and 3/4 of it in roll. The left half has its bias in pitch alone;
        // the right half is unbiased.
        let [pitch, _, roll, ..] = covariance.diagonal().map(|d| d.sqrt() / bias);
        assert!((pitch - 0.5).abs() < 1e-3 && (roll - 0.75).abs() < 1e-3, "{pitch} {roll}");
    }

    #[test]
    fn halves_that_agree_widen_nothing() {
        let halves = biased_in_the_left_half(1e10, 1e-5);
        assert!(halves.agree() && halves.disagreement > 0.0, "{}", halves.disagreement);
        let mut covariance = Symmetric5::of_diagonal([1.0; 5]);
        halves.widen(&mut covariance, &context());
        assert_eq!(covariance, Symmetric5::of_diagonal([1.0; 5]));
        assert_eq!(halves.widening(), 1.0);
    }

    #[test]
    fn the_sums_restart_after_a_step_that_is_long_for_the_deviations_of_the_estimate() {
        let step = |turn: f64, shift: f64| Vector5::new(turn, 0.0, 0.0, shift, 0.0);
        let follows = |moved: Vector5<f64>| {
            let mut halves = biased_in_the_left_half(1e10, 1e-5);
            let sd = StandardDeviations { rotation: 1e-4, translation: 1e-3 };
            halves.follow(&moved, &sd, &context());
            halves != ImageHalves::NONE
        };
        // The errors of the models are products of steps. They may reach a tenth of the deviations.
        let kept = [step(3e-3, 0.0), step(0.0, 9e-3), step(1e-3, 8e-3)];
        let dropped = [step(3.3e-3, 0.0), step(0.0, 1.1e-2), step(2e-3, 8e-3)];
        assert_eq!((kept.map(follows), dropped.map(follows)), ([true; 3], [false; 3]));
    }
}
