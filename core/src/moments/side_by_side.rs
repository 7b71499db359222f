//! The sums of as many correspondences at a time as there are lanes.

use super::{Moments, Seen};
use crate::lanes::{Lanes, Value};
use crate::scalar::Scalar;

/// Sums of `w k k^T` for each lane: a row of the lower triangle each.
pub(crate) struct Products<V> {
    upper: ([V; 1], [V; 2], [V; 3], [V; 4]),
    middle: [V; 5],
    lower: ([V; 6], [V; 7], [V; 8], [V; 9]),
}

impl<V: Value> Seen<V> {
    #[inline(always)]
    pub(crate) fn nothing<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let zero = lanes.all(T::ZERO);
        Self { weight: zero, products: [zero; 9] }
    }
}

impl<V: Value> Products<V> {
    #[inline(always)]
    pub(crate) fn zero<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let o = lanes.all(T::ZERO);
        Self {
            upper: ([o; 1], [o; 2], [o; 3], [o; 4]),
            middle: [o; 5],
            lower: ([o; 6], [o; 7], [o; 8], [o; 9]),
        }
    }

    /// A short row and a long one at a time: so many sums fit into the registers.
    #[inline(always)]
    pub(crate) fn add<T: Scalar>(&mut self, lanes: impl Lanes<T, Value = V>, block: &[Seen<V>]) {
        let ((m0, m1, m2, m3), (m5, m6, m7, m8)) = (&mut self.upper, &mut self.lower);
        add_rows(lanes, m0, m8, block);
        add_rows(lanes, m1, m7, block);
        add_rows(lanes, m2, m6, block);
        add_rows(lanes, m3, m5, block);
        add_rows(lanes, &mut self.middle, &mut [], block);
    }
}

impl<T: Scalar> Moments<T> {
    /// Adds the sums of all lanes.
    #[inline(always)]
    pub(crate) fn add_side_by_side<L: Lanes<T>>(&mut self, lanes: L, sums: &Products<L::Value>) {
        let ((m0, m1, m2, m3), (m5, m6, m7, m8)) = (&sums.upper, &sums.lower);
        let upper = m0.iter().chain(m1).chain(m2).chain(m3).chain(&sums.middle);
        let lower = m5.iter().chain(m6).chain(m7).chain(m8);
        for (sum, of_lanes) in self.products.iter_mut().zip(upper.chain(lower)) {
            *sum += lanes.total(*of_lanes);
        }
    }
}

/// Adds to two rows of the triangle, of which the second may be none.
#[inline(always)]
fn add_rows<T: Scalar, L: Lanes<T>, const A: usize, const B: usize>(
    lanes: L,
    one: &mut [L::Value; A],
    other: &mut [L::Value; B],
    block: &[Seen<L::Value>],
) {
    let (mut a, mut b) = (*one, *other);
    for Seen { weight, products } in block {
        add_row(lanes, &mut a, *weight, products);
        add_row(lanes, &mut b, *weight, products);
    }
    (*one, *other) = (a, b);
}

#[inline(always)]
fn add_row<T: Scalar, L: Lanes<T>, const N: usize>(
    lanes: L,
    row: &mut [L::Value; N],
    weight: L::Value,
    products: &[L::Value; 9],
) {
    let Some(own) = N.checked_sub(1).and_then(|last| products.get(last)) else {
        return;
    };
    let weighted = weight * *own;
    for (sum, product) in row.iter_mut().zip(products) {
        *sum = lanes.mul_add(weighted, *product, *sum);
    }
}
