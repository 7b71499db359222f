//! Sums over evaluated correspondences: moments, and normal equations of the image quadrants, which add up to image
//! halves.

use super::weighting::WeightedRow;
use crate::algebra::moments::{COORDINATES, Moments};
use crate::algebra::normal_equations::NormalEquations;
use crate::scalar::Scalar;

/// Terms of a weighted correspondence.
#[derive(Debug, Clone, Copy)]
pub(super) struct EvaluatedRow<T> {
    pub(super) row: WeightedRow<T>,
    /// Coordinates `k` of the moments.
    pub(super) coordinates: [T; COORDINATES],
    /// Left ray `x_l`, `y_l` at unit depth; its signs give the quadrant.
    pub(super) at: [T; 2],
}

/// Moments, and normal equations of the image quadrants `[[upper left, upper right], [lower left, lower right]]`. With
/// quadrants instead of halves, each row is added once.
pub(super) struct QuadrantSums<'a, T> {
    pub(super) moments: &'a mut Moments<T>,
    pub(super) quadrants: [[NormalEquations<T>; 2]; 2],
}

impl<T: Scalar> QuadrantSums<'_, T> {
    /// Adds correspondences in order. Out of line, so that the registers hold the sums and not the terms of the pass.
    #[inline(never)]
    pub(super) fn add(&mut self, rows: &[EvaluatedRow<T>]) {
        self.moments.add_rows(rows.iter().map(|row| (row.row.weight, &row.coordinates)));
        for EvaluatedRow { row: WeightedRow { weight, value, jacobian }, at: [x, y], .. } in rows {
            let [upper, lower] = &mut self.quadrants;
            let [left, right] = if *y < T::ZERO { upper } else { lower };
            let quadrant = if *x < T::ZERO { left } else { right };
            quadrant.add_row(*weight, *value, jacobian);
        }
    }
}
