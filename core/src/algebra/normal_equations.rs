//! Normal equations: the quadratic model of a cost about a pose.
//!
//! After a step `d` of the five unknowns, half the cost is `d^T H d / 2 + g^T d` plus a constant. The optimum is
//! `d = -H^-1 g`, and its covariance is `H^-1`.

use nalgebra::Vector5;

use crate::algebra::information::Information;
use crate::algebra::symmetric5::Symmetric5;
use crate::scalar::Scalar;

/// Adds `pull` times a row of the Jacobian to a gradient.
#[inline(always)]
pub(crate) fn add_pull<T: Scalar>(gradient: &mut Vector5<T>, pull: T, jacobian: &[T; 5]) {
    let ([[a, b, c, d, e]], [j0, j1, j2, j3, j4]) = (&mut gradient.data.0, *jacobian);
    *a += pull * j0;
    *b += pull * j1;
    *c += pull * j2;
    *d += pull * j3;
    *e += pull * j4;
}

/// Gradient `g = sum w r J` and information `H = sum w J J^T` of half the cost `sum w r^2` at a pose, with respect to
/// the five unknowns of [`Information`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct NormalEquations<T> {
    /// `H`, 1/rad^2.
    pub(crate) information: Information<T>,
    /// `g`, 1/rad.
    pub(crate) gradient: Vector5<T>,
}

impl<T: Scalar> NormalEquations<T> {
    /// Model of a cost of zero.
    pub(crate) const ZERO: Self = Self {
        information: Information::ZERO,
        gradient: Vector5::new(T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ZERO),
    };

    /// Adds a residual `r` with weight `w` and its row of the Jacobian.
    #[inline(always)]
    pub(crate) fn add_row(&mut self, w: T, r: T, jacobian: &[T; 5]) {
        self.information.add_outer(w, jacobian);
        add_pull(&mut self.gradient, w * r, jacobian);
    }

    /// Adds the model of another cost about the same pose.
    pub(crate) fn add(&mut self, other: &Self) {
        self.information.add(&other.information);
        self.gradient += other.gradient;
    }

    /// Returns the model of the sum of both costs.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        let mut sum = *self;
        sum.add(other);
        sum
    }

    /// Returns the model without a part of the cost.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        Self {
            information: self.information.minus(&other.information),
            gradient: self.gradient - other.gradient,
        }
    }

    /// Returns the model of the cost times `factor`.
    #[inline(never)]
    pub(crate) fn scaled(&self, factor: T) -> Self {
        Self { information: self.information.scaled(factor), gradient: self.gradient * factor }
    }

    /// Returns the same model about the pose after a step `d`, rad: the gradient becomes `g + H d`.
    pub(crate) fn about(&self, d: &Vector5<T>) -> Self {
        Self { information: self.information, gradient: self.gradient + self.information.times(d) }
    }

    /// Returns the step to the optimum, `-H^-1 g`, rad; `None` if a direction is free.
    pub(crate) fn step(&self) -> Option<Vector5<T>> {
        Some(-self.information.0.factor(T::ZERO)?.solve(&self.gradient))
    }

    /// Returns the model with the baseline held fixed: the baseline has unit information, no gradient, and no
    /// correlation with `R`.
    pub(crate) fn rotation_only(&self) -> Self {
        let mut alone = *self;
        let [.., y, z] = &mut alone.gradient.data.0[0];
        (*y, *z) = (T::ZERO, T::ZERO);
        let h = &mut alone.information.0.0;
        (h[6], h[7], h[8], h[9]) = (T::ZERO, T::ZERO, T::ZERO, T::ONE);
        (h[10], h[11], h[12], h[13], h[14]) = (T::ZERO, T::ZERO, T::ZERO, T::ZERO, T::ONE);
        alone
    }

    /// Returns the model with a prior whose optimum is the pose. The prior has the same information on each unknown.
    ///
    /// * `prior`: information on each unknown, 1/rad^2.
    pub(crate) fn with_prior(&self, prior: T) -> Self {
        let mut joint = *self;
        joint.information.0.add_diagonal(prior);
        joint
    }

    /// Returns the model with a prior whose optimum is the pose.
    pub(crate) fn with(&self, prior: &Information<T>) -> Self {
        let mut joint = *self;
        joint.information.add(prior);
        joint
    }

    /// Returns the squared Mahalanobis distance between the optima of two models about the same pose: the NIS of two
    /// independent measurements. The true values may differ by a random effect. With correct covariances the distance
    /// is chi-square distributed with five degrees of freedom.
    ///
    /// `None` if a direction is free in one of the models, or if the distance is not finite.
    ///
    /// * `apart`: variance of the difference of the true values in each unknown, rad^2.
    pub(crate) fn distance_apart(&self, other: &Self, apart: &[T; 5]) -> Option<T> {
        let ((a, cov_a), (b, cov_b)) = (self.optimum()?, other.optimum()?);
        let mut both = cov_a.plus(&cov_b);
        both.add(&Symmetric5::of_diagonal(*apart));
        both.inverse_form(&(a - b))
    }

    /// Returns the step to the optimum, rad, and its covariance, rad^2; `None` if a direction is free.
    pub(crate) fn optimum(&self) -> Option<(Vector5<T>, Symmetric5<T>)> {
        let factor = self.information.0.factor(T::ZERO)?;
        Some((-factor.solve(&self.gradient), factor.inverse()))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    extern crate std;

    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Draws a nearly normal number of mean 0 and variance 1: the sum of twelve uniform numbers minus 6 (Irwin-Hall).
    pub(crate) fn normal(rng: &mut ChaCha8Rng) -> f64 {
        (0..12).map(|_| rng.random::<f64>()).sum::<f64>() - 6.0
    }

    /// Draws a row of the Jacobian whose elements differ greatly in size.
    fn row(rng: &mut ChaCha8Rng) -> [f64; 5] {
        let mut one = || rng.random_range(-1.0..1.0);
        [1.0 + 0.1 * one(), one(), one(), 0.1 * one(), 0.05 + 0.03 * one()].map(|j| 1e3 * j)
    }

    /// Draws the model of `n` rows with unit noise; the true optimum is 0.
    fn measured(n: usize, rng: &mut ChaCha8Rng) -> NormalEquations<f64> {
        let mut sum = NormalEquations::ZERO;
        for _ in 0..n {
            let j = row(rng);
            sum.add_row(1.0, normal(rng), &j);
        }
        sum
    }

    #[test]
    fn distance_of_consistent_models_is_chi_square_of_five_degrees_of_freedom() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let trials: u16 = test_support::runs(2_500, 10_000);
        let [mut sum, mut squares] = [0.0; 2];
        for _ in 0..trials {
            let (one, other) = (measured(20, &mut rng), measured(60, &mut rng));
            let distance = one.distance_apart(&other, &[0.0; 5]).unwrap();
            sum += distance;
            squares += distance * distance;
        }
        let mean = sum / f64::from(trials);
        let variance = squares / f64::from(trials) - mean * mean;
        // The limits are four standard errors. The standard error of the variance follows from the fourth central
        // moment, 540.
        let [of_mean, of_variance] =
            [10.0, 440.0].map(|m: f64| 4.0 * (m / f64::from(trials)).sqrt());
        assert!((mean - 5.0).abs() < of_mean, "{mean}");
        assert!((variance - 10.0).abs() < of_variance, "{variance}");
    }

    #[test]
    fn distance_is_at_least_the_gap_along_one_axis_in_standard_deviations() {
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let exact = NormalEquations { gradient: Vector5::zeros(), ..measured(40, &mut rng) };
        let sd = exact.information.covariance().unwrap().m44.sqrt();
        let apart = exact.about(&(-Vector5::ith(3, 3.0 * sd)));
        let distance = exact.distance_apart(&apart, &[0.0; 5]).unwrap();
        // A gap of 3 sd with twice the covariance gives 9 / 2 along this axis alone.
        assert!(distance >= 4.5 - 1e-9, "{distance}");
        assert!(exact.distance_apart(&exact, &[0.0; 5]).unwrap().abs() < 1e-12);
        assert_eq!(exact.distance_apart(&NormalEquations::ZERO, &[0.0; 5]), None);
    }

    #[test]
    fn the_optimum_about_another_pose_is_the_same() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        for _ in 0..100 {
            let model = measured(20, &mut rng);
            let d = Vector5::from_fn(|_, _| rng.random_range(-0.01..0.01));
            let moved = model.about(&d);
            let gap = moved.step().unwrap() + d - model.step().unwrap();
            assert!(gap.amax() < 1e-13, "{gap}");
            assert_eq!(moved.information, model.information);
        }
    }

    #[test]
    fn a_sum_minus_a_part_is_the_rest() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let (part, rest) = (measured(20, &mut rng), measured(30, &mut rng));
        let all = part.plus(&rest);
        let left = all.minus(&part);
        assert!((left.gradient - rest.gradient).amax() < 1e-8);
        assert!((left.step().unwrap() - rest.step().unwrap()).amax() < 1e-12);
        assert!((all.scaled(0.5).step().unwrap() - all.step().unwrap()).amax() < 1e-12);
    }
}
