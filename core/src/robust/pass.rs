//! The sums of one pass, and the leverage that they hold against single correspondences.

use nalgebra::{Matrix2, Matrix5, Vector2};

use crate::quadratic::Quadratic;
use crate::scalar::Scalar;

/// Information on the baseline that a correspondence may carry, in mean shares.
const MAX_SHARE: f64 = 8.0;

/// The same in squares of the mean root, which mismatches can hardly move.
const MAX_ROOTS: f64 = 5.0;

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
    /// Roots of the shares of information, by the prior's covariance.
    pub(super) roots: T,
}

impl<T: Scalar> Pass<T> {
    pub(super) const EMPTY: Self = Self {
        capped: Quadratic::ZERO,
        usable: 0,
        weighted: 0,
        near: 0,
        near_squares: T::ZERO,
        roots: T::ZERO,
    };

    pub(super) fn merge(&mut self, other: &Self) {
        self.capped.add(&other.capped);
        self.usable = self.usable.saturating_add(other.usable);
        self.weighted = self.weighted.saturating_add(other.weighted);
        self.near = self.near.saturating_add(other.near);
        self.near_squares += other.near_squares;
        self.roots += other.roots;
    }
}

/// What a correspondence's share of the information on the baseline is judged by: sums of the pass
/// before. Its share of that on `R` is bounded by the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leverage<T> {
    covariance: Matrix2<T>,
    limit: T,
}

impl<T: Scalar> Leverage<T> {
    /// * `covariance`: of the pose, from the sums as held down and the prior.
    /// * `now`, `next`: variance that residuals are weighed by in this pass and the next, px^2.
    pub(super) fn of(pass: &Pass<T>, covariance: &Matrix5<T>, now: T, next: T) -> Option<Self> {
        let covariance = of_baseline(covariance);
        let sum = covariance.dot(&of_baseline(&pass.capped.information.matrix()));
        let limit = T::lit(MAX_SHARE) * sum / T::count(pass.weighted.max(1));
        limit.is_finite().then_some(Self { covariance: covariance * (next / now), limit })
    }

    /// From the first pass of a track, before anything has been held down.
    ///
    /// * `covariance`: of the pose before that pass.
    pub(super) fn first(pass: &Pass<T>, covariance: &Matrix5<T>) -> Option<Self> {
        let mean = pass.roots / T::count(pass.weighted.max(1));
        let limit = T::lit(MAX_ROOTS) * mean * mean;
        limit.is_finite().then_some(Self { covariance: of_baseline(covariance), limit })
    }

    /// The weight that is left of `w`: falling with the square of the excess.
    pub(super) fn hold_down(&self, w: T, j: &[T; 5]) -> T {
        let share = share(&self.covariance, w, j);
        if share <= self.limit {
            w
        } else {
            let excess = self.limit / share;
            w * excess * excess
        }
    }
}

/// The baseline's part of a covariance or an information.
pub(super) fn of_baseline<T: Scalar>(m: &Matrix5<T>) -> Matrix2<T> {
    m.fixed_view::<2, 2>(3, 3).into_owned()
}

/// Information on the baseline that a row of weight `w` carries, in units of what is known of it.
///
/// * `covariance`: of the baseline.
pub(super) fn share<T: Scalar>(covariance: &Matrix2<T>, w: T, jacobian: &[T; 5]) -> T {
    let [_, _, _, y, z] = *jacobian;
    let j = Vector2::new(y, z);
    w * j.dot(&(covariance * j))
}
