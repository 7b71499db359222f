//! Weight of a correspondence in the normal equations of a pass: loss, inverse variance and leverage.

use super::constraint::{Constraint, PoseTerms};
use super::leverage::{Leverage, Limited};
use super::loss::ResidualVariance;
use crate::algebra::symmetric5::form;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Value};

/// Loss of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) enum Loss<V> {
    /// Geman-McClure; one over the square of its scale, 1/px^2.
    Anneal(V),
    /// Tukey, its limit widened by the covariance of the pose (lower triangle, rad^2).
    Track([V; 15]),
    /// Tukey at the estimated noise.
    Polish,
}

/// Parameters of the weights of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighting<V> {
    pub(super) pose: PoseTerms<V>,
    pub(super) loss: Loss<V>,
    /// Limit on leverage, if known.
    pub(super) leverage: Option<Leverage<V>>,
    /// Square of the focal length, px^2.
    pub(super) focal_squared: V,
    /// Inverse of that: area of a pixel at unit depth.
    pub(super) unit_squared: V,
    /// Variance of a coordinate, px^2.
    pub(super) noise_squared: V,
    /// Squared limit of Tukey's loss, in units of the loss.
    pub(super) tukey_squared: V,
    /// Smallest disparity, unit depth.
    pub(super) min_disparity: V,
}

/// Row of the normal equations, of one correspondence per lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct WeightedRow<V> {
    /// `w f^2 / V`, leverage limited, dimensionless; 0 without influence.
    pub(super) weight: V,
    /// `C`.
    pub(super) value: V,
    /// Derivatives of `C / sqrt V` times `sqrt V`, 1/rad; of `C` in a track.
    pub(super) jacobian: [V; 5],
}

impl<V: Value> Weighting<V> {
    /// `f^2 / V`: inverse variance of the constraint for coordinates of variance 1 px^2.
    #[inline(always)]
    pub(super) fn precision<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        constraint: &Constraint<V>,
        in_front: L::Mask,
    ) -> V {
        // `V` may vanish behind a camera: 1 avoids 0 * inf = NaN.
        self.focal_squared / lanes.select(in_front, constraint.variance, lanes.splat(T::ONE))
    }

    /// Row of a correspondence, and what the limit on leverage does to it.
    ///
    /// * `precision`: `f^2 / V`, px^2; `w`: weight by the loss, 1/px^2.
    #[inline(always)]
    pub(super) fn row<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        constraint: &Constraint<V>,
        precision: V,
        w: V,
    ) -> (WeightedRow<V>, Option<Limited<V>>) {
        let value = constraint.value;
        let jacobian = match self.loss {
            // The pose after a track's two steps decides weights only: the derivative of `V` is left out.
            Loss::Track(_) => constraint.jacobian,
            Loss::Anneal(_) | Loss::Polish => {
                let ratio = value * precision * self.unit_squared;
                constraint.whitened_jacobian(lanes, &self.pose, ratio)
            }
        };
        let weight = w * precision;
        let limited = self.leverage.as_ref().map(|l| l.factor(lanes, weight, &jacobian));
        let weight = limited.map_or(weight, |limited| weight * limited.factor);
        (WeightedRow { weight, value, jacobian }, limited)
    }
}

impl<V: Value> WeightedRow<V> {
    /// A row without influence.
    #[inline(always)]
    pub(super) fn none<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let zero = lanes.splat(T::ZERO);
        Self { weight: zero, value: zero, jacobian: [zero; 5] }
    }
}

/// Squared residual over Tukey's squared limit, dimensionless. The uncertainty of the pose adds to the noise, as in
/// covariance gating.
///
/// * `covariance`: of the pose, lower triangle, rad^2.
/// * `tukey_squared`: squared limit, in units of the loss.
/// * `precision`: `f^2 / V`, px^2.
#[inline(always)]
pub(super) fn tracked<T: Scalar, L: Lanes<T>>(
    lanes: L,
    covariance: &[L::Value; 15],
    tukey_squared: L::Value,
    constraint: &Constraint<L::Value>,
    precision: L::Value,
    expected: &ResidualVariance<L::Value>,
) -> L::Value {
    let Constraint { value, jacobian, .. } = constraint;
    let of_pose = form(lanes, covariance, jacobian);
    let wide = lanes.mul_add(of_pose, precision, expected.unit_squared);
    *value * *value * precision / (wide * tukey_squared)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::symmetric5::Symmetric5;
    use crate::geometry::rectification::tests::pose;
    use crate::simd::Single;
    use crate::thresholds::TUKEY;
    use nalgebra::Vector5;

    #[test]
    fn the_uncertainty_of_the_pose_widens_the_loss_by_what_it_does_to_the_residual() {
        const FOCAL: f64 = 500.0;
        let frame = PoseTerms::at(Single, &pose([0.05, -0.08, 0.03], [0.1, -0.06]));
        let rays = [0.3, -0.2, 0.25, -0.19];
        let (constraint, _) = Constraint::of(Single, &frame, rays);
        let precision = FOCAL * FOCAL / constraint.variance;
        let mut covariance = Symmetric5::of_diagonal([1e-6, 2e-6, 3e-6, 4e-6, 5e-6]);
        covariance.add_outer(1e-6, &[1.0, -0.5, 0.3, 0.2, -0.7]);
        let expected_variance = ResidualVariance::of(Single, 0.09, 1.0);
        let x = tracked(
            Single,
            &covariance.0,
            TUKEY * TUKEY,
            &constraint,
            precision,
            &expected_variance,
        );
        let j = Vector5::from(constraint.jacobian) * precision.sqrt();
        let variance = 0.36 + j.dot(&(covariance.matrix() * j));
        let residual = constraint.value * precision.sqrt();
        let expected = (residual / TUKEY).powi(2) / variance;
        assert!((x / expected - 1.0).abs() < 1e-12, "{x} {expected}");
    }
}
