//! A pass over the batch at one pose, on the way to another: sums, or only a look at what is usual.

use super::constraint::Constraint;
use super::leverage::{Leverage, of_baseline, share};
use super::weighing::{Counts, Loss, Weighed, Weighing, following};
use super::weight::{Spread, geman_mcclure};
use super::{Descent, Stage};
use crate::batch::Matches;
use crate::correspondence::RayPair;
use crate::lanes::{Four, Lanes, Single};
use crate::quadratic::Quadratic;
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;

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
    pub(super) fn of(counts: &Counts<T>, capped: Quadratic<T>) -> Self {
        let Counts { usable, weighted, near, near_squares } = *counts;
        let [usable, weighted, near] = [usable, weighted, near].map(|count| count.to_u16().into());
        Self { capped, usable, weighted, near, near_squares }
    }
}

impl<T: Scalar> Pass<T> {
    /// The sums of two parts of a batch.
    #[cfg(feature = "simd")]
    pub(super) fn plus(self, other: &Self) -> Self {
        Self {
            capped: self.capped.plus(&other.capped),
            usable: self.usable.saturating_add(other.usable),
            weighted: self.weighted.saturating_add(other.weighted),
            near: self.near.saturating_add(other.near),
            near_squares: self.near_squares + other.near_squares,
        }
    }
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
        let by = self.weighing(Single);
        let [mut roots, mut weighted] = [T::ZERO; 2];
        for pair in spread_over(pairs, SURVEYED) {
            let (constraint, in_front) = Constraint::of(Single, &by.frame, pair.rays());
            if !in_front || !constraint.has_disparity(Single, by.min_disparity) {
                continue;
            }
            let precision = by.focal_squared / constraint.variance;
            let spread = Spread::of(Single, by.noise_squared, pair.grid_step());
            let x = following(Single, &covariance.0, &constraint, precision, &spread);
            let w = geman_mcclure(Single, x) / spread.variance;
            roots += share(Single, &of_baseline, w * precision, &constraint.jacobian).sqrt();
            weighted += T::ONE;
        }
        Leverage::first(roots / weighted.max(T::ONE), covariance)
    }

    /// * `most`: correspondences to look at.
    #[inline(never)]
    pub(super) fn pass(&self, matches: Matches<'_, T>, most: usize) -> Pass<T> {
        #[cfg(feature = "simd")]
        if matches.pairs.len() <= most
            && let Some(pass) = self.pass_side_by_side(matches)
        {
            return pass;
        }
        if Four::AT_ONCE {
            self.pass_in_fours(matches.pairs, most)
        } else {
            self.pass_one_by_one(matches.pairs, most)
        }
    }

    pub(super) fn pass_one_by_one(&self, pairs: &[RayPair<T>], most: usize) -> Pass<T> {
        self.pass_onward(spread_over(pairs, most), Counts::zero(Single), Quadratic::ZERO)
    }

    /// * `counts`, `capped`: of those before.
    #[inline(always)]
    pub(super) fn pass_onward<'a>(
        &self,
        pairs: impl Iterator<Item = &'a RayPair<T>>,
        mut counts: Counts<T>,
        mut capped: Quadratic<T>,
    ) -> Pass<T> {
        let by = self.weighing(Single);
        for pair in pairs {
            let weighed = counts.weigh(Single, &by, pair.rays(), pair.grid_step());
            if let Some(Weighed { weight, value, jacobian }) = weighed {
                capped.add_row(weight, value, &jacobian);
            }
        }
        Pass::of(&counts, capped)
    }

    #[inline(always)]
    pub(super) fn weighing<L: Lanes<T>>(&self, lanes: L) -> Weighing<L::Value> {
        let loss = match &self.stage {
            Stage::Anneal(scale) => Loss::Anneal(lanes.all(T::ONE / (*scale * *scale))),
            Stage::Follow(covariance) => Loss::Follow(covariance.0.map(|c| lanes.all(c))),
            Stage::Polish => Loss::Polish,
        };
        self.at.weighing(lanes, loss)
    }
}

/// At most so many of the correspondences, evenly spread over the batch.
pub(super) fn spread_over<T>(
    pairs: &[RayPair<T>],
    most: usize,
) -> impl Iterator<Item = &RayPair<T>> {
    let stride = pairs.len().div_ceil(most.max(1)).max(1);
    pairs.iter().step_by(stride)
}
