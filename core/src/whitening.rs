//! The row offset over its own standard deviation: pixel noise propagated through the
//! rectification to first order (Sampson).
//!
//! Noise of one variance on the four image coordinates gives `e = v_l - v_r` the variance
//! `(1 + v_r^2 - g_l^2) / z_l^2 + (1 + v_l^2 - g_r^2) / z_r^2` (unit depth), with
//! `g_l = R_l[1][2] - R_l[2][2] v_r`, `g_r = R_r[1][2] - R_r[2][2] v_l` and the rectified depths
//! `z`. Nothing is divided by the root of it: squares and products of whitened quantities are those of
//! plain ones over the variance.

use crate::rectification::RectifyingRotations;
use crate::residual::{Row, Sight, View};
use crate::scalar::Scalar;

/// What the variances of a pass have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Whitening<T> {
    gauge_slope: T,
    /// `R[.][2]` of both rotations.
    left: [T; 3],
    right: [T; 3],
}

/// Variance of a row offset over that of a coordinate.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Variance<T> {
    left: Part<T>,
    right: Part<T>,
}

/// What one side adds to it.
#[derive(Debug, Clone, Copy)]
struct Part<T> {
    value: T,
    g: T,
    /// `1 / z^2`.
    square: T,
}

impl<T: Scalar> Whitening<T> {
    pub(crate) fn at(rotations: &RectifyingRotations<T>) -> Self {
        let (l, r) = (rotations.left().matrix(), rotations.right().matrix());
        Self {
            gauge_slope: rotations.gauge_slope(),
            left: [l.m13, l.m23, l.m33],
            right: [r.m13, r.m23, r.m33],
        }
    }

    /// The plain row.
    #[inline(always)]
    pub(crate) fn row(&self, sight: &Sight<T>) -> Row<T> {
        sight.row(self.gauge_slope)
    }

    #[inline(always)]
    pub(crate) fn variance(&self, sight: &Sight<T>) -> Variance<T> {
        Variance {
            left: Part::of(&self.left, &sight.left, sight.right.v),
            right: Part::of(&self.right, &sight.right, sight.left.v),
        }
    }

    /// The row with what the variance changes in its derivatives: half the relative slope of the
    /// variance, times the offset. Without it the pose drifts to where the variance is large.
    #[inline(always)]
    pub(crate) fn whole(&self, row: &Row<T>, sight: &Sight<T>, variance: &Variance<T>) -> Row<T> {
        let (l, r) = (&sight.left, &sight.right);
        let (left_turn, by_right_v) = variance.left.slope(&self.left, l, r.v);
        let (right_turn, by_left_v) = variance.right.slope(&self.right, r, l.v);
        let [lx, ly, lz] = through_row(left_turn, by_left_v, l);
        let [rx, ry, rz] = through_row(right_turn, by_right_v, r);
        let by_unknown = [lx, ly, lz, ly + ry, self.gauge_slope * (lx + rx) + lz + rz];
        let shrink = row.offset * T::HALF / variance.value();
        let ([j0, j1, j2, j3, j4], [d0, d1, d2, d3, d4]) = (row.jacobian, by_unknown);
        Row {
            offset: row.offset,
            jacobian: [
                j0 - d0 * shrink,
                j1 - d1 * shrink,
                j2 - d2 * shrink,
                j3 - d3 * shrink,
                j4 - d4 * shrink,
            ],
        }
    }
}

impl<T: Scalar> Variance<T> {
    #[inline(always)]
    pub(crate) fn value(&self) -> T {
        self.left.value + self.right.value
    }
}

impl<T: Scalar> Part<T> {
    /// * `v`: row of the other ray.
    #[inline(always)]
    fn of([_, c1, c2]: &[T; 3], view: &View<T>, v: T) -> Self {
        let square = view.inverse_depth * view.inverse_depth;
        let g = *c1 - *c2 * v;
        Self { value: (T::ONE + v * v - g * g) * square, g, square }
    }

    /// Derivatives by a turn of this side about x, y, z, and by the row of the other ray.
    #[inline(always)]
    fn slope(&self, [c0, c1, c2]: &[T; 3], view: &View<T>, v: T) -> ([T; 3], T) {
        let two = T::lit(2.0);
        let twice = two * self.value;
        let slope = -two * self.g * self.square;
        let by_turn = [
            -twice * view.v - slope * (*c2 + *c1 * v),
            twice * view.u + slope * *c0 * v,
            slope * *c0,
        ];
        (by_turn, two * self.square * (v + self.g * *c2))
    }
}

/// With what a turn does by way of this side's own row (eq 15), on which the other part depends.
#[inline(always)]
fn through_row<T: Scalar>([x, y, z]: [T; 3], by_v: T, view: &View<T>) -> [T; 3] {
    [x - by_v * (T::ONE + view.v * view.v), y + by_v * (view.u * view.v), z + by_v * view.u]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correspondence::RayPair;
    use crate::residual::tests::pose;
    use nalgebra::{Vector2, Vector3};
    use proptest::prelude::*;

    /// Whitened residual and derivatives.
    fn at(pose: &RectifyingRotations<f64>, left: [f64; 2], right: [f64; 2]) -> Row<f64> {
        let sight = Sight::of(pose, &RayPair::try_new(left, right).unwrap()).unwrap();
        let whitening = Whitening::at(pose);
        let variance = whitening.variance(&sight);
        let row = whitening.whole(&whitening.row(&sight), &sight, &variance);
        let scale = 1.0 / variance.value().sqrt();
        Row { offset: row.offset * scale, jacobian: row.jacobian.map(|j| j * scale) }
    }

    proptest! {
        #[test]
        fn jacobian_matches_central_differences(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let analytic = at(&pose, left, right).jacobian;
            let size = analytic.iter().fold(0.0_f64, |m, j| m.max(j.abs()));
            for (i, analytic) in analytic.into_iter().enumerate() {
                let moved = |h: f64| {
                    let d: [f64; 5] = core::array::from_fn(|k| if k == i { h } else { 0.0 });
                    let [x, y, z, by, bz] = d;
                    let step = (Vector3::new(x, y, z), Vector2::new(by, bz));
                    at(&pose.stepped(&step.0, &step.1).unwrap(), left, right).offset
                };
                let h = 1e-3;
                let numeric =
                    (8.0 * (moved(h) - moved(-h)) - (moved(2.0 * h) - moved(-2.0 * h))) / (12.0 * h);
                prop_assert!((analytic - numeric).abs() < 1e-8 * size, "{i}: {analytic} {numeric}");
            }
        }

        #[test]
        fn unit_noise_on_the_coordinates_gives_the_residual_unit_deviation(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], disparity in 0.0..0.3_f64,
        ) {
            // On the epipolar line, where the residual is zero and its scale does not vary.
            let pose = pose(rotation, t);
            let p = pose.left() * Vector3::new(left[0], left[1], 1.0);
            let q = pose.right().inverse() * Vector3::new(p.x / p.z - disparity, p.y / p.z, 1.0);
            let right = [q.x / q.z, q.y / q.z];
            let h = 1e-5;
            let gradient_squared: f64 = (0..4_usize)
                .map(|i| {
                    let moved = |h: f64| {
                        let d = |k: usize| if k == i { h } else { 0.0 };
                        let left = [left[0] + d(0), left[1] + d(1)];
                        at(&pose, left, [right[0] + d(2), right[1] + d(3)]).offset
                    };
                    ((moved(h) - moved(-h)) / (2.0 * h)).powi(2)
                })
                .sum();
            prop_assert!((gradient_squared - 1.0).abs() < 1e-6, "{gradient_squared}");
        }
    }
}
