//! How far a residual may lie from zero: noise of the matcher, and the grid it rounds to.

use super::TUKEY;
use crate::loss::Redescending;
use crate::scalar::Scalar;

/// Smallest unit of the loss, in steps of the grid: a narrower one locks on the mode of rounded rows,
/// not on their mean.
const MIN_UNIT: f64 = 0.6;

/// Expected spread of one correspondence's whitened residual, px of one coordinate.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread<T> {
    /// Of noise and rounding together, px^2.
    pub(super) variance: T,
    /// Of the rounding alone: `q^2 / 12`, px^2.
    pub(super) of_grid: T,
    /// Unit that the loss measures residuals in, squared, px^2.
    pub(super) unit_squared: T,
}

impl<T: Scalar> Spread<T> {
    /// * `noise`: standard deviation before rounding, px.
    /// * `grid_step`: px.
    pub(super) fn of(noise: T, grid_step: T) -> Self {
        let square = grid_step * grid_step;
        let of_grid = square / T::lit(12.0);
        let variance = noise * noise + of_grid;
        let unit_squared = variance.max(square * T::lit(MIN_UNIT * MIN_UNIT));
        Self { variance, of_grid, unit_squared }
    }

    /// Whether a residual is within so many units.
    pub(super) fn is_within(&self, units: T, r: T) -> bool {
        r * r < units * units * self.unit_squared
    }

    /// Weight of a residual by Tukey's biweight.
    pub(super) fn tukey(&self, r: T) -> T {
        Redescending::Tukey(T::lit(TUKEY) * self.unit_squared.sqrt()).weight(r)
    }
}
