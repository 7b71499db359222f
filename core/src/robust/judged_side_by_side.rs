//! The judgement of as many correspondences at a time as there are lanes.

use core::hint::black_box;

use pulp::{Simd, WithSimd};

use super::hearing::{Bench, Hearing};
use super::judgement::{Evidence, Heard};
use super::outlook::Outlook;
use super::side_by_side::{BLOCK, Sums};
use super::tally::Tally;
use super::weighing::Weighed;
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

/// Sums for each lane.
struct Added<V> {
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
        let bench = black_box(Bench::of(lanes, outlook));
        let (mut hearing, mut added) = (Hearing::nothing(lanes), Added::nothing(lanes));
        let (mut block, nothing) = (Block::empty(lanes), Seen::nothing(lanes));
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
                let judged = hearing.judge(lanes, &bench, rays, T::load(simd, step));
                (*row, *seen) = judged.unwrap_or((Weighed::nothing(lanes), nothing));
                let ([x, y, ..], zero) = (rays, lanes.all(T::ZERO));
                *left = lanes.keep(lanes.below(x, zero), row.weight);
                *upper = lanes.keep(lanes.below(y, zero), row.weight);
            }
            added.add(lanes, &block, x_l.len());
        }
        let (_, left_over) = T::split::<S>(columns.grid_step);
        let filled = pairs.len().saturating_sub(left_over.len());
        let seen = u32::try_from(filled).unwrap_or(u32::MAX);
        let heard = Heard {
            tally: Tally::of(lanes, seen, &hearing.tallies),
            gradient: lanes.totals(&added.gradient).into(),
            weights: lanes.totals(&hearing.weights),
        };
        evidence.moments.add_side_by_side(lanes, &added.products);
        for (half, sums) in evidence.halves.iter_mut().zip(&added.halves) {
            half.add(&sums.total(lanes));
        }
        (heard, filled)
    }
}

impl<V: Value> Added<V> {
    #[inline(always)]
    fn nothing<T: Scalar, L: Lanes<T, Value = V>>(lanes: L) -> Self {
        let zero = lanes.all(T::ZERO);
        Self {
            products: Products::zero(lanes),
            halves: [Sums::zero(lanes), Sums::zero(lanes)],
            gradient: [zero; 5],
        }
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
            seen: [Seen::nothing(lanes); BLOCK],
            halves: [[zero; BLOCK]; 2],
        }
    }
}

#[cfg(test)]
mod tests;
