//! The pass that judges a pose: what the batch says there, and whether it says anything at all.

use nalgebra::Vector3;

use super::weight::Spread;
use super::{Descent, NOISE_PX, TRUNCATED_VARIANCE, TUKEY};
use crate::correspondence::RayPair;
use crate::information::{BLOCK, Information};
use crate::moments::Moments;
use crate::quadratic::Quadratic;
use crate::rectification::RectifyingRotations;
use crate::residual::row_offset;
use crate::scalar::Scalar;
use crate::whitening::whitened;

/// Share of the correspondences that must fit a pose found from afar.
const MIN_INLIERS: f64 = 0.15;

/// What one batch says of the extrinsics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Evidence<T: Scalar> {
    /// Where the batch was judged: the frame of the moments.
    pub(crate) pose: RectifyingRotations<T>,
    pub(crate) moments: Moments<T>,
    /// Of the whole image, of its left and of its upper half, about the pose.
    pub(crate) parts: [Quadratic<T>; 3],
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Share of the usable correspondences within 3 standard deviations.
    pub(crate) share: T,
}

/// A judged pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Judged<T: Scalar> {
    pub(crate) evidence: Evidence<T>,
    /// Whether disparities are more than noise.
    pub(crate) speaks_of_baseline: bool,
    pub(crate) usable: u32,
    pub(crate) skipped: u32,
    /// Residuals within 2, and from 2 to 4 standard deviations.
    pub(crate) near: u32,
    pub(crate) beside: u32,
    /// Correspondences that fit, and sums of their squared row offsets at start and pose, px^2.
    pub(crate) screened: u32,
    pub(crate) squares: [T; 2],
    /// Of the row offsets of all correspondences, each cut off at Tukey's limit, px^2.
    pub(crate) cost: [T; 2],
}

/// Sums of a block of correspondences.
#[derive(Debug, Clone, Copy)]
struct Block<T> {
    moments: Moments<T>,
    parts: [Quadratic<T>; 3],
    /// Of the weights, 1/px^2, and of the weights times their variances.
    weights: [T; 2],
}

impl<T: Scalar> Descent<T> {
    /// Judges the pose reached, in one pass; `None` if the sums are not finite.
    pub(crate) fn judge(&self, pairs: &[RayPair<T>]) -> Option<Judged<T>> {
        let mut judged = Judged::empty(self.pose);
        let mut total = Block::EMPTY;
        let [mut within, mut near_squares] = [T::ZERO; 2];
        for block in pairs.chunks(BLOCK) {
            let mut sums = Block::EMPTY;
            for pair in block {
                let Some((r, spread)) = self.judge_one(pair, &mut judged, &mut sums) else {
                    continue;
                };
                if spread.is_within(T::lit(3.0), r) {
                    within += T::ONE;
                }
                if spread.is_within(T::lit(2.0), r) {
                    judged.near = judged.near.saturating_add(1);
                    near_squares += r * r / T::lit(TRUNCATED_VARIANCE) - spread.of_grid;
                } else if spread.is_within(T::lit(4.0), r) {
                    judged.beside = judged.beside.saturating_add(1);
                }
            }
            total.merge(&sums);
        }
        let noise = self.noise_of(near_squares, judged.near);
        let [weights, variances] = total.weights;
        let unit_depth = self.focal * self.focal;
        let variance = variances / weights.max(T::EPSILON) / unit_depth;
        let [all, _, _] = &total.parts;
        total.moments.set_gradient(&self.pose, &all.gradient.into());
        judged.evidence.moments = total.moments;
        judged.evidence.parts = total.parts;
        judged.evidence.noise = noise;
        judged.evidence.share = within / T::count(judged.usable.max(1));
        judged.speaks_of_baseline = total.moments.speaks_of_baseline(&self.pose, variance);
        (total.moments.is_finite() && noise.is_finite()).then_some(judged)
    }

    /// Adds one correspondence; its whitened residual and expected spread.
    fn judge_one(
        &self,
        pair: &RayPair<T>,
        judged: &mut Judged<T>,
        sums: &mut Block<T>,
    ) -> Option<(T, Spread<T>)> {
        let Some(row) = whitened(&self.pose, self.pose.gauge_slope(), self.focal, pair) else {
            judged.skipped = judged.skipped.saturating_add(1);
            return None;
        };
        judged.usable = judged.usable.saturating_add(1);
        let spread = Spread::of(self.noise, pair.grid_step());
        let r = row.row.offset;
        let limit = T::lit(TUKEY) * spread.unit_squared.sqrt();
        let cut = |px: T| (px * px).min(T::lit(2.0) * limit * limit);
        let before = row_offset(&self.start, pair).map(|offset| offset * self.focal);
        let [cost_before, cost_after] = &mut judged.cost;
        *cost_before += before.map_or(T::lit(2.0) * limit * limit, cut);
        *cost_after += cut(row.offset_px);
        if let Some(before) = before
            && r.abs() <= limit
        {
            judged.screened = judged.screened.saturating_add(1);
            let [squares_before, squares_after] = &mut judged.squares;
            *squares_before += before * before;
            *squares_after += row.offset_px * row.offset_px;
        }
        let w = self.polished(&row, &spread)?;
        if w > T::ZERO {
            let j = &row.row.jacobian;
            let w = self.leverage.as_ref().map_or(w, |leverage| leverage.hold_down(w, j));
            let [x_l, y_l] = pair.left();
            let [all, left, top] = &mut sums.parts;
            all.add_row(w, r, j);
            if x_l < T::ZERO {
                left.add_row(w, r, j);
            }
            if y_l < T::ZERO {
                top.add_row(w, r, j);
            }
            let ray = |[x, y]: [T; 2]| Vector3::new(x, y, T::ONE);
            let [a, b] =
                [self.pose.left() * ray(pair.left()), self.pose.right() * ray(pair.right())];
            sums.moments.add_rays(w * row.per_constraint * row.per_constraint, &a, &b);
            let [weights, variances] = &mut sums.weights;
            *weights += w;
            *variances += w * spread.variance;
        }
        Some((r, spread))
    }
}

impl<T: Scalar> Judged<T> {
    fn empty(pose: RectifyingRotations<T>) -> Self {
        let evidence = Evidence {
            pose,
            moments: Moments::ZERO,
            parts: [Quadratic::ZERO; 3],
            noise: T::ZERO,
            share: T::ZERO,
        };
        Self {
            evidence,
            speaks_of_baseline: false,
            usable: 0,
            skipped: 0,
            near: 0,
            beside: 0,
            screened: 0,
            squares: [T::ZERO; 2],
            cost: [T::ZERO; 2],
        }
    }

    /// Whether a pose found from afar is one: the residuals gather at zero. Mismatches have about as
    /// many within two standard deviations as from two to four, and let the scale grow.
    ///
    /// * `needed`: correspondences, by configuration.
    pub(crate) fn is_found(&self, needed: u32) -> bool {
        let near = T::count(self.near);
        self.near >= needed
            && near >= T::lit(2.0) * T::count(self.beside)
            && near >= T::lit(MIN_INLIERS) * T::count(self.usable)
            && self.stands_out(T::lit(3.0))
            && self.evidence.noise < T::lit(NOISE_PX[0])
    }

    /// Whether the residuals at a pose that is known already gather at zero.
    pub(crate) fn has_peak(&self) -> bool {
        self.near >= 8 && T::count(self.near) >= T::lit(1.5) * T::count(self.beside)
    }

    /// Whether they do so by more than chance: what a pose must show that is not yet known.
    pub(crate) fn has_clear_peak(&self) -> bool {
        self.stands_out(T::lit(2.0))
    }

    /// Whether more residuals are near zero than beside by so many deviations of chance, which counts
    /// both alike.
    fn stands_out(&self, deviations: T) -> bool {
        let [near, beside] = [self.near, self.beside].map(T::count);
        near - beside >= deviations * (near + beside).sqrt()
    }
}

impl<T: Scalar> Block<T> {
    const EMPTY: Self =
        Self { moments: Moments::ZERO, parts: [Quadratic::ZERO; 3], weights: [T::ZERO; 2] };

    fn merge(&mut self, other: &Self) {
        self.moments.add(&other.moments);
        self.parts.iter_mut().zip(&other.parts).for_each(|(a, b)| a.add(b));
        self.weights.iter_mut().zip(&other.weights).for_each(|(a, b)| *a += *b);
    }
}

impl<T: Scalar> Evidence<T> {
    /// Information and slope at a pose.
    pub(crate) fn seen_at(&self, pose: &RectifyingRotations<T>) -> Quadratic<T> {
        self.moments.seen_at(&self.pose, pose)
    }

    /// The pair's own optimum, with a weak prior about where it was judged, and the information there.
    pub(crate) fn optimum(
        &self,
        prior: &Information<T>,
    ) -> Option<(RectifyingRotations<T>, Information<T>)> {
        let d = self.seen_at(&self.pose).with(prior).step()?;
        let pose = self.pose.stepped_by(&d)?;
        Some((pose, self.seen_at(&pose).information))
    }
}
