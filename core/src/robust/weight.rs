//! How far a residual may lie from zero: noise of the matcher, and the grid it rounds to.

use super::TUKEY;
use crate::loss::Redescending;
use crate::scalar::Scalar;

/// Smallest unit of the loss, in steps of the grid: a narrower one locks on the mode of rounded rows,
/// not on their mean.
const MIN_UNIT: f64 = 0.6;

/// Variance of a normal distribution cut off at two standard deviations.
const TRUNCATED_VARIANCE: f64 = 0.7737;

/// Expected spread of one correspondence's whitened residual, px of one coordinate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread<T> {
    /// Of noise and rounding together, px^2.
    pub(super) variance: T,
    /// Of the rounding alone: `q^2 / 12`, px^2.
    of_grid: T,
    /// Unit that the loss measures residuals in, squared, px^2.
    pub(super) unit_squared: T,
}

impl<T: Scalar> Spread<T> {
    /// * `noise_squared`: variance before rounding, px^2.
    /// * `grid_step`: px.
    #[inline(always)]
    pub(super) fn of(noise_squared: T, grid_step: T) -> Self {
        let square = grid_step * grid_step;
        let of_grid = square * T::lit(1.0 / 12.0);
        let variance = noise_squared + of_grid;
        let least = square * T::lit(MIN_UNIT * MIN_UNIT);
        let unit_squared = if variance < least { least } else { variance };
        Self { variance, of_grid, unit_squared }
    }

    /// Whether a residual is within so many units.
    ///
    /// * `squared`: of the residual, px^2.
    #[inline(always)]
    pub(super) fn is_within(&self, units: T, squared: T) -> bool {
        squared < units * units * self.unit_squared
    }

    /// What the square of a residual within 2 units says of the variance before rounding, px^2.
    #[inline(always)]
    pub(super) fn noise_squared(&self, squared: T) -> T {
        squared * T::lit(1.0 / TRUNCATED_VARIANCE) - self.of_grid
    }

    /// Weight of a residual by Tukey's biweight, 1/px^2.
    ///
    /// * `squared`: of the residual, px^2.
    #[inline(always)]
    pub(super) fn tukey(&self, squared: T) -> T {
        let x = squared / (T::lit(TUKEY * TUKEY) * self.unit_squared);
        Redescending::Tukey.weight(x) / self.variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_is_that_of_the_noise_and_of_the_rounding() {
        let spread = Spread::of(0.09_f64, 2.0);
        assert!((spread.variance - (0.09 + 4.0 / 12.0)).abs() < 1e-15);
        assert!((spread.of_grid - 4.0 / 12.0).abs() < 1e-15);
        let continuous = Spread::of(0.09_f64, 0.0);
        assert_eq!((continuous.variance, continuous.of_grid), (0.09, 0.0));
        assert_eq!(continuous.unit_squared, 0.09);
    }

    #[test]
    fn the_unit_is_the_deviation_but_at_least_three_fifths_of_a_step() {
        let floored = Spread::of(0.04_f64, 1.0);
        assert!((floored.unit_squared.sqrt() - 0.6).abs() < 1e-15);
        let noisy = Spread::of(0.81_f64, 1.0);
        assert_eq!(noisy.unit_squared, noisy.variance);
    }

    #[test]
    fn residuals_are_measured_in_units() {
        let spread = Spread::of(0.04_f64, 1.0);
        assert!(
            spread.is_within(2.0, 1.199_f64.powi(2)) && !spread.is_within(2.0, 1.201_f64.powi(2))
        );
        assert!(!spread.is_within(2.0, f64::NAN));
        let share = |r: f64| spread.tukey(r * r) * spread.variance;
        // One whole step off still counts, past Tukey's limit nothing does.
        assert!(share(1.0) > 0.7 && (share(0.0) - 1.0).abs() < 1e-15);
        assert_eq!(share(0.6 * TUKEY + 1e-9), 0.0);
        assert!(share(0.6 * TUKEY - 0.1) > 0.0);
        assert_eq!(share(f64::NAN), 0.0);
    }
}
