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

use nalgebra::{Matrix3, Vector2};

use crate::correspondence::RayPair;
use crate::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Smallest depth of a rectified unit-depth ray: 87 degrees off the rectified axis.
const MIN_DEPTH: f64 = 0.05;

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
    let left = rectified(rotations.left().matrix(), &pair.left)?;
    let right = rectified(rotations.right().matrix(), &pair.right)?;
    Some(left.y - right.y)
}

/// `e_i` with its derivatives for [`RectifyingRotations::stepped`].
///
/// With the derivative of `v` by a left perturbation, `[-(1 + v^2), u v, u]` (eqs 14, 15), the
/// baseline columns are differences of a left and a right one. They are written as products of the
/// disparity `u_l - u_r`, so nothing cancels in far scenes.
pub(crate) fn linearised<T: Scalar>(
    rotations: &RectifyingRotations<T>,
    gauge_slope: T,
    pair: &RayPair<T>,
) -> Option<Row<T>> {
    let left = rectified(rotations.left().matrix(), &pair.left)?;
    let right = rectified(rotations.right().matrix(), &pair.right)?;
    let offset = left.y - right.y;
    let disparity = left.x - right.x;
    Some(Row {
        offset,
        jacobian: [
            -(T::ONE + left.y * left.y),
            left.x * left.y,
            left.x,
            disparity * left.y + right.x * offset,
            disparity - gauge_slope * offset * (left.y + right.y),
        ],
    })
}

/// `(u, v)` of a ray after rotation.
fn rectified<T: Scalar>(r: &Matrix3<T>, ray: &Vector2<T>) -> Option<Vector2<T>> {
    let x = r.m11 * ray.x + r.m12 * ray.y + r.m13;
    let y = r.m21 * ray.x + r.m22 * ray.y + r.m23;
    let z = r.m31 * ray.x + r.m32 * ray.y + r.m33;
    if z >= T::lit(MIN_DEPTH) {
        let inverse = T::ONE / z;
        Some(Vector2::new(x * inverse, y * inverse))
    } else {
        None
    }
}
