//! Normal equations as sums over the batch, on any lanes.
//!
//! 20 sums: `H = sum w J J^T` (lower triangle, 15) and `g = sum w C J` (5).

use super::weighting::WeightedRow;
use crate::algebra::normal_equations::NormalEquations;
use crate::scalar::Scalar;
use crate::simd::Lanes;

/// Sums of `w J J^T` and `w C J`.
#[derive(Debug, Clone, Copy)]
pub(super) struct NormalSums<S> {
    /// Lower triangle of the information, rows 1 to 4.
    upper: [S; 10],
    /// Row 5.
    last: [S; 5],
    gradient: [S; 5],
}

impl<S: Copy> NormalSums<S> {
    /// Sums that continue from normal equations.
    #[inline(always)]
    pub(super) fn resume<T: Scalar>(
        lanes: impl Lanes<T, Sum = S>,
        from: &NormalEquations<T>,
    ) -> Self {
        let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o] = from.information.0.0;
        let [[p, q, r, s, t]] = from.gradient.data.0;
        let sum = |x| lanes.resume(x);
        Self {
            upper: [a, b, c, d, e, f, g, h, i, j].map(sum),
            last: [k, l, m, n, o].map(sum),
            gradient: [p, q, r, s, t].map(sum),
        }
    }

    /// Adds one row.
    #[inline(always)]
    pub(super) fn add_one<T: Scalar, L: Lanes<T, Sum = S>>(
        &mut self,
        lanes: L,
        row: WeightedRow<L::Value>,
    ) {
        add_upper(lanes, &mut self.upper, &row);
        add_last(lanes, &mut self.last, &mut self.gradient, &row);
    }

    /// Adds rows in order. Each of the two loops keeps its ten sums in registers.
    // Loops, not `for_each`: what is not inlined has no vector instructions.
    #[inline(always)]
    pub(super) fn add<T: Scalar, L: Lanes<T, Sum = S>>(
        &mut self,
        lanes: L,
        rows: impl Iterator<Item = WeightedRow<L::Value>> + Clone,
    ) {
        let Self { mut upper, mut last, mut gradient } = *self;
        for row in rows.clone() {
            add_upper(lanes, &mut upper, &row);
        }
        for row in rows {
            add_last(lanes, &mut last, &mut gradient, &row);
        }
        *self = Self { upper, last, gradient };
    }

    /// Stores the sums in the normal equations that they continue from.
    #[inline(always)]
    pub(super) fn store<T: Scalar>(
        self,
        lanes: impl Lanes<T, Sum = S>,
        to: &mut NormalEquations<T>,
    ) {
        let information = self.upper.into_iter().chain(self.last);
        lanes.store_all(information, &mut to.information.0.0);
        lanes.store_all(self.gradient, to.gradient.iter_mut());
    }
}

#[inline(always)]
fn add_upper<T: Scalar, L: Lanes<T>>(
    lanes: L,
    [a, b, c, d, e, f, g, h, i, j]: &mut [L::Sum; 10],
    &WeightedRow { weight, jacobian: [j0, j1, j2, j3, _], .. }: &WeightedRow<L::Value>,
) {
    let [w0, w1, w2, w3] = [weight * j0, weight * j1, weight * j2, weight * j3];
    lanes.add_product(a, w0, j0);
    lanes.add_product(b, w1, j0);
    lanes.add_product(c, w1, j1);
    lanes.add_product(d, w2, j0);
    lanes.add_product(e, w2, j1);
    lanes.add_product(f, w2, j2);
    lanes.add_product(g, w3, j0);
    lanes.add_product(h, w3, j1);
    lanes.add_product(i, w3, j2);
    lanes.add_product(j, w3, j3);
}

#[inline(always)]
fn add_last<T: Scalar, L: Lanes<T>>(
    lanes: L,
    [a, b, c, d, e]: &mut [L::Sum; 5],
    [f, g, h, i, j]: &mut [L::Sum; 5],
    &WeightedRow { weight, value, jacobian: [j0, j1, j2, j3, j4] }: &WeightedRow<L::Value>,
) {
    let (w4, pull) = (weight * j4, weight * value);
    lanes.add_product(a, w4, j0);
    lanes.add_product(b, w4, j1);
    lanes.add_product(c, w4, j2);
    lanes.add_product(d, w4, j3);
    lanes.add_product(e, w4, j4);
    lanes.add_product(f, pull, j0);
    lanes.add_product(g, pull, j1);
    lanes.add_product(h, pull, j2);
    lanes.add_product(i, pull, j3);
    lanes.add_product(j, pull, j4);
}
