//! The sums of one pass, and the leverage that they hold against single correspondences.

use nalgebra::{Matrix5, Vector5};

use crate::information::Information;
use crate::scalar::Scalar;

/// Information a correspondence may carry, in mean shares.
const MAX_SHARE: f64 = 4.0;

/// Sums of one pass over the batch at one pose.
#[derive(Debug, Clone)]
pub(super) struct Pass<T> {
    /// Of `w J J^T` with high leverage held down, and as it is.
    pub(super) capped: Information<T>,
    pub(super) uncapped: Information<T>,
    pub(super) gradient: [T; 5],
    pub(super) usable: u32,
    pub(super) skipped: u32,
    /// Correspondences with a weight at all, and the sum of the weights as held down.
    pub(super) weighted: u32,
    pub(super) weight: T,
    /// Residuals within 2, and from 2 to 4 standard deviations.
    pub(super) near: u32,
    pub(super) beside: u32,
    pub(super) near_squares: T,
}

impl<T: Scalar> Pass<T> {
    pub(super) const EMPTY: Self = Self {
        capped: Information::ZERO,
        uncapped: Information::ZERO,
        gradient: [T::ZERO; 5],
        usable: 0,
        skipped: 0,
        weighted: 0,
        weight: T::ZERO,
        near: 0,
        beside: 0,
        near_squares: T::ZERO,
    };

    pub(super) fn merge(&mut self, other: &Self) {
        self.capped.add(&other.capped);
        self.uncapped.add(&other.uncapped);
        for (sum, g) in self.gradient.iter_mut().zip(&other.gradient) {
            *sum += *g;
        }
        self.usable = self.usable.saturating_add(other.usable);
        self.skipped = self.skipped.saturating_add(other.skipped);
        self.weighted = self.weighted.saturating_add(other.weighted);
        self.weight += other.weight;
        self.near = self.near.saturating_add(other.near);
        self.beside = self.beside.saturating_add(other.beside);
        self.near_squares += other.near_squares;
    }
}

/// What a correspondence's share of the information is judged by: sums of the pass before.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leverage<T> {
    covariance: Matrix5<T>,
    limit: T,
}

impl<T: Scalar> Leverage<T> {
    /// From the sums of a pass; `prior` in their unit.
    pub(super) fn of(pass: &Pass<T>, prior: T) -> Option<Self> {
        let covariance = pass.uncapped.plus_diagonal(prior).covariance()?;
        // The shares add up to the trace: 5 where the prior is weak.
        let sum = covariance.dot(&pass.uncapped.matrix());
        let limit = T::lit(MAX_SHARE) * sum / T::count(pass.weighted.max(1));
        limit.is_finite().then_some(Self { covariance, limit })
    }

    /// The weight that is left of `w`: falling with the square of the excess.
    pub(super) fn hold_down(&self, w: T, j: &[T; 5]) -> T {
        let j = Vector5::from(*j);
        let share = w * j.dot(&(self.covariance * j));
        if share <= self.limit {
            w
        } else {
            let excess = self.limit / share;
            w * excess * excess
        }
    }
}
