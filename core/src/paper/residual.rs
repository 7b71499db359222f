//! Row offset of one correspondence and its derivatives (eqs 9-15 with `u = x/z`, `v = y/z`).
//!
//! Input: rays at unit depth, dimensionless. Output: the difference `e_i = v_l - v_r` of the rectified rays,
//! dimensionless; times the focal length it is in pixels. Departures from the paper, each with a test:
//! - The five unknowns are the turns of `R` (3) and of the baseline (2), and not the turns of `R_l` and `R_r`. The
//!   steps are the same. With the unknowns of the paper, the columns of the Jacobian are nearly parallel in far scenes,
//!   which `f32` does not resolve. With these unknowns they are not, and the information belongs to `R` and `t`.
//! - The step keeps eq 8, so the row `e_0` and the sixth unknown are not needed.
//! - A ray of rectified depth below [`MIN_DEPTH`](crate::thresholds::MIN_DEPTH) is skipped and counted; the paper
//!   divides by this depth.

use nalgebra::Vector2;

use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::inverse_depths;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Residual and derivatives of one correspondence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row<T> {
    /// `e_i`, at unit depth.
    pub(super) offset: T,
    /// Derivatives by the turns of `R` about rectified x, y, z, then by the turns of the baseline about y, z.
    pub(super) jacobian: [T; 5],
}

/// Returns `e_i` and its derivatives by the unknowns of [`RectifyingRotations::stepped`]; `None` if a rectified depth
/// is below [`MIN_DEPTH`](crate::thresholds::MIN_DEPTH).
#[inline(always)]
pub(super) fn linearised<T: Scalar>(
    rotations: &RectifyingRotations<T>,
    gauge_slope: T,
    pair: &RayPair<T>,
) -> Option<Row<T>> {
    Some(RectifiedPair::of(rotations, pair)?.row(gauge_slope))
}

/// One side of a correspondence: its rectified ray `(u, v)` at unit depth.
#[derive(Debug, Clone, Copy)]
pub(super) struct RectifiedRay<T> {
    pub(super) u: T,
    pub(super) v: T,
}

/// A correspondence after rectification.
#[derive(Debug, Clone, Copy)]
pub(super) struct RectifiedPair<T> {
    pub(super) left: RectifiedRay<T>,
    pub(super) right: RectifiedRay<T>,
}

impl<T: Scalar> RectifiedPair<T> {
    /// Returns the rectified correspondence; `None` if a rectified depth is below
    /// [`MIN_DEPTH`](crate::thresholds::MIN_DEPTH).
    #[inline(always)]
    pub(super) fn of(rotations: &RectifyingRotations<T>, pair: &RayPair<T>) -> Option<Self> {
        let (l, r) = (rotations.left().matrix(), rotations.right().matrix());
        let (a, b): (&Vector2<T>, &Vector2<T>) = (&pair.left, &pair.right);
        let [inverse_l, inverse_r] =
            inverse_depths(l.m31 * a.x + l.m32 * a.y + l.m33, r.m31 * b.x + r.m32 * b.y + r.m33)?;
        Some(Self {
            left: RectifiedRay {
                u: (l.m11 * a.x + l.m12 * a.y + l.m13) * inverse_l,
                v: (l.m21 * a.x + l.m22 * a.y + l.m23) * inverse_l,
            },
            right: RectifiedRay {
                u: (r.m11 * b.x + r.m12 * b.y + r.m13) * inverse_r,
                v: (r.m21 * b.x + r.m22 * b.y + r.m23) * inverse_r,
            },
        })
    }

    /// Returns the disparity `u_l - u_r` at unit depth; negative for points behind the cameras.
    #[inline(always)]
    pub(super) fn disparity(&self) -> T {
        self.left.u - self.right.u
    }

    /// Returns the row offset and its derivatives. A left perturbation changes `v` by `[-(1 + v^2), u v, u]` (eqs 14,
    /// 15). The baseline columns are differences of a left and a right column. They are written as products with the
    /// disparity or the row offset, so that nothing cancels in far scenes.
    ///
    /// * `gauge_slope`: `s`, turn about x per turn of the baseline about z, dimensionless.
    #[inline(always)]
    pub(super) fn row(&self, gauge_slope: T) -> Row<T> {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::row_offset::row_offset;
    use crate::geometry::rectification::tests::pose;
    use nalgebra::Vector3;
    use proptest::prelude::*;

    /// Returns the central differences of fourth order by the five unknowns.
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
}
