//! One pass of a solver: weighted normal equations and counts over the batch (`ESTIMATOR.md`, sections 5 and 6).

use super::constraint::Constraint;
use super::iterate::Iterate;
use super::leverage::HighLeverage;
use super::loss::{ResidualVariance, geman_mcclure, tukey};
use super::normal_sums::NormalSums;
use super::scale::{LevelCounts, LevelTally};
use super::schedule::Schedule;
use super::sweep::{self, Pass, Sample, Sink};
use super::weighting::{Loss, WeightedRow, Weighting, tracked};
use crate::algebra::normal_equations::NormalEquations;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Value};
use crate::thresholds::NEAR;

/// Sums of a pass; counts are whole numbers.
#[derive(Debug, Clone, Copy)]
pub(super) struct PassSums<T> {
    /// Normal equations, leverage limited.
    pub(super) normal: NormalEquations<T>,
    /// Correspondences in front of both cameras.
    pub(super) usable: T,
    /// Correspondences of a weight above 0.
    pub(super) weighted: T,
    /// Residuals within 2 standard deviations; counted in a polish only.
    pub(super) near: T,
    /// Their estimates of the noise variance, summed, px^2.
    pub(super) near_squares: T,
    /// Robust cost, in variances, of the correspondences in front of both cameras; summed in a polish only.
    pub(super) cost: T,
    /// Residuals by size; counted in a search only, once its scale is small.
    pub(super) levels: LevelCounts<T>,
    /// Correspondences of high leverage; counted in a track only.
    pub(super) high: HighLeverage<T, T>,
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
}

/// A pass of a solver, with its sums so far.
pub(super) struct PassOver<'a, T: Scalar> {
    pub(super) iterate: &'a Iterate<T>,
    pub(super) schedule: &'a Schedule<T>,
    pub(super) sums: PassSums<T>,
}

impl<T: Scalar> Pass<T> for PassOver<'_, T> {
    const QUADS: bool = true;

    #[inline(always)]
    fn sweep<L: Lanes<T>>(&mut self, lanes: L, source: impl Iterator<Item = Sample<L::Value>>) {
        let weighting = self.iterate.weighting(lanes, self.schedule.loss(lanes));
        let by = sweep::in_memory(lanes, weighting);
        let zero = lanes.splat(T::ZERO);
        // Outside the sink: an array with a computed index stays in memory, and would keep the other sums there.
        let mut tally = LevelTally::none(lanes);
        let sees_peaks = self.schedule.sees_peaks();
        let mut sink = PassSink {
            by: &by,
            normal: NormalSums::resume(lanes, &self.sums.normal),
            counts: [zero; 3],
            levels: sees_peaks.then_some(&mut tally),
            high: HighLeverage {
                bands: [zero; 2],
                roots: lanes.resume(self.sums.high.roots),
                inverse_roots: lanes.resume(self.sums.high.inverse_roots),
            },
            near_squares: lanes.resume(self.sums.near_squares),
            cost: lanes.resume(self.sums.cost),
        };
        sweep::sweep(lanes, source, &mut sink);
        let PassSink { normal, counts, high, near_squares, cost, .. } = sink;
        let sums = &mut self.sums;
        normal.store(lanes, &mut sums.normal);
        tally.reduce_onto(lanes, &mut sums.levels);
        lanes.store(near_squares, &mut sums.near_squares);
        lanes.store(cost, &mut sums.cost);
        lanes.store(high.roots, &mut sums.high.roots);
        lanes.store(high.inverse_roots, &mut sums.high.inverse_roots);
        let totals = [&mut sums.usable, &mut sums.weighted, &mut sums.near].into_iter();
        let totals = totals.chain(&mut sums.high.bands);
        for (to, count) in totals.zip(counts.into_iter().chain(high.bands)) {
            *to += lanes.reduce(count);
        }
    }
}

/// Sums of a pass in lanes.
struct PassSink<'a, T: Scalar, L: Lanes<T>> {
    by: &'a Weighting<L::Value>,
    normal: NormalSums<L::Sum>,
    /// `usable`, `weighted` and `near` of [`PassSums`].
    counts: [L::Value; 3],
    levels: Option<&'a mut LevelTally<L::Value>>,
    high: HighLeverage<L::Value, L::Sum>,
    near_squares: L::Sum,
    cost: L::Sum,
}

impl<T: Scalar, L: Lanes<T>> Sink<T, L> for PassSink<'_, T, L> {
    type Row = WeightedRow<L::Value>;

    #[inline(always)]
    fn row(&mut self, lanes: L, (rays, grid_step): Sample<L::Value>) -> Option<Self::Row> {
        let (constraint, in_front) = Constraint::of(lanes, &self.by.pose, rays);
        if !lanes.any(in_front) {
            return None;
        }
        let one = lanes.splat(T::ONE);
        let [usable, ..] = &mut self.counts;
        *usable = *usable + lanes.keep(in_front, one);
        let precision = self.by.precision(lanes, &constraint, in_front);
        let w = self.weight(lanes, &constraint, in_front, precision, grid_step);
        let positive = lanes.lt(lanes.splat(T::ZERO), w);
        if !lanes.any(positive) {
            return None;
        }
        let [_, weighted, _] = &mut self.counts;
        *weighted = *weighted + lanes.keep(positive, one);
        let (row, limited) = self.by.row(lanes, &constraint, precision, w);
        if let (Loss::Track(_), Some(leverage), Some(limited)) =
            (&self.by.loss, &self.by.leverage, limited)
        {
            let is_high = leverage.is_high(lanes, limited.share);
            if lanes.any(is_high) {
                let squared = constraint.value * constraint.value * precision;
                let expected = ResidualVariance::of(lanes, self.by.noise_squared, grid_step);
                let near = expected.count_bands(lanes, is_high, squared, &mut self.high.bands);
                self.high.add(lanes, near, limited.share);
            }
        }
        Some(row)
    }

    #[inline(always)]
    fn none(lanes: L) -> Self::Row {
        WeightedRow::none(lanes)
    }

    #[inline(always)]
    fn add_one(&mut self, lanes: L, row: Self::Row) {
        self.normal.add_one(lanes, row);
    }

    #[inline(always)]
    fn add(&mut self, lanes: L, rows: &[Self::Row]) {
        self.normal.add(lanes, rows.iter().copied());
    }
}

impl<V: Value, T: Scalar, L: Lanes<T, Value = V>> PassSink<'_, T, L> {
    /// Weight by the loss, 1/px^2, before leverage is limited; counts residuals, and sums the cost of a polish.
    ///
    /// * `precision`: `f^2 / V`, px^2; `grid_step`: px.
    #[inline(always)]
    fn weight(
        &mut self,
        lanes: L,
        constraint: &Constraint<V>,
        in_front: L::Mask,
        precision: V,
        grid_step: V,
    ) -> V {
        let by = self.by;
        let squared = constraint.value * constraint.value * precision;
        if let Some(levels) = &mut self.levels {
            levels.add(lanes, in_front, squared);
        }
        if let Loss::Anneal(scale) = &by.loss {
            return lanes.keep(in_front, geman_mcclure(lanes, squared * *scale) * *scale);
        }
        let ahead = lanes.and(in_front, constraint.has_disparity(lanes, by.min_disparity));
        let expected = ResidualVariance::of(lanes, by.noise_squared, grid_step);
        if let Loss::Track(covariance) = &by.loss {
            if !lanes.any(ahead) {
                return lanes.splat(T::ZERO);
            }
            let x = tracked(lanes, covariance, by.tukey_squared, constraint, precision, &expected);
            return lanes.keep(ahead, tukey(lanes, x) / expected.variance);
        }
        // What is behind infinity costs as much as an outlier, and weighs nothing.
        let counted = lanes.select(ahead, squared, expected.limit_squared(by.tukey_squared));
        let (weight, cost) = expected.tukey(lanes, by.tukey_squared, counted);
        lanes.add(&mut self.cost, lanes.keep(in_front, cost));
        let is_near = lanes.and(ahead, expected.is_within(lanes, NEAR, squared));
        let [.., near] = &mut self.counts;
        *near = *near + lanes.keep(is_near, lanes.splat(T::ONE));
        let of_noise = lanes.keep(is_near, expected.noise_squared(lanes, squared));
        lanes.add(&mut self.near_squares, of_noise);
        lanes.keep(ahead, weight)
    }
}
