//! Row offset of one correspondence after rectification, and its derivatives.
//!
//! Input: rays at unit depth, dimensionless. Output: `e_i = v_l - v_r` between the rectified rays,
//! dimensionless; times the focal length it is pixels. Source: eqs 9-15 with `u = x/z, v = y/z`.
//! Departures, each with its test:
//! - the five unknowns are the turn of `R` (3) and of the baseline (2), not those of `R_l` and
//!   `R_r`: the same steps in a basis where the columns are not nearly parallel, which `f32` needs
//!   in far scenes, and in which the information is that of `R` and `t`;
//! - eq 8 is kept by the step itself, so the row `e_0` and the sixth unknown are not needed;
//! - a ray with rectified depth below [`MIN_DEPTH`] is skipped and counted, the paper divides by it.

use nalgebra::Vector2;

use crate::correspondence::RayPair;
use crate::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Smallest depth of a rectified unit-depth ray: 87 degrees off the rectified axis.
pub(crate) const MIN_DEPTH: f64 = 0.05;

/// Residual and derivatives of one correspondence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row<T> {
    /// `e_i`, unit depth.
    pub(crate) offset: T,
    /// Derivatives by turn of `R` about rectified x, y, z, then turn of the baseline about y, z.
    pub(crate) jacobian: [T; 5],
}

/// Row offset `e_i` of eq 11: `v_l - v_r` of the rectified rays, at unit depth, dimensionless; times
/// the focal length it is px. `None` if a ray lies behind the rectified plane.
pub fn row_offset<T: Scalar>(rotations: &RectifyingRotations<T>, pair: &RayPair<T>) -> Option<T> {
    let (l, r) = (rotations.left().matrix(), rotations.right().matrix());
    let [y_l, y_r] = [
        l.m21 * pair.left.x + l.m22 * pair.left.y + l.m23,
        r.m21 * pair.right.x + r.m22 * pair.right.y + r.m23,
    ];
    let [inverse_l, inverse_r] = inverse_depths(
        l.m31 * pair.left.x + l.m32 * pair.left.y + l.m33,
        r.m31 * pair.right.x + r.m32 * pair.right.y + r.m33,
    )?;
    Some(y_l * inverse_l - y_r * inverse_r)
}

/// `e_i` with its derivatives for [`RectifyingRotations::stepped`].
#[inline(always)]
pub(crate) fn linearised<T: Scalar>(
    rotations: &RectifyingRotations<T>,
    gauge_slope: T,
    pair: &RayPair<T>,
) -> Option<Row<T>> {
    Some(Sight::of(rotations, pair)?.row(gauge_slope))
}

/// One side of a correspondence: its rectified ray `(u, v)` at unit depth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View<T> {
    pub(crate) u: T,
    pub(crate) v: T,
}

/// A correspondence after rectification.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sight<T> {
    pub(crate) left: View<T>,
    pub(crate) right: View<T>,
}

impl<T: Scalar> Sight<T> {
    /// `None` if a ray lies behind the rectified plane.
    #[inline(always)]
    pub(crate) fn of(rotations: &RectifyingRotations<T>, pair: &RayPair<T>) -> Option<Self> {
        let (l, r) = (rotations.left().matrix(), rotations.right().matrix());
        let (a, b): (&Vector2<T>, &Vector2<T>) = (&pair.left, &pair.right);
        let [inverse_l, inverse_r] =
            inverse_depths(l.m31 * a.x + l.m32 * a.y + l.m33, r.m31 * b.x + r.m32 * b.y + r.m33)?;
        Some(Self {
            left: View {
                u: (l.m11 * a.x + l.m12 * a.y + l.m13) * inverse_l,
                v: (l.m21 * a.x + l.m22 * a.y + l.m23) * inverse_l,
            },
            right: View {
                u: (r.m11 * b.x + r.m12 * b.y + r.m13) * inverse_r,
                v: (r.m21 * b.x + r.m22 * b.y + r.m23) * inverse_r,
            },
        })
    }

    /// `u_l - u_r`, unit depth; negative for points behind the cameras.
    #[inline(always)]
    pub(crate) fn disparity(&self) -> T {
        self.left.u - self.right.u
    }

    /// With the derivative of `v` by a left perturbation, `[-(1 + v^2), u v, u]` (eqs 14, 15), the
    /// baseline columns are differences of a left and a right one. They are written as products of
    /// the disparity `u_l - u_r`, so nothing cancels in far scenes.
    #[inline(always)]
    pub(crate) fn row(&self, gauge_slope: T) -> Row<T> {
        let (left, right) = (&self.left, &self.right);
        let offset = left.v - right.v;
        let disparity = self.disparity();
        Row {
            offset,
            jacobian: [
                -(T::ONE + left.v * left.v),
                left.u * left.v,
                left.u,
                disparity * left.v + right.u * offset,
                disparity - gauge_slope * offset * (left.v + right.v),
            ],
        }
    }
}

/// By one division for both: it is what a controller is slowest at.
#[inline(always)]
fn inverse_depths<T: Scalar>(left: T, right: T) -> Option<[T; 2]> {
    let least = T::lit(MIN_DEPTH);
    // Not `<`: a NaN must fail this test.
    if left >= least && right >= least {
        let inverse = T::ONE / (left * right);
        Some([inverse * right, inverse * left])
    } else {
        None
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::extrinsics::Extrinsics;
    use crate::so3;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    pub(crate) fn pose(rotation: [f64; 3], t: [f64; 2]) -> RectifyingRotations<f64> {
        let r = so3::exp(&Vector3::from(rotation)).unwrap();
        let [y, z] = t;
        let t = Vector3::new(-1.0, y, z);
        RectifyingRotations::from(&Extrinsics::try_new(r.matrix(), &t).unwrap())
    }

    /// Central difference of fourth order by the five unknowns.
    fn numeric(pose: &RectifyingRotations<f64>, pair: &RayPair<f64>) -> [f64; 5] {
        core::array::from_fn(|i| {
            let at = |h: f64| {
                let d: [f64; 5] = core::array::from_fn(|k| if k == i { h } else { 0.0 });
                let [x, y, z, by, bz] = d;
                let moved = pose.stepped(&Vector3::new(x, y, z), &Vector2::new(by, bz)).unwrap();
                row_offset(&moved, pair).unwrap()
            };
            let h = 1e-3;
            (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(1000))]

        #[test]
        fn analytic_jacobian_matches_central_differences_at_random_poses(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let pair = RayPair::try_new(left, right).unwrap();
            let row = linearised(&pose, pose.gauge_slope(), &pair).unwrap();
            prop_assert_eq!(row.offset, row_offset(&pose, &pair).unwrap());
            let numeric = numeric(&pose, &pair);
            let size = row.jacobian.iter().fold(0.0_f64, |m, j| m.max(j.abs()));
            for (analytic, numeric) in row.jacobian.iter().zip(numeric) {
                prop_assert!((analytic - numeric).abs() < 1e-8 * size, "{analytic} {numeric}");
            }
        }
    }

    #[test]
    fn a_ray_behind_the_rectified_plane_has_no_row() {
        let turned = pose([0.0, 0.9, 0.0], [0.0, 0.0]);
        let pair = RayPair::try_new([-2.0, 0.0], [0.0, 0.0]).unwrap();
        let other = RayPair::try_new([2.0, 0.0], [0.0, 0.0]).unwrap();
        let rows = [pair, other].map(|pair| row_offset(&turned, &pair));
        assert!(rows[0].is_some() != rows[1].is_some(), "{rows:?}");
    }
}
