//! Sums of evaluated correspondences: moments, and normal equations of the regions of the image, for its halves.

use nalgebra::Vector5;

use super::normal_sums::NormalSums;
use super::weighting::WeightedRow;
use crate::algebra::moments::{COORDINATES, MomentSums, Moments};
use crate::algebra::normal_equations::NormalEquations;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Single};

/// Terms of a weighted correspondence.
#[derive(Debug, Clone, Copy)]
pub(super) struct EvaluatedRow<V> {
    pub(super) row: WeightedRow<V>,
    /// Coordinates `k` of the moments.
    pub(super) products: [V; COORDINATES],
    /// Left ray `x_l`, `y_l`: decides the image half.
    pub(super) at: [V; 2],
}

/// Sums of evaluated correspondences, added in order.
pub(super) trait EvaluatedSums<T: Scalar, L: Lanes<T>> {
    fn add(&mut self, lanes: L, rows: &[EvaluatedRow<L::Value>]);
}

/// Moments, and normal equations of the quadrants of the image, `[[upper left, upper right], [lower left, lower
/// right]]`: each row is added once.
pub(super) struct QuadrantSums<'a, T> {
    pub(super) products: &'a mut MomentSums<T>,
    pub(super) quadrants: [[NormalEquations<T>; 2]; 2],
}

impl<T: Scalar> EvaluatedSums<T, Single> for QuadrantSums<'_, T> {
    /// Out of line: the registers hold sums, not terms of the pass.
    #[inline(never)]
    fn add(&mut self, _: Single, rows: &[EvaluatedRow<T>]) {
        self.products.add_tiles(rows.iter().map(|row| (row.row.weight, &row.products)));
        for EvaluatedRow { row: WeightedRow { weight, value, jacobian }, at: [x, y], .. } in rows {
            let [upper, lower] = &mut self.quadrants;
            let [left, right] = if *y < T::ZERO { upper } else { lower };
            let quadrant = if *x < T::ZERO { left } else { right };
            quadrant.add_row(*weight, *value, jacobian);
        }
    }
}

/// Moments, normal equations of the left and of the upper half, and the gradient of the whole image: no branches on
/// lanes.
pub(super) struct HalfSums<S> {
    products: MomentSums<S>,
    halves: [NormalSums<S>; 2],
    gradient: [S; 5],
}

impl<S: Copy> HalfSums<S> {
    #[inline(always)]
    pub(super) fn resume<T: Scalar>(
        lanes: impl Lanes<T, Sum = S>,
        moments: &Moments<T>,
        [left, upper]: &[NormalEquations<T>; 2],
        gradient: &Vector5<T>,
    ) -> Self {
        let [[a, b, c, d, e]] = gradient.data.0;
        Self {
            products: moments.resume(lanes),
            halves: [NormalSums::resume(lanes, left), NormalSums::resume(lanes, upper)],
            gradient: [a, b, c, d, e].map(|x| lanes.resume(x)),
        }
    }

    #[inline(always)]
    pub(super) fn store<T: Scalar>(
        self,
        lanes: impl Lanes<T, Sum = S>,
        moments: &mut Moments<T>,
        [left, upper]: &mut [NormalEquations<T>; 2],
        gradient: &mut Vector5<T>,
    ) {
        moments.store(lanes, self.products);
        let [of_left, of_upper] = self.halves;
        of_left.store(lanes, left);
        of_upper.store(lanes, upper);
        lanes.store_all(self.gradient, gradient.iter_mut());
    }
}

impl<T: Scalar, L: Lanes<T>> EvaluatedSums<T, L> for HalfSums<L::Sum> {
    #[inline(always)]
    fn add(&mut self, lanes: L, rows: &[EvaluatedRow<L::Value>]) {
        self.products.add(lanes, rows.iter().map(|row| (row.row.weight, &row.products)));
        let [mut a, mut b, mut c, mut d, mut e] = self.gradient;
        for EvaluatedRow {
            row: WeightedRow { weight, value, jacobian: [j0, j1, j2, j3, j4] },
            ..
        } in rows
        {
            let pull = *weight * *value;
            lanes.add_product(&mut a, pull, *j0);
            lanes.add_product(&mut b, pull, *j1);
            lanes.add_product(&mut c, pull, *j2);
            lanes.add_product(&mut d, pull, *j3);
            lanes.add_product(&mut e, pull, *j4);
        }
        self.gradient = [a, b, c, d, e];
        let zero = lanes.splat(T::ZERO);
        let [left, upper] = &mut self.halves;
        let half = |row: &EvaluatedRow<L::Value>, at| {
            let weight = lanes.keep(lanes.lt(at, zero), row.row.weight);
            WeightedRow { weight, ..row.row }
        };
        left.add(lanes, rows.iter().map(|row| half(row, row.at[0])));
        upper.add(lanes, rows.iter().map(|row| half(row, row.at[1])));
    }
}
