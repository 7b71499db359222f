//! A pass over the batch at one pose, on the way to another: sums, or only a look at what is usual.

use super::leverage::{Leverage, of_baseline, share};
use super::weight::Spread;
use super::{Descent, Stage, TUKEY};
use crate::correspondence::RayPair;
use crate::loss::Redescending;
use crate::quadratic::Quadratic;
use crate::residual::{Row, Sight};
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;
use crate::whitening::Whitening;

/// Correspondences that a survey looks at.
const SURVEYED: usize = 32;

/// Sums of one pass over the batch at one pose.
#[derive(Debug, Clone)]
pub(super) struct Pass<T> {
    /// Of `w J J^T` and `w J r`, with high leverage held down.
    pub(super) capped: Quadratic<T>,
    pub(super) usable: u32,
    /// Correspondences with a weight at all.
    pub(super) weighted: u32,
    /// Residuals within 2 standard deviations, and what of their squares is not the grid's, px^2.
    pub(super) near: u32,
    pub(super) near_squares: T,
}

impl<T: Scalar> Pass<T> {
    pub(super) const EMPTY: Self =
        Self { capped: Quadratic::ZERO, usable: 0, weighted: 0, near: 0, near_squares: T::ZERO };
}

impl<T: Scalar> Descent<T> {
    /// What leverage is usual, at the pose of before, where a mismatch has not yet had any.
    ///
    /// * `covariance`: of that pose.
    #[inline(never)]
    pub(super) fn survey(
        &self,
        pairs: &[RayPair<T>],
        covariance: &Symmetric<T>,
    ) -> Option<Leverage<T>> {
        let of_baseline = of_baseline(covariance);
        let whitening = Whitening::at(&self.at.pose);
        let [mut roots, mut weighted] = [T::ZERO; 2];
        for pair in spread_over(pairs, SURVEYED) {
            let Some(sight) = Sight::of(&self.at.pose, pair) else {
                continue;
            };
            if self.at.is_behind(&sight) {
                continue;
            }
            let row = whitening.row(&sight);
            let precision = self.at.precision(&whitening.variance(&sight));
            let spread = self.at.spread(pair);
            let x = following(covariance, &row, precision, &spread);
            let w = Redescending::GemanMcClure.weight(x) / spread.variance;
            roots += share(&of_baseline, w * precision, &row.jacobian).sqrt();
            weighted += T::ONE;
        }
        Leverage::first(roots / weighted.max(T::ONE), covariance)
    }

    /// * `most`: correspondences to look at.
    #[inline(never)]
    pub(super) fn pass(&self, pairs: &[RayPair<T>], most: usize) -> Pass<T> {
        let whitening = Whitening::at(&self.at.pose);
        let mut sums = Pass::EMPTY;
        for pair in spread_over(pairs, most) {
            self.add(&mut sums, &whitening, pair);
        }
        sums
    }

    #[inline(always)]
    fn add(&self, sums: &mut Pass<T>, whitening: &Whitening<T>, pair: &RayPair<T>) {
        let Some(sight) = Sight::of(&self.at.pose, pair) else {
            return;
        };
        sums.usable += 1;
        let mut row = whitening.row(&sight);
        let variance = whitening.variance(&sight);
        let precision = self.at.precision(&variance);
        let squared = row.offset * row.offset * precision;
        let w = match &self.stage {
            Stage::Anneal(scale) => {
                let scale_squared = *scale * *scale;
                Redescending::GemanMcClure.weight(squared / scale_squared) / scale_squared
            }
            Stage::Follow(_) | Stage::Polish if self.at.is_behind(&sight) => return,
            Stage::Follow(covariance) => {
                let spread = self.at.spread(pair);
                let x = following(covariance, &row, precision, &spread);
                Redescending::Tukey.weight(x) / spread.variance
            }
            Stage::Polish => {
                let spread = self.at.spread(pair);
                if spread.is_within(T::lit(2.0), squared) {
                    sums.near += 1;
                    sums.near_squares += spread.noise_squared(squared);
                }
                spread.tukey(squared)
            }
        };
        if !(w > T::ZERO) {
            return;
        }
        sums.weighted += 1;
        // The few steps of a track can do without: what they lead to is judged with it.
        if !matches!(self.stage, Stage::Follow(_)) {
            row = whitening.whole(&row, &sight, &variance);
        }
        let w = w * precision;
        sums.capped.add_row(w * self.at.left_of(w, &row), row.offset, &row.jacobian);
    }
}

/// Square of a residual over that of Tukey's limit, where the estimate's own uncertainty adds to the
/// noise.
///
/// * `precision`: px^2, one over the variance of the offset where a coordinate's is 1 px^2.
#[inline(always)]
fn following<T: Scalar>(
    covariance: &Symmetric<T>,
    row: &Row<T>,
    precision: T,
    spread: &Spread<T>,
) -> T {
    let of_pose = covariance.form(&row.jacobian) * precision;
    let wide = (spread.unit_squared + of_pose) * T::lit(TUKEY * TUKEY);
    row.offset * row.offset * precision / wide
}

/// At most so many of the correspondences, evenly spread over the batch.
fn spread_over<T>(pairs: &[RayPair<T>], most: usize) -> impl Iterator<Item = &RayPair<T>> {
    let stride = pairs.len().div_ceil(most.max(1)).max(1);
    pairs.iter().step_by(stride)
}
