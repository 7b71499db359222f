//! The judgement of as many correspondences at a time as there are lanes.

use core::hint::black_box;

use pulp::{Simd, WithSimd};

use super::TUKEY;
use super::constraint::{Constraint, Frame};
use super::judgement::{Evidence, Heard};
use super::outlook::Outlook;
use super::side_by_side::{BLOCK, Sums};
use super::tallies::{Compared, Tallies};
use super::tally::Tally;
use super::weighing::{Loss, Weighed, Weighing};
use super::weight::Spread;
use crate::batch::Matches;
use crate::lanes::{Lanes, Value, dispatch};
use crate::moments::{Products, Seen};
use crate::scalar::Scalar;

/// The part of a batch that fills lanes.
struct Filling<'a, T: Scalar> {
    outlook: &'a Outlook<T>,
    matches: Matches<'a, T>,
    evidence: &'a mut Evidence<T>,
}

/// What correspondences are judged by.
struct Bench<V> {
    by: Weighing<V>,
    start: Frame<V>,
}

/// Sums for each lane.
struct Hearing<V> {
    tallies: Tallies<V>,
    /// Of the weights, and of the weights times the variance of a coordinate.
    weights: [V; 2],
    products: Products<V>,
    /// Of the left and of the upper half of the image.
    halves: [Sums<V>; 2],
    gradient: [V; 5],
}

/// Correspondences that are judged before they are summed.
struct Block<V> {
    rows: [Weighed<V>; BLOCK],
    seen: [Seen<V>; BLOCK],
    /// Weights in the left and in the upper half, zero in the other ones.
    halves: [[V; BLOCK]; 2],
}

impl<T: Scalar> Outlook<T> {
    /// As [`Outlook::hear_one_by_one`] over all, to rounding: sums are made in another order, and
    /// products are not rounded where the processor can add to them at once. One by one without lanes.
    pub(super) fn hear_side_by_side(
        &self,
        matches: Matches<'_, T>,
        evidence: &mut Evidence<T>,
    ) -> Heard<T> {
        let filled = dispatch(Filling { outlook: self, matches, evidence: &mut *evidence });
        let Some((heard, filled)) = filled else {
            return self.hear_one_by_one(matches.pairs, evidence);
        };
        let (_, rest) = matches.pairs.split_at(filled.min(matches.pairs.len()));
        heard.plus(&self.hear_one_by_one(rest, evidence))
    }
}

impl<T: Scalar> WithSimd for Filling<'_, T> {
    /// What they say, and how many they are.
    type Output = (Heard<T>, usize);

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> (Heard<T>, usize) {
        let Self { outlook, matches: Matches { pairs, columns }, evidence } = self;
        let lanes = T::wide(simd);
        // From memory a number comes with the operation; the compiler would copy it to all lanes anew.
        let bench = black_box(Bench {
            by: outlook.weighing(lanes, Loss::Polish),
            start: Frame::at(lanes, &outlook.start),
        });
        let (mut hearing, mut block) = (Hearing::zero(lanes), Block::empty(lanes));
        let chunks = |column| T::split::<S>(column).0.chunks(BLOCK);
        let [x_l, y_l, x_r, y_r] = columns.rays.map(chunks);
        let rows = x_l.zip(y_l).zip(x_r).zip(y_r).zip(chunks(columns.grid_step));
        for ((((x_l, y_l), x_r), y_r), steps) in rows {
            let Block { rows: weighed, seen, halves: [left, upper] } = &mut block;
            let places = weighed.iter_mut().zip(seen).zip(left).zip(upper);
            let rows = x_l.iter().zip(y_l).zip(x_r).zip(y_r).zip(steps);
            for ((((row, seen), left), upper), ((((x_l, y_l), x_r), y_r), step)) in places.zip(rows)
            {
                let rays = [x_l, y_l, x_r, y_r].map(|stored| T::load(simd, stored));
                (*row, *seen) = hearing.judge(lanes, &bench, rays, T::load(simd, step));
                let ([x, y, ..], zero) = (rays, lanes.all(T::ZERO));
                *left = lanes.keep(lanes.below(x, zero), row.weight);
                *upper = lanes.keep(lanes.below(y, zero), row.weight);
            }
            hearing.add(lanes, &block, x_l.len());
        }
        let (_, left_over) = T::split::<S>(columns.grid_step);
        let filled = pairs.len().saturating_sub(left_over.len());
        let seen = u32::try_from(filled).unwrap_or(u32::MAX);
        let heard = Heard {
            tally: Tally::of(lanes, seen, &hearing.tallies),
            gradient: lanes.totals(&hearing.gradient).into(),
            weights: lanes.totals(&hearing.weights),
        };
        evidence.moments.add_side_by_side(lanes, &hearing.products);
        for (half, sums) in evidence.halves.iter_mut().zip(&hearing.halves) {
            half.add(&sums.total(lanes));
        }
        (heard, filled)
    }
}

impl<V: Value> Hearing<V> {
    #[inline(always)]
    fn zero<T: Scalar, L: Lanes<T, Value = V>>(lanes: L) -> Self {
        let zero = lanes.all(T::ZERO);
        Self {
            tallies: Tallies::zero(lanes),
            weights: [zero; 2],
            products: Products::zero(lanes),
            halves: [Sums::zero(lanes), Sums::zero(lanes)],
            gradient: [zero; 5],
        }
    }

    /// Counts correspondences; what they add to the sums.
    #[inline(always)]
    fn judge<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        Bench { by, start }: &Bench<V>,
        rays: [V; 4],
        grid_step: V,
    ) -> (Weighed<V>, Seen<V>) {
        let (constraint, in_front) = Constraint::of(lanes, &by.frame, rays);
        let (at_start, in_front_before) = Constraint::of(lanes, start, rays);
        let spread = Spread::of(lanes, by.noise_squared, grid_step);
        let (value, offset) = (constraint.value, constraint.offset());
        let precision = by.precision(lanes, &constraint, in_front);
        let squared = value * value * precision;
        self.tallies.count(lanes, in_front, squared, &spread);
        let limit = lanes.all(T::lit(TUKEY * TUKEY)) * spread.unit_squared;
        let compared = Compared {
            before: at_start.offset() * at_start.offset(),
            after: offset * offset,
            in_front_before,
            most: lanes.all(T::lit(2.0)) * limit * by.unit_squared,
            fit: lanes.at_least(limit, squared),
        };
        self.tallies.compare(lanes, in_front, &compared);
        let counts = lanes.both(in_front, constraint.has_disparity(lanes, by.min_disparity));
        let w = lanes.keep(counts, spread.tukey(lanes, squared));
        let jacobian = constraint.whole(lanes, &by.frame, value * precision * by.unit_squared);
        let w = match &by.leverage {
            Some(leverage) => w * leverage.left_of(lanes, w * precision, &jacobian),
            None => w,
        };
        let [sum, variances] = &mut self.weights;
        *sum = *sum + w;
        *variances = lanes.mul_add(w, spread.variance, *variances);
        let weight = w * precision;
        let seen = Seen { weight, products: constraint.products(lanes) };
        (Weighed { weight, value, jacobian }, seen)
    }

    /// Adds the first so many of a block.
    #[inline(always)]
    fn add<T: Scalar>(&mut self, lanes: impl Lanes<T, Value = V>, block: &Block<V>, rows: usize) {
        self.products.add(lanes, block.seen.get(..rows).unwrap_or_default());
        let [mut a, mut b, mut c, mut d, mut e] = self.gradient;
        for Weighed { weight, value, jacobian: [j0, j1, j2, j3, j4] } in
            block.rows.iter().take(rows)
        {
            let pull = *weight * *value;
            a = lanes.mul_add(pull, *j0, a);
            b = lanes.mul_add(pull, *j1, b);
            c = lanes.mul_add(pull, *j2, c);
            d = lanes.mul_add(pull, *j3, d);
            e = lanes.mul_add(pull, *j4, e);
        }
        self.gradient = [a, b, c, d, e];
        for (sums, weights) in self.halves.iter_mut().zip(&block.halves) {
            let rows = block.rows.iter().zip(weights).take(rows);
            sums.add(lanes, rows.map(|(row, weight)| Weighed { weight: *weight, ..*row }));
        }
    }
}

impl<V: Value> Block<V> {
    #[inline(always)]
    fn empty<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let zero = lanes.all(T::ZERO);
        Self {
            rows: [Weighed::nothing(lanes); BLOCK],
            seen: [Seen { weight: zero, products: [zero; 9] }; BLOCK],
            halves: [[zero; BLOCK]; 2],
        }
    }
}

#[cfg(test)]
mod tests;
