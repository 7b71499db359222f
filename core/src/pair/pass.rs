//! One pass of a solver: weighted normal equations and counts over the batch (`ESTIMATOR.md`, sections 5 and 6).

use core::iter;

use super::constraint::Constraint;
use super::iterate::Iterate;
use super::leverage::HighLeverage;
use super::loss::{ResidualVariance, geman_mcclure, tukey};
use super::phase::Phase;
use super::scale::LevelCounts;
use super::weighting::{Loss, Weighting, tracked};
use crate::algebra::normal_equations::NormalEquations;
use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::thresholds::{NEAR, TRACKED};

/// Number of places to skip before each place that is read, if a pass reads half of the batch. Two bits each, lowest
/// bits first; 16 of 32 places are read. The places read follow no period within the 32 (Thue-Morse sequence). So if
/// outliers fill every second or every fourth place, their share among the places read is about their share in the
/// batch.
const LEFT_OUT: u32 = 0x1891_9219;

/// Sums of a pass; counts are whole numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct PassSums<T> {
    /// Normal equations, with limited leverage.
    pub(super) normal: NormalEquations<T>,
    /// Correspondences in front of both cameras.
    pub(super) usable: T,
    /// Correspondences with a weight above 0.
    pub(super) weighted: T,
    /// Residuals within 2 units of the loss, of correspondences with enough disparity; counted only in a polish.
    pub(super) near: T,
    /// Sum of the estimates of the noise variance from the near residuals, px^2.
    pub(super) near_squares: T,
    /// Robust cost of the correspondences in front of both cameras, in variances; summed only in a polish.
    pub(super) cost: T,
    /// Histogram of residuals; counted in a search, except at scales above [`crate::thresholds::WIDE_SCALE_PX`].
    pub(super) levels: LevelCounts<T>,
    /// Weighted correspondences of high leverage; counted only in a track.
    pub(super) high: HighLeverage<T>,
}

impl<T: Scalar> PassSums<T> {
    pub(super) const ZERO: Self = Self {
        normal: NormalEquations::ZERO,
        usable: T::ZERO,
        weighted: T::ZERO,
        near: T::ZERO,
        near_squares: T::ZERO,
        cost: T::ZERO,
        levels: LevelCounts::NONE,
        high: HighLeverage::NONE,
    };

    /// Returns the sums at the pose of an iterate over the batch; a track reads only half of a large batch.
    pub(super) fn of(iterate: &Iterate<T>, phase: &Phase<T>, matches: &[RayPair<T>]) -> Self {
        let by = iterate.weighting(phase.loss());
        let is_half = matches!(by.loss, Loss::Track(_)) && matches.len() > TRACKED;
        let mut sums = Self::ZERO;
        // Separate from `sums`: an array with a computed index stays in memory, and would keep the other sums in memory
        // too.
        let mut levels = LevelCounts::NONE;
        let mut counted = phase.sees_peaks().then_some(&mut levels);
        for pair in read(matches, is_half) {
            sums.add(&by, pair, counted.as_deref_mut());
        }
        Self { levels, ..sums }
    }

    /// Adds a correspondence.
    ///
    /// * `levels`: histogram of residuals; `None` if the pass counts none.
    #[inline(always)]
    fn add(&mut self, by: &Weighting<T>, pair: &RayPair<T>, levels: Option<&mut LevelCounts<T>>) {
        let Some(constraint) = Constraint::of(&by.pose, pair) else { return };
        self.usable += T::ONE;
        let precision = by.precision(&constraint);
        let squared = constraint.value * constraint.value * precision;
        if let Some(levels) = levels {
            levels.add(squared);
        }
        let w = match &by.loss {
            Loss::Anneal(unit) => geman_mcclure(squared * *unit) * *unit,
            Loss::Track(covariance) => {
                if !constraint.has_disparity(by.min_disparity) {
                    return;
                }
                let expected = by.expected(pair.grid_step());
                let x = tracked(covariance, by.tukey_squared, &constraint, precision, &expected);
                tukey(x) / expected.variance
            }
            Loss::Polish => {
                let is_ahead = constraint.has_disparity(by.min_disparity);
                self.polish(by.tukey_squared, &by.expected(pair.grid_step()), is_ahead, squared)
            }
        };
        if !(w > T::ZERO) {
            return;
        }
        self.weighted += T::ONE;
        let (row, limited) = by.row(&constraint, precision, w);
        self.normal.add_row(row.weight, row.value, &row.jacobian);
        if let (Loss::Track(_), Some(leverage), Some(limited)) = (&by.loss, &by.leverage, limited)
            && leverage.is_high(limited.share)
            && by.expected(pair.grid_step()).count_bands(squared, &mut self.high.bands)
        {
            self.high.add(limited.share);
        }
    }

    /// Returns the weight of a correspondence in a polish before the limit on leverage, 1/px^2. Adds to the cost and to
    /// the sums of near residuals.
    ///
    /// * `tukey_squared`: squared limit, in units of the loss; `squared`: squared whitened residual, px^2.
    /// * `is_ahead`: whether the disparity is large enough for a weight.
    #[inline(always)]
    fn polish(
        &mut self,
        tukey_squared: T,
        expected: &ResidualVariance<T>,
        is_ahead: bool,
        squared: T,
    ) -> T {
        // A match behind infinity, with too small a disparity, has the cost of an outlier and no weight.
        let counted = if is_ahead { squared } else { expected.limit_squared(tukey_squared) };
        let (weight, cost) = expected.tukey(tukey_squared, counted);
        self.cost += cost;
        if is_ahead && expected.is_within(NEAR, squared) {
            self.near += T::ONE;
            self.near_squares += expected.noise_squared(squared);
        }
        if is_ahead { weight } else { T::ZERO }
    }
}

/// Returns the correspondences that a pass reads: all, or about half.
fn read<T>(all: &[T], is_half: bool) -> impl Iterator<Item = &T> {
    let (mut place, mut left_out) = (0_usize, if is_half { LEFT_OUT } else { 0 });
    iter::from_fn(move || {
        place += usize::try_from(left_out & 3).unwrap_or_default();
        left_out = left_out.rotate_right(2);
        let read = all.get(place);
        place += 1;
        read
    })
}

#[cfg(test)]
mod tests;
