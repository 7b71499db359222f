//! The row offset over its own standard deviation: pixel noise propagated through the
//! rectification to first order (Sampson).
//!
//! Noise of one variance on the four image coordinates gives `e = v_l - v_r` the variance
//! `(1 + v_r^2 - g_l^2) / z_l^2 + (1 + v_l^2 - g_r^2) / z_r^2` (unit depth), with
//! `g_l = R_l[1][2] - R_l[2][2] v_r`, `g_r = R_r[1][2] - R_r[2][2] v_l` and the rectified depths
//! `z`. The derivative includes that of the variance: without it the pose drifts to where the
//! variance is large.

use crate::correspondence::RayPair;
use crate::rectification::RectifyingRotations;
use crate::residual::{Row, rectified};
use crate::scalar::Scalar;

/// Whitened residual of one correspondence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct WhitenedRow<T> {
    /// Residual in px of one coordinate's noise, and its derivatives, px/rad, as in [`Row`].
    pub(crate) row: Row<T>,
    /// Row offset, px.
    pub(crate) offset_px: T,
    /// Residual over the epipolar constraint of the rotated rays at unit depth, px.
    pub(crate) per_constraint: T,
    /// Disparity, px; negative for points behind the cameras.
    pub(crate) disparity_px: T,
}

/// One side of a correspondence: the rectified ray, and the third column of its rotation.
struct View<T> {
    u: T,
    v: T,
    /// `1 / z`.
    inverse_depth: T,
    /// `R[.][2]`.
    axis: [T; 3],
}

impl<T: Scalar> View<T> {
    /// This side's part of the variance, where the other ray has row `v`, and its derivatives by a
    /// turn of this side about x, y, z and by that `v`.
    fn variance(&self, v: T) -> (T, [T; 3], T) {
        let [c0, c1, c2] = self.axis;
        let two = T::lit(2.0);
        let square = self.inverse_depth * self.inverse_depth;
        let g = c1 - c2 * v;
        let spread = T::ONE + v * v - g * g;
        let part = spread * square;
        let twice = two * part;
        let slope = -two * g * square;
        let by_turn =
            [-twice * self.v + slope * (-c2 - c1 * v), twice * self.u + slope * c0 * v, slope * c0];
        (part, by_turn, two * square * (v + g * c2))
    }
}

/// Residual and derivatives, or `None` if a ray lies behind the rectified plane.
///
/// * `focal`: px.
pub(crate) fn whitened<T: Scalar>(
    rotations: &RectifyingRotations<T>,
    gauge_slope: T,
    focal: T,
    pair: &RayPair<T>,
) -> Option<WhitenedRow<T>> {
    let (l, left_inverse) = rectified(rotations.left().matrix(), &pair.left)?;
    let (r, right_inverse) = rectified(rotations.right().matrix(), &pair.right)?;
    let axis = |m: &nalgebra::Matrix3<T>| [m.m13, m.m23, m.m33];
    let left =
        View { u: l.x, v: l.y, inverse_depth: left_inverse, axis: axis(rotations.left().matrix()) };
    let right = View {
        u: r.x,
        v: r.y,
        inverse_depth: right_inverse,
        axis: axis(rotations.right().matrix()),
    };
    let plain = Row::of(&l, &r, gauge_slope);
    let (left_part, left_turn, by_right_v) = left.variance(r.y);
    let (right_part, right_turn, by_left_v) = right.variance(l.y);
    let variance = left_part + right_part;

    // dv by a turn of its own side (eq 15).
    let dv = |p: &View<T>| [-(T::ONE + p.v * p.v), p.u * p.v, p.u];
    let [lx, ly, lz] = sum(&left_turn, by_left_v, &dv(&left));
    let [rx, ry, rz] = sum(&right_turn, by_right_v, &dv(&right));
    let by_unknown = [lx, ly, lz, ly + ry, gauge_slope * (lx + rx) + lz + rz];

    let scale = focal / variance.sqrt();
    let shrink = plain.offset * T::HALF / variance;
    let mut jacobian = plain.jacobian;
    for (j, d) in jacobian.iter_mut().zip(by_unknown) {
        *j = (*j - d * shrink) * scale;
    }
    Some(WhitenedRow {
        row: Row { offset: plain.offset * scale, jacobian },
        offset_px: plain.offset * focal,
        per_constraint: scale * left_inverse * right_inverse,
        disparity_px: (l.x - r.x) * focal,
    })
}

fn sum<T: Scalar>(a: &[T; 3], factor: T, b: &[T; 3]) -> [T; 3] {
    let ([a0, a1, a2], [b0, b1, b2]) = (*a, *b);
    [a0 + factor * b0, a1 + factor * b1, a2 + factor * b2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::residual::tests::pose;
    use nalgebra::{Vector2, Vector3};
    use proptest::prelude::*;

    fn at(pose: &RectifyingRotations<f64>, left: [f64; 2], right: [f64; 2]) -> WhitenedRow<f64> {
        let pair = RayPair::try_new(left, right).unwrap();
        whitened(pose, pose.gauge_slope(), 1.0, &pair).unwrap()
    }

    proptest! {
        #[test]
        fn jacobian_matches_central_differences(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let analytic = at(&pose, left, right).row.jacobian;
            let size = analytic.iter().fold(0.0_f64, |m, j| m.max(j.abs()));
            for (i, analytic) in analytic.into_iter().enumerate() {
                let moved = |h: f64| {
                    let d: [f64; 5] = core::array::from_fn(|k| if k == i { h } else { 0.0 });
                    let [x, y, z, by, bz] = d;
                    let step = (Vector3::new(x, y, z), Vector2::new(by, bz));
                    at(&pose.stepped(&step.0, &step.1).unwrap(), left, right).row.offset
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
                        at(&pose, left, [right[0] + d(2), right[1] + d(3)]).row.offset
                    };
                    ((moved(h) - moved(-h)) / (2.0 * h)).powi(2)
                })
                .sum();
            prop_assert!((gradient_squared - 1.0).abs() < 1e-6, "{gradient_squared}");
        }
    }
}
