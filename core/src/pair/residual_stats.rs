//! Residual statistics at a pose: noise, inliers, and the fit against that of the start (`ESTIMATOR.md`, section 7).

use super::loss::{BESIDE, ResidualVariance};
use crate::batch::sides::is_behind;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Value};
use crate::thresholds::{CROWD, INLIER, NEAR};

/// Counts of correspondences (whole numbers) and sums over them. `V`: a number, or one per lane during a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ResidualStats<V> {
    /// Correspondences in front of both cameras.
    pub(crate) usable: V,
    /// Correspondences behind a camera.
    pub(crate) skipped: V,
    /// Residuals within 2, 3, and 4 units of the loss.
    pub(crate) within: [V; 3],
    /// Residuals within 2 units of points clearly in front of the cameras, and clearly behind them.
    pub(super) sides: [V; 2],
    /// Residuals beyond 2 units of the loss, up to [`CROWD`]: positive less negative ones.
    pub(super) leaning: V,
    /// Estimates of the noise variance from the residuals within 2 units, summed, px^2.
    pub(super) near_squares: V,
    /// Correspondences within Tukey's limit at the pose and in front of both cameras at the start.
    pub(crate) screened: V,
    /// Sums of their squared row offsets at start and pose, unit depth.
    pub(crate) squares: [V; 2],
    /// Residuals within 2 units and from 2 to 4, of correspondences of high leverage.
    pub(super) high_leverage: [V; 2],
    /// Sums of the truncated squared row offsets of all correspondences at start and pose, unit depth.
    pub(crate) cost: [V; 2],
}

/// Squared row offsets at the start and at the pose, unit depth.
pub(super) struct Compared<V, M> {
    pub(super) before: V,
    pub(super) after: V,
    /// In front of both cameras at the start.
    pub(super) in_front_before: M,
    /// Limit of the truncated cost, squared row offset.
    pub(super) most: V,
    /// Within Tukey's limit at the pose.
    pub(super) fit: M,
}

impl<V: Copy> ResidualStats<V> {
    /// Statistics of no correspondences.
    ///
    /// * `zero`: 0 in every lane.
    pub(super) const fn none(zero: V) -> Self {
        Self {
            usable: zero,
            skipped: zero,
            within: [zero; 3],
            sides: [zero; 2],
            leaning: zero,
            near_squares: zero,
            screened: zero,
            squares: [zero; 2],
            high_leverage: [zero; 2],
            cost: [zero; 2],
        }
    }
}

impl<V: Value> ResidualStats<V> {
    /// Counts residuals of correspondences in front of both cameras.
    ///
    /// * `value`: the constraint, of the sign of the residual; `squared`: squared whitened residual, px^2.
    /// * `disparity`: disparity, and the smallest one, below zero, that noise explains.
    #[inline(always)]
    pub(super) fn count<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        in_front: L::Mask,
        [value, squared]: [V; 2],
        disparity: [V; 2],
        expected: &ResidualVariance<V>,
    ) {
        let [zero, one] = [T::ZERO, T::ONE].map(|x| lanes.splat(x));
        self.usable = self.usable + lanes.keep(in_front, one);
        let within = |units| lanes.and(in_front, expected.is_within(lanes, units, squared));
        let seen = within(CROWD);
        if !lanes.any(seen) {
            return;
        }
        let near = within(NEAR);
        let [two, three, four] = &mut self.within;
        // In two branches: on one lane only the sums of one are touched.
        if lanes.any(near) {
            let count = lanes.keep(near, one);
            (*two, *three, *four) = (*two + count, *three + count, *four + count);
            let of_noise = expected.noise_squared(lanes, squared);
            self.near_squares = self.near_squares + lanes.keep(near, of_noise);
            let ([ahead, behind], [disparity, least]) = (&mut self.sides, disparity);
            *ahead = *ahead + lanes.keep(lanes.and(near, lanes.ge(disparity, zero - least)), one);
            *behind = *behind + lanes.keep(lanes.and(near, lanes.lt(disparity, least)), one);
        }
        let limit = expected.limit_squared(lanes.splat(T::lit(NEAR * NEAR)));
        let beside = lanes.and(seen, lanes.ge(squared, limit));
        if lanes.any(beside) {
            let side = lanes.select(lanes.lt(value, zero), zero - one, one);
            self.leaning = self.leaning + lanes.keep(beside, side);
            let among = |units| lanes.keep(lanes.and(beside, within(units)), one);
            (*three, *four) = (*three + among(INLIER), *four + among(BESIDE));
        }
    }

    /// Adds the row offsets at start and pose of correspondences in front of both cameras at the pose.
    #[inline(always)]
    pub(super) fn compare<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        in_front: L::Mask,
        compared: &Compared<V, L::Mask>,
    ) {
        let Compared { before, after, in_front_before, most, fit } = *compared;
        let small_before = lanes.and(in_front_before, lanes.lt(before, most));
        let small_after = lanes.lt(after, most);
        let [cost_before, cost_after] = &mut self.cost;
        let of_before = lanes.select(small_before, before, most);
        *cost_before = *cost_before + lanes.keep(in_front, of_before);
        let of_after = lanes.select(small_after, after, most);
        *cost_after = *cost_after + lanes.keep(in_front, of_after);
        let screened = lanes.and(in_front, lanes.and(in_front_before, fit));
        if !lanes.any(screened) {
            return;
        }
        self.screened = self.screened + lanes.keep(screened, lanes.splat(T::ONE));
        let [squares_before, squares_after] = &mut self.squares;
        *squares_before = *squares_before + lanes.keep(screened, before);
        *squares_after = *squares_after + lanes.keep(screened, after);
    }

    /// Adds the sums over all lanes to `to`.
    #[inline(always)]
    pub(super) fn reduce_onto<T: Scalar>(
        &self,
        lanes: impl Lanes<T, Value = V>,
        to: &mut ResidualStats<T>,
    ) {
        let sums = [&self.usable, &self.leaning, &self.near_squares, &self.screened].into_iter();
        let to_sums = [&mut to.usable, &mut to.leaning, &mut to.near_squares, &mut to.screened];
        let to_sums = to_sums.into_iter();
        let sums = sums.chain(&self.within).chain(&self.squares).chain(&self.cost);
        let to_sums = to_sums.chain(&mut to.within).chain(&mut to.squares).chain(&mut to.cost);
        let sums = sums.chain(&self.high_leverage).chain(&self.sides);
        let to_sums = to_sums.chain(&mut to.high_leverage).chain(&mut to.sides);
        for (to, sum) in to_sums.zip(sums) {
            *to += lanes.reduce(*sum);
        }
    }
}

impl<T: Scalar> ResidualStats<T> {
    /// Residuals within 2 units.
    pub(super) fn near(&self) -> T {
        let [near, _, _] = self.within;
        near
    }

    /// Residuals from 2 to 4 units.
    pub(super) fn beside(&self) -> T {
        let [near, _, around] = self.within;
        around - near
    }

    /// Share of the usable correspondences that are in a crowd beside the peak, with the sign of its side.
    pub(super) fn crowd(&self) -> T {
        self.leaning / self.usable.max(T::ONE)
    }

    /// Whether too many points that fit are behind the cameras.
    pub(super) fn is_behind(&self) -> bool {
        is_behind(self.sides)
    }

    /// Share of the usable correspondences within 3 units.
    pub(super) fn inlier_share(&self) -> T {
        let [_, inliers, _] = self.within;
        inliers / self.usable.max(T::ONE)
    }

    /// Whether the near residuals exceed those beside by `deviations` of chance. A flat background fills both bands
    /// alike, and the variance of the difference is the sum of the counts.
    pub(super) fn exceeds_background(&self, deviations: f64) -> bool {
        let (near, beside) = (self.near(), self.beside());
        near - beside >= T::lit(deviations) * (near + beside).sqrt()
    }
}
