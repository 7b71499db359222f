//! Row offset of a correspondence after rectification (eq 11 with `u = x/z`, `v = y/z`).

use super::correspondence::RayPair;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::MIN_DEPTH;

/// Variance of a row offset or of a disparity over the variance of a coordinate. Both views contribute their noise.
pub(crate) const DIFFERENCE_VARIANCE: f64 = 2.0;

/// Returns the row offset `e_i = v_l - v_r` of eq 11 between the rectified rays, at unit depth, dimensionless. Its
/// product with the focal length in px is the row offset in px.
///
/// `None` if a rectified depth is below 0.05: the ray points backwards or almost sideways in the rectified frame. Cost:
/// one division.
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

/// Returns [`row_offset`] in pixels of the images over the mean focal length, dimensionless.
pub(crate) fn pixel_row_offset<T: Scalar>(
    rotations: &RectifyingRotations<T>,
    pair: &RayPair<T>,
) -> Option<T> {
    row_offset(rotations, pair).map(|offset| offset / pair.scale())
}

/// Returns whether the magnitude of the row offset at a pose is at most `most`, in pixels over the focal length.
pub(crate) fn is_within_rows<T: Scalar>(
    pair: &RayPair<T>,
    pose: &RectifyingRotations<T>,
    most: T,
) -> bool {
    pixel_row_offset(pose, pair).is_some_and(|offset| offset.abs() <= most)
}

/// Returns the inverses of two depths, with only one division, which is the slowest instruction of a controller. `None`
/// if a depth is below [`MIN_DEPTH`] or NaN.
#[inline(always)]
pub(crate) fn inverse_depths<T: Scalar>(left: T, right: T) -> Option<[T; 2]> {
    let least = T::lit(MIN_DEPTH);
    // The test is written so that a NaN fails it.
    if left >= least && right >= least {
        let inverse = T::ONE / (left * right);
        Some([inverse * right, inverse * left])
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::rectification::tests::pose;

    #[test]
    fn a_ray_that_points_backwards_in_the_rectified_frame_has_no_row() {
        let turned = pose([0.0, 0.9, 0.0], [0.0, 0.0]);
        let row = |x| row_offset(&turned, &RayPair::try_new([x, 0.0], [0.0, 0.0]).unwrap());
        assert!(row(-2.0).is_some() != row(2.0).is_some(), "{:?} {:?}", row(-2.0), row(2.0));
    }
}
