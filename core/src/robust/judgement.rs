//! The pass that judges a pose: what the batch says there, and whether it says anything at all.

use nalgebra::Vector5;

use super::weight::Spread;
use super::{NOISE_PX, Outlook, TRUNCATED_VARIANCE, TUKEY};
use crate::correspondence::RayPair;
use crate::error::PairError;
use crate::moments::Moments;
use crate::quadratic::{Quadratic, add_pull};
use crate::rectification::RectifyingRotations;
use crate::residual::{Row, Sight, row_offset};
use crate::scalar::Scalar;
use crate::whitening::Whitening;

/// Share of the correspondences that must fit a pose found from afar.
const MIN_INLIERS: f64 = 0.15;

/// What one batch says of the extrinsics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Evidence<T: Scalar> {
    /// Where the batch was judged: the frame of the moments.
    pub(crate) pose: RectifyingRotations<T>,
    pub(crate) moments: Moments<T>,
    /// Of the left and of the upper half of the image, about the pose.
    pub(crate) halves: [Quadratic<T>; 2],
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

/// What is only counted.
#[derive(Debug, Clone, Copy)]
struct Tally<T> {
    usable: u32,
    skipped: u32,
    /// Residuals within 2, 3, and 4 standard deviations.
    within: [u32; 3],
    /// What of the squares of those within 2 is not the grid's, px^2.
    near_squares: T,
    screened: u32,
    /// Unit depth.
    squares: [T; 2],
    cost: [T; 2],
}

/// A correspondence that counts.
#[derive(Debug, Clone, Copy)]
struct Member<T> {
    /// 1/px^2.
    w: T,
    /// px^2, one over the variance of the offset where a coordinate's is 1 px^2.
    precision: T,
    row: Row<T>,
    sight: Sight<T>,
    /// Of a coordinate, px^2.
    variance: T,
}

impl<T: Scalar> Outlook<T> {
    /// Judges the pose, in one pass.
    ///
    /// * `judged`: of nothing yet; of no use after an error.
    ///
    /// # Errors
    /// [`PairError::TooFew`] in front of both cameras, [`PairError::Unobservable`] where the sums are
    /// not finite.
    #[inline(never)]
    pub(crate) fn judge(
        &self,
        pairs: &[RayPair<T>],
        judged: &mut Judged<T>,
    ) -> Result<(), PairError> {
        let mut tally = Tally::NONE;
        let mut gradient = Vector5::zeros();
        let mut weights = [T::ZERO; 2];
        let whitening = Whitening::at(&self.pose);
        let Evidence { pose, moments, halves: [left, upper], noise, share } = &mut judged.evidence;
        *pose = self.pose;
        for pair in pairs {
            if let Some(member) = self.judge_one(&whitening, pair, &mut tally) {
                let Member { w, precision, row, sight, variance } = &member;
                let precise = *w * *precision;
                let [x, y] = pair.left();
                if x < T::ZERO {
                    left.add_row(precise, row.offset, &row.jacobian);
                }
                if y < T::ZERO {
                    upper.add_row(precise, row.offset, &row.jacobian);
                }
                add_pull(&mut gradient, precise * row.offset, &row.jacobian);
                moments.add_sight(precise, sight);
                let [sum, variances] = &mut weights;
                *sum += *w;
                *variances += *w * *variance;
            }
        }
        let unit_depth = self.focal * self.focal;
        let [sum, variances] = weights;
        let variance = variances / (sum.max(T::EPSILON) * unit_depth);
        moments.set_gradient(&gradient);
        judged.speaks_of_baseline = moments.speaks_of_baseline(variance);
        let [near, within, around] = tally.within;
        *noise = self.noise_of(tally.near_squares, near);
        *share = T::count(within) / T::count(tally.usable.max(1));
        judged.usable = tally.usable;
        judged.skipped = tally.skipped;
        judged.near = near;
        judged.beside = around.saturating_sub(near);
        judged.screened = tally.screened;
        judged.squares = tally.squares.map(|sum| sum * unit_depth);
        judged.cost = tally.cost.map(|sum| sum * unit_depth);
        self.check(judged.usable)?;
        let finite = judged.evidence.moments.is_finite() && judged.evidence.noise.is_finite();
        if finite { Ok(()) } else { Err(PairError::Unobservable) }
    }

    /// Counts one correspondence; what it adds to the sums, if anything.
    #[inline(always)]
    fn judge_one(
        &self,
        whitening: &Whitening<T>,
        pair: &RayPair<T>,
        tally: &mut Tally<T>,
    ) -> Option<Member<T>> {
        let Some(sight) = Sight::of(&self.pose, pair) else {
            tally.skipped += 1;
            return None;
        };
        let spread = Spread::of(self.noise * self.noise, pair.grid_step());
        let row = whitening.row(&sight);
        let variance = whitening.variance(&sight);
        let precision = self.focal * self.focal / variance.value();
        let offset_squared = row.offset * row.offset;
        let squared = offset_squared * precision;
        tally.count(squared, &spread);
        let limit = T::lit(TUKEY * TUKEY) * spread.unit_squared;
        let before = row_offset(&self.start, pair).map(|offset| offset * offset);
        let most = T::lit(2.0) * limit / (self.focal * self.focal);
        tally.compare(before, offset_squared, most, squared <= limit);
        if sight.disparity() < self.min_disparity {
            return None;
        }
        let w = spread.tukey(squared);
        if !(w > T::ZERO) {
            return None;
        }
        let row = whitening.whole(&row, &sight, &variance);
        let w = w * self.left_of(w * precision, &row);
        Some(Member { w, precision, row, sight, variance: spread.variance })
    }
}

impl<T: Scalar> Tally<T> {
    const NONE: Self = Self {
        usable: 0,
        skipped: 0,
        within: [0; 3],
        near_squares: T::ZERO,
        screened: 0,
        squares: [T::ZERO; 2],
        cost: [T::ZERO; 2],
    };

    /// * `squared`: of a whitened residual, px^2.
    #[inline(always)]
    fn count(&mut self, squared: T, spread: &Spread<T>) {
        self.usable += 1;
        let [two, three, four] = &mut self.within;
        let unit = spread.unit_squared;
        if squared < T::lit(16.0) * unit {
            *four += 1;
            if squared < T::lit(9.0) * unit {
                *three += 1;
            }
            if squared < T::lit(4.0) * unit {
                *two += 1;
                self.near_squares += squared * T::lit(1.0 / TRUNCATED_VARIANCE) - spread.of_grid;
            }
        }
    }

    /// * `before`, `after`: squared row offsets at the start and at the pose, unit depth.
    /// * `most`: beyond which they cost no more.
    /// * `fits`: whether the correspondence fits the pose.
    #[inline(always)]
    fn compare(&mut self, before: Option<T>, after: T, most: T, fits: bool) {
        let cut = |squared: T| if squared < most { squared } else { most };
        let [cost_before, cost_after] = &mut self.cost;
        *cost_before += before.map_or(most, cut);
        *cost_after += cut(after);
        if let Some(before) = before
            && fits
        {
            self.screened += 1;
            let [squares_before, squares_after] = &mut self.squares;
            *squares_before += before;
            *squares_after += after;
        }
    }
}

impl<T: Scalar> Judged<T> {
    pub(crate) const NOTHING: Self = Self {
        evidence: Evidence {
            pose: RectifyingRotations::SIDE_BY_SIDE,
            moments: Moments::ZERO,
            halves: [Quadratic::ZERO; 2],
            noise: T::ZERO,
            share: T::ZERO,
        },
        speaks_of_baseline: false,
        usable: 0,
        skipped: 0,
        near: 0,
        beside: 0,
        screened: 0,
        squares: [T::ZERO; 2],
        cost: [T::ZERO; 2],
    };

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

impl<T: Scalar> Evidence<T> {
    /// Information and slope at a pose.
    pub(crate) fn seen_at(&self, pose: &RectifyingRotations<T>) -> Quadratic<T> {
        self.moments.seen_at(&self.pose, pose)
    }
}
