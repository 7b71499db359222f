//! Weight of a correspondence in the normal equations of a pass, from loss, inverse variance and leverage.

use super::constraint::{Constraint, PoseTerms};
use super::leverage::{Leverage, Limited};
use super::loss::ResidualVariance;
use crate::algebra::symmetric5::Symmetric5;
use crate::scalar::Scalar;

/// Loss of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) enum Loss<T> {
    /// Geman-McClure, with the inverse square of its scale, 1/px^2.
    Anneal(T),
    /// Tukey, with its limit widened by the covariance of the pose, rad^2.
    Track(Symmetric5<T>),
    /// Tukey at the estimated noise.
    Polish,
}

/// Parameters of the weights of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighting<T> {
    pub(super) pose: PoseTerms<T>,
    pub(super) loss: Loss<T>,
    /// Limit on leverage; `None` if no limit is known.
    pub(super) leverage: Option<Leverage<T>>,
    /// Square of the focal length, px^2.
    pub(super) focal_squared: T,
    /// Inverse of `focal_squared`: area of a pixel at unit depth.
    pub(super) unit_squared: T,
    /// Variance of a coordinate before rounding to the matcher's grid, px^2.
    pub(super) noise_squared: T,
    /// Squared limit of Tukey's loss, in units of the loss.
    pub(super) tukey_squared: T,
    /// Smallest disparity of a weighted correspondence, unit depth. An annealing ignores it.
    pub(super) min_disparity: T,
}

/// Row of the normal equations.
#[derive(Debug, Clone, Copy)]
pub(super) struct WeightedRow<T> {
    /// `w f^2 / V` after the limit on leverage, dimensionless; above 0.
    pub(super) weight: T,
    /// `C`.
    pub(super) value: T,
    /// Derivatives of `C / sqrt V` times `sqrt V`, 1/rad; in a track, derivatives of `C`.
    pub(super) jacobian: [T; 5],
}

impl<T: Scalar> Weighting<T> {
    /// Returns `f^2 / (V s^2)`, px^2: the inverse variance of the constraint for coordinates with a variance of 1 px^2.
    pub(super) fn precision(&self, constraint: &Constraint<T>) -> T {
        self.focal_squared / constraint.variance
    }

    /// Returns the expected variance of a residual.
    ///
    /// * `grid_step`: step of the matcher's grid, px.
    pub(super) fn expected(&self, grid_step: T) -> ResidualVariance<T> {
        ResidualVariance::of(self.noise_squared, grid_step)
    }

    /// Returns the row of the normal equations for a correspondence, and the effect of the limit on leverage. The
    /// effect is `None` if no limit is known.
    ///
    /// * `precision`: `f^2 / V`, px^2; `w`: weight from the loss, 1/px^2.
    #[inline(always)]
    pub(super) fn row(
        &self,
        constraint: &Constraint<T>,
        precision: T,
        w: T,
    ) -> (WeightedRow<T>, Option<Limited<T>>) {
        let value = constraint.value;
        let jacobian = match self.loss {
            // The pose after the two steps of a track only determines weights, so the derivative of `V` is omitted.
            Loss::Track(_) => constraint.jacobian,
            Loss::Anneal(_) | Loss::Polish => {
                constraint.whitened_jacobian(&self.pose, value * precision * self.unit_squared)
            }
        };
        let weight = w * precision;
        let limited = self.leverage.as_ref().map(|limit| limit.factor(weight, &jacobian));
        let weight = limited.map_or(weight, |limited| weight * limited.factor);
        (WeightedRow { weight, value, jacobian }, limited)
    }
}

/// Returns the squared residual over Tukey's squared limit in a track, dimensionless. The limit covers the noise and
/// the uncertainty of the pose.
///
/// * `covariance`: covariance of the pose, rad^2.
/// * `tukey_squared`: squared limit, in units of the loss.
/// * `precision`: `f^2 / V`, px^2.
#[inline(always)]
pub(super) fn tracked<T: Scalar>(
    covariance: &Symmetric5<T>,
    tukey_squared: T,
    constraint: &Constraint<T>,
    precision: T,
    expected: &ResidualVariance<T>,
) -> T {
    let Constraint { value, jacobian, .. } = constraint;
    let wide = covariance.form(jacobian) * precision + expected.unit_squared;
    *value * *value * precision / (wide * tukey_squared)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::correspondence::RayPair;
    use crate::geometry::rectification::tests::pose;
    use crate::thresholds::TUKEY;
    use nalgebra::Vector5;

    #[test]
    fn the_uncertainty_of_the_pose_widens_the_loss_by_its_effect_on_the_residual() {
        const FOCAL: f64 = 500.0;
        let frame = PoseTerms::at(&pose([0.05, -0.08, 0.03], [0.1, -0.06]));
        let rays = [0.3, -0.2, 0.25, -0.19];
        let constraint = Constraint::of(&frame, &RayPair::of_rays(rays)).unwrap();
        let precision = FOCAL * FOCAL / constraint.variance;
        let mut covariance = Symmetric5::of_diagonal([1e-6, 2e-6, 3e-6, 4e-6, 5e-6]);
        covariance.add_outer(1e-6, &[1.0, -0.5, 0.3, 0.2, -0.7]);
        let expected_variance = ResidualVariance::of(0.09, 1.0);
        let x = tracked(&covariance, TUKEY * TUKEY, &constraint, precision, &expected_variance);
        let j = Vector5::from(constraint.jacobian) * precision.sqrt();
        let variance = 0.36 + j.dot(&(covariance.matrix() * j));
        let residual = constraint.value * precision.sqrt();
        let expected = (residual / TUKEY).powi(2) / variance;
        assert!((x / expected - 1.0).abs() < 1e-12, "{x} {expected}");
    }
}
