//! What a judgement counts, and compares with the start: sums for each lane.

use super::tally::Tally;
use super::weight::Spread;
use crate::lanes::{Lanes, Value};
use crate::scalar::Scalar;

/// As [`Tally`], whose counts are sums of ones here.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tallies<V> {
    usable: V,
    within: [V; 3],
    near_squares: V,
    screened: V,
    squares: [V; 2],
    cost: [V; 2],
}

/// Squared row offsets of correspondences at the start and at the pose, unit depth.
pub(super) struct Compared<V, M> {
    pub(super) before: V,
    pub(super) after: V,
    /// Whether they are in front of both cameras at the start.
    pub(super) in_front_before: M,
    /// Beyond which they cost no more.
    pub(super) most: V,
    /// Whether they fit the pose.
    pub(super) fit: M,
}

impl<V: Value> Tallies<V> {
    #[inline(always)]
    pub(super) fn zero<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let zero = lanes.all(T::ZERO);
        Self {
            usable: zero,
            within: [zero; 3],
            near_squares: zero,
            screened: zero,
            squares: [zero; 2],
            cost: [zero; 2],
        }
    }

    /// Those in front of both cameras.
    ///
    /// * `squared`: of the whitened residual, px^2.
    #[inline(always)]
    pub(super) fn count<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        in_front: L::Mask,
        squared: V,
        spread: &Spread<V>,
    ) {
        let one = lanes.all(T::ONE);
        self.usable = self.usable + lanes.keep(in_front, one);
        let within = |units| lanes.both(in_front, spread.is_within(lanes, T::lit(units), squared));
        let around = within(4.0);
        if !lanes.is_any(around) {
            return;
        }
        let near = within(2.0);
        let [two, three, four] = &mut self.within;
        *two = *two + lanes.keep(near, one);
        *three = *three + lanes.keep(within(3.0), one);
        *four = *four + lanes.keep(around, one);
        let of_noise = spread.noise_squared(lanes, squared);
        self.near_squares = self.near_squares + lanes.keep(near, of_noise);
    }

    /// Those in front of both cameras at the pose, with the start.
    #[inline(always)]
    pub(super) fn compare<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        in_front: L::Mask,
        compared: &Compared<V, L::Mask>,
    ) {
        let Compared { before, after, in_front_before, most, fit } = *compared;
        let small_before = lanes.both(in_front_before, lanes.below(before, most));
        let small_after = lanes.below(after, most);
        let [cost_before, cost_after] = &mut self.cost;
        let of_before = lanes.choose(small_before, before, most);
        *cost_before = *cost_before + lanes.keep(in_front, of_before);
        let of_after = lanes.choose(small_after, after, most);
        *cost_after = *cost_after + lanes.keep(in_front, of_after);
        let screened = lanes.both(in_front, lanes.both(in_front_before, fit));
        self.screened = self.screened + lanes.keep(screened, lanes.all(T::ONE));
        let [squares_before, squares_after] = &mut self.squares;
        *squares_before = *squares_before + lanes.keep(screened, before);
        *squares_after = *squares_after + lanes.keep(screened, after);
    }
}

impl<T: Scalar> Tally<T> {
    /// The counts of all lanes together.
    ///
    /// * `seen`: correspondences in them, in front of the cameras or not.
    #[inline(always)]
    pub(super) fn of<L: Lanes<T>>(lanes: L, seen: u32, counts: &Tallies<L::Value>) -> Self {
        let count = |sum: T| u32::from(sum.to_u16());
        let usable = count(lanes.total(counts.usable));
        Self {
            usable,
            skipped: seen.saturating_sub(usable),
            within: lanes.totals(&counts.within).map(count),
            near_squares: lanes.total(counts.near_squares),
            screened: count(lanes.total(counts.screened)),
            squares: lanes.totals(&counts.squares),
            cost: lanes.totals(&counts.cost),
        }
    }

    /// The counts of two parts of a batch.
    #[cfg(feature = "simd")]
    pub(super) fn plus(&self, other: &Self) -> Self {
        let ([a, b, c], [d, e, f]) = (self.within, other.within);
        let sums = |[a, b]: [T; 2], [c, d]: [T; 2]| [a + c, b + d];
        Self {
            usable: self.usable + other.usable,
            skipped: self.skipped + other.skipped,
            within: [a + d, b + e, c + f],
            near_squares: self.near_squares + other.near_squares,
            screened: self.screened + other.screened,
            squares: sums(self.squares, other.squares),
            cost: sums(self.cost, other.cost),
        }
    }
}
