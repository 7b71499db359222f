//! Conversion of a hypothesis to a prior, and start of a hypothesis from a prior.

use nalgebra::Vector5;

use super::Hypothesis;
use super::mode::Mode;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::normal_equations::NormalEquations;
use crate::config::Context;
use crate::fusion::marginal_sums::MarginalSums;
use crate::fusion::optimum::are_at_optimum;
use crate::fusion::prior::Prior;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::MAX_NOISE_PX;

impl<T: Scalar> Hypothesis<T> {
    /// Fills a prior with the estimate. `None` if the sums have no solution; the prior is then unspecified.
    pub(in crate::fusion) fn fill_prior(
        &self,
        prior: &mut Prior<T>,
        context: &Context<'_, T>,
    ) -> Option<()> {
        // Each step is out of line, to free its stack for the next step.
        let at_rest = self.pose_at_rest(&self.pose)?;
        self.fill_equations(prior, &at_rest, context)?;
        if !self.vibration(context).is_zero() || !prior.is_consistent(T::ONE) {
            self.set_mean(&mut prior.equations, context)?;
        }
        if !prior.is_consistent(T::ONE) {
            prior.response.weaken(&mut prior.equations.normal.information);
        }
        prior.limit();
        (prior.pose, prior.chi_square) = (self.pose, self.reduced_chi_square);
        (prior.noise, prior.high_leverage) = (self.noise, self.high_leverage);
        (prior.shares, prior.pairs) = ([self.inlier_share, self.crowd], self.pairs);
        Some(())
    }

    /// Fills the equations, and the response to the lens, from the sums as for a rigid rig.
    #[inline(never)]
    fn fill_equations(
        &self,
        prior: &mut Prior<T>,
        at_rest: &RectifyingRotations<T>,
        context: &Context<'_, T>,
    ) -> Option<()> {
        let mut sums = self.sums;
        sums.change_frame(&self.frame, at_rest);
        prior.equations = sums.biased_at_frame();
        prior.response.set(&sums, &prior.equations.normal.information, context.prior)
    }

    /// Replaces the equations by equations of the estimate itself, without the noise of disparities. The equations of
    /// the sums do not apply to the mean of a vibrating rig, because the sums weight the pairs as for a rigid rig. They
    /// do not apply either if their noise is not plausible: in a far scene whose matches are better than the noise
    /// floor, the noise exceeds all information on the baseline, and where the noise is negligible, its estimate may be
    /// negative.
    #[inline(never)]
    fn set_mean(&self, equations: &mut BiasedEquations<T>, context: &Context<'_, T>) -> Option<()> {
        let mut normal =
            NormalEquations { information: self.information, gradient: self.balance(context) };
        if self.is_rigid() && !self.vibration(context).is_zero() {
            // No pair was added since the vibration was detected, or since a change of the rig replaced the sums.
            let pairs = T::count(self.pairs.max(1));
            let of_mean = self.vibration(context).scaled(T::ONE / pairs);
            normal.information = of_mean.marginal(&normal)?.information;
        }
        *equations = BiasedEquations { normal, ..BiasedEquations::ZERO };
        Some(())
    }

    /// Returns the gradient of the pairs that balances the prior about the factory extrinsics, 1/rad.
    fn balance(&self, context: &Context<'_, T>) -> Vector5<T> {
        self.pose.unknowns_to(&context.factory_pose) * context.prior
    }

    /// Starts an empty hypothesis from a prior. Returns whether the optimum of the equations is near the pose.
    pub(in crate::fusion) fn resume(&mut self, prior: &Prior<T>, context: &Context<'_, T>) -> bool {
        (self.pose, self.frame) = (prior.pose, prior.pose);
        let mut equations = prior.equations;
        // `R` is observed, so its gradient balances the prior about the factory extrinsics.
        let balance = self.balance(context);
        let gradient = &mut equations.normal.gradient;
        (gradient.x, gradient.y, gradient.z) = (balance.x, balance.y, balance.z);
        let mut normal = equations.debiased();
        self.information = normal.information;
        // The variance of row offsets is twice the noise variance, because both views have noise. The pitch element of
        // `H` is nearly the sum of the weights. The noise floor may have changed with a firmware update.
        let floor = T::single(context.config.noise_floor_px);
        self.noise = prior.noise.max(floor).min(floor.max(T::lit(MAX_NOISE_PX)));
        let deviation = self.noise / context.focal;
        let [weights, ..] = equations.normal.information.0.diagonal();
        let squares = weights * deviation * deviation * T::lit(2.0);
        self.sums.set_prior(&equations, &prior.response, squares);
        if !context.vibration.is_zero() {
            let variances = context.vibration.at_least_rigid();
            self.mode = Mode::of(MarginalSums { sum: normal, variances });
        }
        [self.inlier_share, self.crowd] = prior.shares;
        self.high_leverage = prior.high_leverage;
        self.reduced_chi_square = prior.chi_square;
        (self.pairs, self.scenes) = (prior.pairs, T::ONE);
        context.add_prior(&self.pose, &mut normal);
        are_at_optimum(&normal)
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::super::tests::{context, evaluated, fused};
    use super::*;
    use crate::algebra::block_variances::BlockVariances;
    use crate::algebra::lens_terms::{LENS_PARAMETERS, LensEquations};
    use nalgebra::Vector5;

    fn resumed(from: &Hypothesis<f64>, context: &Context<'_, f64>) -> Hypothesis<f64> {
        let (mut prior, mut resumed) = (Prior::NONE, Hypothesis::EMPTY);
        from.fill_prior(&mut prior, context).unwrap();
        resumed.resume(&prior, context);
        resumed
    }

    /// Returns the effects of the lens parameters on the estimate, rad per unit of the parameter.
    fn effects(
        of: &Hypothesis<f64>,
        context: &Context<'_, f64>,
    ) -> [Vector5<f64>; LENS_PARAMETERS] {
        let mut mixed = [[0.0; 5]; LENS_PARAMETERS];
        let mut information = [[0.0; LENS_PARAMETERS]; LENS_PARAMETERS];
        let mut gradient = [0.0; LENS_PARAMETERS];
        let biased = of.fill_lens(LensEquations {
            mixed: &mut mixed,
            information: &mut information,
            gradient: &mut gradient,
        });
        let joint = biased.debiased().with_prior(context.prior).information.0;
        let factor = joint.factor(0.0).unwrap();
        mixed.map(|row| {
            let mut moved = biased;
            moved.normal.gradient = row.into();
            factor.solve(&moved.debiased().gradient)
        })
    }

    #[test]
    fn a_prior_has_the_pose_the_covariance_and_the_response_to_the_lens_of_its_pairs() {
        let rigid = context::<f64>();
        let turns = BlockVariances { rotation: 4e-6, baseline: 4e-6 };
        // For a vibrating rig, the record keeps the equations without the noise of disparities, but the response
        // includes this noise.
        for (context, most) in [(rigid, 1e-3), (rigid.vibrating(turns), 0.15)] {
            let pairs: std::vec::Vec<_> = (0..12).map(evaluated).collect();
            let before = fused(&pairs, 2, &context);
            let after = resumed(&before, &context);
            assert_eq!(after.pose, before.pose);
            let covariances = [&before, &after].map(|h| h.reported_covariance(&context).unwrap());
            let [old, new] = covariances.map(|covariance| covariance.diagonal());
            for (old, new) in old.into_iter().zip(new) {
                // The information of the estimate belongs to the pose before the last step.
                assert!((new / old - 1.0).abs() < 1e-3, "{old} {new}");
            }
            let [old, new] = [&before, &after].map(|h| effects(h, &context));
            for (parameter, (old, new)) in old.into_iter().zip(new).enumerate() {
                let gap = (old - new).norm();
                assert!(gap < most * old.norm() + 1e-3, "{parameter}: {old} {new}");
            }
        }
    }

    #[test]
    fn a_vibration_detected_after_the_last_pair_is_in_the_covariance_of_the_prior() {
        let turns = BlockVariances { rotation: 4e-6, baseline: 4e-6 };
        let shaken = context().vibrating(turns);
        let pairs: std::vec::Vec<_> = (0..12).map(evaluated).collect();
        let before = fused(&pairs, 2, &context());
        let after = resumed(&before, &shaken);
        let [old, new] = [&before, &after].map(|h| h.covariance(&shaken).unwrap().diagonal());
        for (old, new) in old.into_iter().zip(new) {
            assert!((new / old - 1.0).abs() < 1e-3, "{old} {new}");
        }
    }

    #[test]
    fn a_drift_does_not_change_the_information_of_the_prior() {
        let pairs: std::vec::Vec<_> = (0..12).map(evaluated).collect();
        let steady = fused(&pairs, 2, &context());
        let drifting = steady.drifting(Vector5::repeat(1e-2));
        let [one, other] =
            [steady, drifting].map(|h| resumed(&h, &context()).covariance(&context()).unwrap());
        assert_eq!(one, other);
    }

    #[test]
    fn a_pair_moves_a_prior_as_it_moves_the_sums() {
        let context = context::<f64>();
        let pairs: std::vec::Vec<_> = (0..12).map(evaluated).collect();
        let mut hypotheses = [fused(&pairs, 1, &context); 2];
        hypotheses[1] = resumed(&hypotheses[0], &context);
        let before = hypotheses[0].pose;
        let steps = hypotheses.each_mut().map(|hypothesis| {
            let pair = evaluated::<f64>(77).measurement;
            let mut update = super::super::Update::NONE;
            hypothesis.next_update(&pair, &context, &mut update).unwrap();
            hypothesis.apply(&pair, &mut update, &context);
            before.unknowns_to(&hypothesis.pose)
        });
        let sd = hypotheses[0].deviations(&context).unwrap();
        assert!((steps[0] - steps[1]).amax() < 0.1 * sd.rotation, "{steps:?} {sd:?}");
        assert!(steps[0].amax() > 0.1 * sd.rotation);
    }
}
