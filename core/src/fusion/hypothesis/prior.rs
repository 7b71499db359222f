//! A hypothesis as a prior, and a hypothesis that starts from a prior.

use super::Hypothesis;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::information::Information;
use crate::algebra::normal_equations::NormalEquations;
use crate::algebra::prior_moments::Response;
use crate::config::Context;
use crate::fusion::prior::Prior;
use crate::scalar::Scalar;

impl<T: Scalar> Hypothesis<T> {
    /// The estimate without its pairs; `None` if there is no estimate.
    #[inline(never)]
    pub(in crate::fusion) fn as_prior(&self, context: &Context<'_, T>) -> Option<Prior<T>> {
        let mut prior = self.of_sums(context)?;
        let drifts = self.drift.dot(&self.information.times(&self.drift)) > T::ONE;
        if drifts || !self.vibration(context).is_zero() || !self.halves.agree() {
            prior.equations = self.of_covariance(context)?;
        }
        Some(prior)
    }

    /// The prior of a rigid rig.
    #[inline(never)]
    fn of_sums(&self, context: &Context<'_, T>) -> Option<Prior<T>> {
        let at_rest = self.pose_at_rest(&self.pose)?;
        let mut sums = self.sums;
        sums.change_frame(&self.frame, &at_rest);
        Some(Prior {
            pose: self.pose,
            equations: sums.biased_at_frame(),
            response: Response::of(&sums, context.prior)?,
            chi_square: self.reduced_chi_square,
            pairs: self.pairs,
            noise: self.noise,
            shares: [self.inlier_share, self.crowd],
            high_leverage: self.high_leverage,
        })
    }

    /// Equations with the covariance of the estimate, and without noise. The sums alone are not enough: a vibrating rig
    /// weighs each pair, and the covariance of a drifting rig, or with disagreeing image halves, is wider than that of
    /// its pairs.
    #[inline(never)]
    fn of_covariance(&self, context: &Context<'_, T>) -> Option<BiasedEquations<T>> {
        let mut information = self.covariance(context)?.inverse()?;
        information.add_diagonal(-context.prior);
        let gradient = self.pose.unknowns_to(&context.factory_pose) * context.prior;
        let normal = NormalEquations { information: Information(information), gradient };
        Some(BiasedEquations { normal, ..BiasedEquations::ZERO })
    }

    /// Starts an empty hypothesis with a prior.
    #[inline(never)]
    pub(in crate::fusion) fn resume(&mut self, prior: &Prior<T>, context: &Context<'_, T>) {
        let normal = prior.equations.debiased();
        (self.pose, self.frame, self.information) = (prior.pose, prior.pose, normal.information);
        // Row offsets scatter by the noise of both views, and the pitch element of `H` is the sum of the weights.
        let deviation = prior.noise / context.focal;
        let [weights, ..] = prior.equations.normal.information.0.diagonal();
        let squares = weights * deviation * deviation * T::lit(2.0);
        self.sums.set_prior(&prior.equations, &prior.response, squares);
        if !context.vibration.is_zero() {
            self.marginal.sum = normal;
            self.marginal.variances = context.vibration.at_least_rigid();
        }
        self.noise = prior.noise;
        [self.inlier_share, self.crowd] = prior.shares;
        self.high_leverage = prior.high_leverage;
        self.reduced_chi_square = prior.chi_square;
        self.pairs = prior.pairs;
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::super::tests::{context, evaluated, fused};
    use super::*;
    use crate::algebra::block_variances::BlockVariances;
    use crate::algebra::lens_terms::{LENS_PARAMETERS, LensTerms};
    use nalgebra::Vector5;

    fn resumed(from: &Hypothesis<f64>, context: &Context<'_, f64>) -> Hypothesis<f64> {
        let mut resumed = Hypothesis::EMPTY;
        resumed.resume(&from.as_prior(context).unwrap(), context);
        resumed
    }

    /// Movements of the estimate by the lens.
    fn effects(
        of: &Hypothesis<f64>,
        context: &Context<'_, f64>,
    ) -> [Vector5<f64>; LENS_PARAMETERS] {
        let mut mixed = [[0.0; 5]; LENS_PARAMETERS];
        let mut information = [[0.0; LENS_PARAMETERS]; LENS_PARAMETERS];
        let mut gradient = [0.0; LENS_PARAMETERS];
        let biased = of.fill_lens(LensTerms {
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
        // The record keeps the equations of a vibrating rig without the noise of disparities, which the response
        // includes.
        for (context, most) in [(rigid, 1e-3), (rigid.vibrating(turns), 0.15)] {
            let pairs: std::vec::Vec<_> = (0..12).map(evaluated).collect();
            let before = fused(&pairs, 2, &context);
            let after = resumed(&before, &context);
            assert_eq!(after.pose, before.pose);
            let covariances = [&before, &after].map(|h| h.reported_covariance(&context).unwrap());
            let [old, new] = covariances.map(|covariance| covariance.diagonal());
            for (old, new) in old.into_iter().zip(new) {
                // The estimate keeps the information of the step before its last one.
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
