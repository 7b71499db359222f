//! The same pass over as many correspondences at a time as there are lanes.

use core::hint::black_box;

use pulp::{Simd, WithSimd};

use super::Descent;
use super::pass::Pass;
use super::weighing::{Counts, Weighed};
use crate::batch::Matches;
use crate::information::Information;
use crate::lanes::{Lanes, Value, dispatch};
use crate::quadratic::Quadratic;
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;

/// Rows that are weighed before they are summed: registers hold what either needs, not both.
pub(super) const BLOCK: usize = 8;

/// A pass over the whole batch.
struct Whole<'a, T: Scalar> {
    descent: &'a Descent<T>,
    matches: Matches<'a, T>,
}

/// Sums for each lane.
pub(super) struct Sums<V> {
    /// Of `w J J^T`: lower triangle but for its last row, then that.
    upper: [V; 10],
    last: [V; 5],
    /// Of `w J r`.
    gradient: [V; 5],
}

impl<T: Scalar> Descent<T> {
    /// As [`Descent::pass_one_by_one`] over all, to rounding: sums are made in another order, and
    /// products are not rounded where the processor can add to them at once. `None` without lanes.
    pub(super) fn pass_side_by_side(&self, matches: Matches<'_, T>) -> Option<Pass<T>> {
        dispatch(Whole { descent: self, matches })
    }
}

impl<T: Scalar> WithSimd for Whole<'_, T> {
    type Output = Pass<T>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Pass<T> {
        let Self { descent, matches: Matches { pairs, columns } } = self;
        let lanes = T::wide(simd);
        // From memory a number comes with the operation; the compiler would copy it to all lanes anew.
        let by = black_box(descent.weighing(lanes));
        let (mut counts, mut sums) = (Counts::zero(lanes), Sums::zero(lanes));
        let chunks = |column| T::split::<S>(column).0.chunks(BLOCK);
        let [x_l, y_l, x_r, y_r] = columns.rays.map(chunks);
        let mut block = [Weighed::nothing(lanes); BLOCK];
        let rows = x_l.zip(y_l).zip(x_r).zip(y_r).zip(chunks(columns.grid_step));
        for ((((x_l, y_l), x_r), y_r), steps) in rows {
            let rows = x_l.iter().zip(y_l).zip(x_r).zip(y_r).zip(steps);
            for (place, ((((x_l, y_l), x_r), y_r), step)) in block.iter_mut().zip(rows) {
                let rays = [x_l, y_l, x_r, y_r].map(|stored| T::load(simd, stored));
                let weighed = counts.weigh(lanes, &by, rays, T::load(simd, step));
                *place = weighed.unwrap_or(Weighed::nothing(lanes));
            }
            sums.add(lanes, block.get(..x_l.len()).unwrap_or_default().iter().copied());
        }
        let (_, left_over) = T::split::<S>(columns.grid_step);
        let (_, rest) = pairs.split_at(pairs.len().saturating_sub(left_over.len()));
        let whole = Pass::of(&counts.total(lanes), sums.total(lanes));
        whole.plus(&descent.pass_one_by_one(rest, usize::MAX))
    }
}

impl<V: Value> Sums<V> {
    #[inline(always)]
    pub(super) fn zero<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let zero = lanes.all(T::ZERO);
        Self { upper: [zero; 10], last: [zero; 5], gradient: [zero; 5] }
    }

    #[inline(always)]
    pub(super) fn add<T: Scalar>(
        &mut self,
        lanes: impl Lanes<T, Value = V>,
        block: impl Iterator<Item = Weighed<V>> + Clone,
    ) {
        let [mut a, mut b, mut c, mut d, mut e, mut f, mut g, mut h, mut i, mut j] = self.upper;
        for Weighed { weight, jacobian: [j0, j1, j2, j3, _], .. } in block.clone() {
            let [w0, w1, w2, w3] = [j0, j1, j2, j3].map(|j| weight * j);
            a = lanes.mul_add(w0, j0, a);
            b = lanes.mul_add(w1, j0, b);
            c = lanes.mul_add(w1, j1, c);
            d = lanes.mul_add(w2, j0, d);
            e = lanes.mul_add(w2, j1, e);
            f = lanes.mul_add(w2, j2, f);
            g = lanes.mul_add(w3, j0, g);
            h = lanes.mul_add(w3, j1, h);
            i = lanes.mul_add(w3, j2, i);
            j = lanes.mul_add(w3, j3, j);
        }
        self.upper = [a, b, c, d, e, f, g, h, i, j];
        let ([mut a, mut b, mut c, mut d, mut e], [mut f, mut g, mut h, mut i, mut j]) =
            (self.last, self.gradient);
        for Weighed { weight, value, jacobian: [j0, j1, j2, j3, j4] } in block {
            let (w4, pull) = (weight * j4, weight * value);
            a = lanes.mul_add(w4, j0, a);
            b = lanes.mul_add(w4, j1, b);
            c = lanes.mul_add(w4, j2, c);
            d = lanes.mul_add(w4, j3, d);
            e = lanes.mul_add(w4, j4, e);
            f = lanes.mul_add(pull, j0, f);
            g = lanes.mul_add(pull, j1, g);
            h = lanes.mul_add(pull, j2, h);
            i = lanes.mul_add(pull, j3, i);
            j = lanes.mul_add(pull, j4, j);
        }
        (self.last, self.gradient) = ([a, b, c, d, e], [f, g, h, i, j]);
    }

    #[inline(always)]
    pub(super) fn total<T: Scalar>(&self, lanes: impl Lanes<T, Value = V>) -> Quadratic<T> {
        let [a, b, c, d, e, f, g, h, i, j] = lanes.totals(&self.upper);
        let [k, l, m, n, o] = lanes.totals(&self.last);
        Quadratic {
            information: Information(Symmetric([a, b, c, d, e, f, g, h, i, j, k, l, m, n, o])),
            gradient: lanes.totals(&self.gradient).into(),
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::constraint::{Constraint, Frame};
    use super::super::scenes::{batch, descents};
    use super::super::weighing::Loss;
    use super::super::{Outlook, Stage};
    use super::*;
    use crate::correspondence::RayPair;
    use crate::lanes::Single;
    use proptest::prelude::*;

    /// What rounding is relative to in sums whose largest element is that: a weight is what is left of a
    /// whole one, so near the edge of the loss its own error is the geometric mean of the two.
    ///
    /// * `variance`: that the loss measures in, px^2.
    pub(in super::super) fn rounded_by<T: Scalar>(
        outlook: &Outlook<T>,
        pairs: &[RayPair<T>],
        variance: T,
        largest: f64,
    ) -> f64 {
        let frame = Frame::at(Single, &outlook.pose);
        let whole_of = |pair: &RayPair<T>| {
            let (Constraint { variance: v, jacobian, .. }, in_front) =
                Constraint::of(Single, &frame, pair.rays());
            let squares = jacobian.iter().map(|j| (*j * *j / v).to_f64());
            if in_front { squares.fold(0.0, f64::max) } else { 0.0 }
        };
        let unit = (outlook.focal * outlook.focal / variance).to_f64();
        let whole = unit * pairs.iter().map(whole_of).sum::<f64>();
        largest + (largest * whole).sqrt()
    }

    /// Whether rounding decides if one of them is in front of the cameras, or behind infinity.
    fn is_on_edge<T: Scalar>(outlook: &Outlook<T>, pairs: &[RayPair<T>], rounding: f64) -> bool {
        let by = outlook.weighing(Single, Loss::Polish);
        let edge = T::lit(0.01 * rounding);
        let sides = |pair: &RayPair<T>, edge: T| {
            let mut frame = by.frame;
            frame.min_depth += edge;
            let (constraint, in_front) = Constraint::of(Single, &frame, pair.rays());
            (in_front, constraint.has_disparity(Single, by.min_disparity + edge))
        };
        pairs.iter().any(|pair| sides(pair, edge) != sides(pair, -edge))
    }

    fn agree<T: Scalar>(pixels: &[[f64; 4]], rotation: [f64; 3], t: [f64; 2], rounding: f64) {
        let batch = batch::<T>(pixels);
        for descent in descents(&batch, rotation, t) {
            if is_on_edge(&descent.at, batch.pairs(), rounding) {
                continue;
            }
            let one = descent.pass_one_by_one(batch.pairs(), usize::MAX);
            let wide = descent.pass_side_by_side(batch.matches());
            let wide = wide.expect("a processor with lanes: else nothing is compared");
            assert_eq!([one.usable], [wide.usable]);
            // On the edge of a weight of zero or of two deviations rounding decides.
            assert!(one.weighted.abs_diff(wide.weighted) <= 1, "{one:?} {wide:?}");
            assert!(one.near.abs_diff(wide.near) <= 1, "{one:?} {wide:?}");
            let (a, b) = (&one.capped.information.0, &wide.capped.information.0);
            let scale = a.diagonal().map(|d| d.to_f64().sqrt());
            let largest = scale.iter().fold(0.0_f64, |m, s| m.max(*s)).powi(2);
            let variance = match descent.stage {
                Stage::Anneal(scale) => scale * scale,
                Stage::Follow(_) | Stage::Polish => descent.at.noise * descent.at.noise,
            };
            let most = rounding * rounded_by(&descent.at, batch.pairs(), variance, largest);
            for (a, b) in a.0.iter().zip(&b.0) {
                assert!((*a - *b).to_f64().abs() <= most, "{one:?} {wide:?}");
            }
            // What counts at all is within 4.7 deviations.
            let pulls = 4.7 * (largest * f64::from(one.weighted)).sqrt();
            for (a, b) in one.capped.gradient.iter().zip(&wide.capped.gradient) {
                assert!((*a - *b).to_f64().abs() <= rounding * pulls, "{one:?} {wide:?}");
            }
            if one.near == wide.near {
                let most = rounding * 10.0 * f64::from(one.near);
                let [a, b] = [&one, &wide].map(|pass| pass.near_squares.to_f64());
                assert!((a - b).abs() <= most, "{one:?} {wide:?}");
            }
        }
    }

    proptest! {
        #[test]
        fn a_pass_side_by_side_is_that_one_by_one_to_rounding(
            pixels in prop::collection::vec([200.0..7800.0, 0.0..599.0, -5.0..80.0, -3.0..3.0], 0..100),
            rotation in [-0.1..0.1, -0.3..0.3, -0.1..0.1], t in [-0.1..0.1, -0.1..0.1],
        ) {
            agree::<f64>(&pixels, rotation, t, 1e-12);
            agree::<f32>(&pixels, rotation, t, 1e-3);
        }
    }
}
