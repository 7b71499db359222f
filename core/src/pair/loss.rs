//! Loss functions and expected variance of a residual (`ESTIMATOR.md`, section 5).
//!
//! The expected variance is the variance of the matcher's noise plus the variance of rounding to its grid.

use crate::scalar::Scalar;
use crate::thresholds::{MIN_UNIT, NEAR};

/// Variance of a unit normal distribution cut off at [`NEAR`]: `1 - 4 phi(2) / (2 Phi(2) - 1)`.
const TRUNCATED_VARIANCE: f64 = 0.7737;

/// Outer edge of the band beside a peak, in units of the loss. The band begins at [`NEAR`], and is as wide as the peak
/// on one side of zero.
pub(super) const BESIDE: f64 = 2.0 * NEAR;

/// Returns the Geman-McClure weight `1 / (1 + x)^2` for `x = (r / scale)^2`, dimensionless. It is smooth and wide, as
/// graduated non-convexity requires.
pub(super) fn geman_mcclure<T: Scalar>(x: T) -> T {
    let root = T::ONE / (T::ONE + x);
    root * root
}

/// Returns Tukey's biweight for `x = (r / limit)^2`, dimensionless: `(1 - x)^2` up to `x = 1`, and zero beyond.
#[inline(always)]
pub(super) fn tukey<T: Scalar>(x: T) -> T {
    let root = tukey_root(x);
    root * root
}

/// Returns the square root of [`tukey`]; 0 for NaN.
fn tukey_root<T: Scalar>(x: T) -> T {
    if x < T::ONE { T::ONE - x } else { T::ZERO }
}

/// Expected variance of a whitened residual `r = f C / sqrt V`, as the variance of one coordinate, px^2.
#[derive(Debug, Clone, Copy)]
pub(super) struct ResidualVariance<T> {
    /// Variance of noise and rounding together, px^2.
    pub(super) variance: T,
    /// Variance of rounding alone: `q^2 / 12`, px^2.
    of_grid: T,
    /// Squared unit of the loss, px^2: the variance, but at least `(0.6 q)^2`.
    pub(super) unit_squared: T,
}

impl<T: Scalar> ResidualVariance<T> {
    /// Returns the expected variance for given noise and grid.
    ///
    /// * `noise_squared`: variance before rounding, px^2.
    /// * `grid_step`: `q`, px; 0 for a matcher that does not round.
    #[inline(always)]
    pub(super) fn of(noise_squared: T, grid_step: T) -> Self {
        let square = grid_step * grid_step;
        let of_grid = square * T::lit(1.0 / 12.0);
        let variance = noise_squared + of_grid;
        let least = square * T::lit(MIN_UNIT * MIN_UNIT);
        let unit_squared = if variance < least { least } else { variance };
        Self { variance, of_grid, unit_squared }
    }

    /// Returns whether a residual is below `units` units of the loss; false for NaN.
    ///
    /// * `squared`: squared residual, px^2.
    pub(super) fn is_within(&self, units: f64, squared: T) -> bool {
        squared < T::lit(units * units) * self.unit_squared
    }

    /// Returns whether a residual is within half a unit of the loss, with an allowance for the rounding of rows without
    /// noise.
    ///
    /// * `squared`: squared residual, px^2.
    pub(super) fn is_inner(&self, squared: T) -> bool {
        let of_grid = T::lit(12.0 * MIN_UNIT * MIN_UNIT) * self.of_grid;
        squared < T::lit(0.25) * self.unit_squared + of_grid
    }

    /// Counts a residual in the band below 2 units of the loss, or in the band from 2 to 4 units. Outliers fill both
    /// bands equally. Returns whether the residual is below 2 units.
    ///
    /// * `squared`: squared residual, px^2.
    pub(super) fn count_bands(&self, squared: T, [near, beside]: &mut [T; 2]) -> bool {
        let is_near = self.is_within(NEAR, squared);
        if is_near {
            *near += T::ONE;
        } else if self.is_within(BESIDE, squared) {
            *beside += T::ONE;
        }
        is_near
    }

    /// Returns an estimate of the variance before rounding, px^2, from a residual within 2 units. It is unbiased for
    /// normal residuals whose standard deviation is the unit.
    ///
    /// * `squared`: squared residual, px^2.
    pub(super) fn noise_squared(&self, squared: T) -> T {
        squared * T::lit(1.0 / TRUNCATED_VARIANCE) - self.of_grid
    }

    /// Returns the squared limit of Tukey's biweight, px^2.
    ///
    /// * `units_squared`: squared limit in units of the loss.
    pub(super) fn limit_squared(&self, units_squared: T) -> T {
        units_squared * self.unit_squared
    }

    /// Returns the weight of a residual, 1/px^2, which is Tukey's biweight over the variance, and the cost in
    /// variances. The cost is at most a sixth of the squared limit over the variance.
    ///
    /// * `units_squared`: squared limit in units of the loss; `squared`: squared residual, px^2.
    #[inline(always)]
    pub(super) fn tukey(&self, units_squared: T, squared: T) -> (T, T) {
        let limit = self.limit_squared(units_squared);
        // One division serves both quotients, because division is the slowest instruction of a controller.
        let inverse = T::ONE / (limit * self.variance);
        let (inverse_variance, x) = (inverse * limit, squared * (inverse * self.variance));
        let root = tukey_root(x);
        let square = root * root;
        let most = limit * inverse_variance * T::lit(1.0 / 6.0);
        (square * inverse_variance, most * (T::ONE - square * root))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thresholds::TUKEY;

    #[test]
    fn variance_adds_noise_and_rounding() {
        let expected = ResidualVariance::of(0.09_f64, 2.0);
        assert!((expected.variance - (0.09 + 4.0 / 12.0)).abs() < 1e-15);
        assert!((expected.of_grid - 4.0 / 12.0).abs() < 1e-15);
        let continuous = ResidualVariance::of(0.09_f64, 0.0);
        assert_eq!((continuous.variance, continuous.of_grid), (0.09, 0.0));
        assert_eq!(continuous.unit_squared, 0.09);
    }

    #[test]
    fn the_unit_is_the_deviation_but_at_least_three_fifths_of_a_step() {
        let floored = ResidualVariance::of(0.04_f64, 1.0);
        assert!((floored.unit_squared.sqrt() - 0.6).abs() < 1e-15);
        let noisy = ResidualVariance::of(0.81_f64, 1.0);
        assert_eq!(noisy.unit_squared, noisy.variance);
    }

    #[test]
    fn inner_residuals_are_within_half_a_unit_and_an_allowance_for_rounding() {
        let inner = |step: f64, r: f64| ResidualVariance::of(0.25, step).is_inner(r * r);
        assert!(inner(0.0, 0.249) && !inner(0.0, 0.251));
        // With a step of 1 px the unit is 0.6 px, and the squared limit is 0.6^2 / 4 + 0.6^2.
        assert!(inner(1.0, 0.670) && !inner(1.0, 0.672));
    }

    #[test]
    fn residuals_are_measured_in_units() {
        let expected = ResidualVariance::of(0.04_f64, 1.0);
        let within = |r: f64| expected.is_within(2.0, r * r);
        assert!(within(1.199) && !within(1.201));
        assert!(!expected.is_within(2.0, f64::NAN));
        let share = |r: f64| expected.tukey(TUKEY * TUKEY, r * r).0 * expected.variance;
        // A residual of one grid step keeps most of its weight. A residual beyond the limit has no weight.
        assert!(share(1.0) > 0.7 && (share(0.0) - 1.0).abs() < 1e-15);
        assert_eq!(share(0.6 * TUKEY + 1e-9), 0.0);
        assert!(share(0.6 * TUKEY - 0.1) > 0.0);
        assert_eq!(share(f64::NAN), 0.0);
    }

    #[test]
    fn weights_are_the_derivatives_of_the_costs() {
        let h = 1e-6;
        for r in [-9.0, -2.0, -0.3, 0.0, 0.7, 1.9, 5.0_f64] {
            let slope = |cost: &dyn Fn(f64) -> f64| (cost(r + h) - cost(r - h)) / (2.0 * h);
            let cost = |r: f64| 2.0 * r * r / (4.0 + r * r);
            let weight = geman_mcclure(r * r / 4.0);
            assert!((slope(&cost) - weight * r).abs() < 1e-8, "{r}");
            let cost = |r: f64| 4.0 / 6.0 * (1.0 - (1.0 - r * r / 4.0).max(0.0).powi(3));
            let weight = tukey(r * r / 4.0);
            assert!((slope(&cost) - weight * r).abs() < 1e-8, "{r}");
        }
    }

    #[test]
    fn the_cost_of_a_polish_has_its_weight_as_derivative_and_is_bounded() {
        let h = 1e-6;
        for (noise, step) in [(0.3, 0.0), (0.3, 1.0), (2.0, 1.0_f64)] {
            let expected = ResidualVariance::of(noise * noise, step);
            let cost = |r: f64| expected.tukey(TUKEY * TUKEY, r * r).1;
            for r in [-2.9, -0.7, 0.0, 0.4, 1.1, 30.0_f64] {
                let slope = (cost(r + h) - cost(r - h)) / (2.0 * h);
                let (weight, _) = expected.tukey(TUKEY * TUKEY, r * r);
                assert!((slope - weight * r).abs() < 1e-6, "{noise} {step} {r}");
            }
            let most = TUKEY * TUKEY / 6.0 * expected.unit_squared / expected.variance;
            assert!((cost(30.0) - most).abs() < 1e-12);
        }
    }

    #[test]
    fn squares_within_two_deviations_give_the_variance_of_normal_noise() {
        let [mut squares, mut near] = [0.0; 2];
        let sd = 0.7_f64;
        let expected = ResidualVariance::of(sd * sd, 0.0);
        for i in -40_000..=40_000_i32 {
            let r = f64::from(i) * 1e-4;
            let density = (-r * r / (2.0 * sd * sd)).exp();
            if expected.is_within(2.0, r * r) {
                squares += density * expected.noise_squared(r * r);
                near += density;
            }
        }
        assert!((squares / near / (sd * sd) - 1.0).abs() < 1e-3, "{}", squares / near);
    }
}
