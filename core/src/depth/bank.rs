//! A bank of filters for a mount that rests, drifts or is knocked (`ESTIMATOR.md`, section 20).
//!
//! The apparent yaw of the lens is constant, and the yaw of the mount walks. How far it walks from pair to pair differs
//! by orders of magnitude, and nothing but the pairs tells it. Each member assumes one walk. The members are weighted
//! by how well they predict the pairs, and mix with a fixed probability, because a mount at rest may begin to move: an
//! interacting multiple model (Bar-Shalom, Li, Kirubarajan, section 11.6).

use core::array;

use super::yaw::{Measured, YawEstimate};
use crate::scalar::Scalar;
use crate::thresholds::{MOUNT_CHANGES, MOUNT_WALKS_RAD};

/// Number of members.
const MEMBERS: usize = MOUNT_WALKS_RAD.len();

/// Filters with the walks [`MOUNT_WALKS_RAD`], each with its weight. The sum of the weights is 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bank<T>([(T, YawEstimate<T>); MEMBERS]);

impl<T: Scalar> Bank<T> {
    /// Returns a bank for a mount that may rest or move, with the same estimate in all members.
    pub(super) fn of(yaw: YawEstimate<T>) -> Self {
        Self([(even(), yaw); MEMBERS])
    }

    /// Returns a bank for a mount that rests, with the same estimate in all members.
    pub(super) fn at_rest(yaw: YawEstimate<T>) -> Self {
        let mut bank = Self::of(yaw);
        bank.0.iter_mut().for_each(|(weight, _)| *weight = T::ZERO);
        bank.0.iter_mut().take(1).for_each(|(weight, _)| *weight = T::ONE);
        bank
    }

    /// Returns mean and covariance over all members.
    pub(super) fn estimate(&self) -> YawEstimate<T> {
        YawEstimate::mixture(&self.0)
    }

    /// Returns the variance of the yaw of the rows, rad^2, if the mount rests.
    pub(super) fn var_at_rest(&self) -> T {
        self.0.iter().map(|(_, yaws)| yaws.var_rows()).fold(T::INFINITY, T::min)
    }

    /// Lets the mount walk, and adds the yaw of the rows of one more pair, rad, with its variance, rad^2.
    #[inline(never)]
    pub(super) fn add_rows(&mut self, yaw: T, variance: T) {
        let Self(old) = *self;
        let change = T::lit(MOUNT_CHANGES);
        let mut walks = MOUNT_WALKS_RAD.iter();
        for (i, member) in self.0.iter_mut().enumerate() {
            // Weight of the mounts that have walked so before, or begin to walk so now.
            let share = |(j, (weight, _)): (usize, &(T, _))| {
                *weight * if i == j { T::ONE - change } else { change * even() }
            };
            let mut shares = old.iter().enumerate().map(share);
            let shares: [T; MEMBERS] = array::from_fn(|_| shares.next().unwrap_or(T::ZERO));
            let total = shares.iter().fold(T::ZERO, |sum, share| sum + *share);
            let mut parts = old;
            parts.iter_mut().zip(shares).for_each(|(part, share)| part.0 = share / total);
            let walk = T::lit(walks.next().copied().unwrap_or(0.0));
            *member = (total, YawEstimate::mixture(&parts).turned(walk * walk));
        }
        self.add(Measured::Rows, yaw, variance);
    }

    /// Adds a measurement of a yaw, rad, with its variance, rad^2: updates each member, and weights it by the
    /// probability density of the measurement.
    pub(super) fn add(&mut self, of: Measured, yaw: T, variance: T) {
        let squared = |yaws: &YawEstimate<T>| {
            let (off, total) = yaws.innovation(of, yaw, variance);
            off * off / total
        };
        let least = self.0.iter().map(|(_, yaws)| squared(yaws)).fold(T::INFINITY, T::min);
        let mut sum = T::ZERO;
        for (weight, yaws) in &mut self.0 {
            let (_, total) = yaws.innovation(of, yaw, variance);
            // Relative to the member that predicts best, so that one weight is above 0 in `f32`, too.
            *weight *= ((least - squared(yaws)) * T::HALF).exp() / total.sqrt();
            sum += *weight;
            *yaws = yaws.with(of, yaw, variance);
        }
        // The member that predicts best may have had no weight. Then nothing tells the members apart.
        let is_known = sum > T::ZERO;
        let weight_of = |weight: T| if is_known { weight / sum } else { even() };
        self.0.iter_mut().for_each(|(weight, _)| *weight = weight_of(*weight));
    }

    /// Changes the estimate of each member.
    pub(super) fn map(&mut self, change: impl Fn(&YawEstimate<T>) -> YawEstimate<T>) {
        self.0.iter_mut().for_each(|(_, yaws)| *yaws = change(yaws));
    }
}

/// Returns the same share for each member.
fn even<T: Scalar>() -> T {
    MOUNT_WALKS_RAD.iter().fold(T::ZERO, |sum, _| sum + T::ONE).recip()
}

#[cfg(test)]
mod tests;
