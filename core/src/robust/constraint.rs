//! The epipolar constraint of a correspondence at a pose, its variance, and the derivatives of both,
//! without a division.
//!
//! With the rectified rays `a = R_l p_l`, `b = R_r p_r` it is `C = y_a z_b - z_a y_b`, the row offset of
//! eq 11 times `z_a z_b`. Noise of one variance on the four image coordinates gives it the variance
//! `V = y_a^2 + z_a^2 - g_a^2 + y_b^2 + z_b^2 - g_b^2` (to first order, at unit depth), with
//! `g_a = R_r[2][2] y_a - R_r[1][2] z_a` and `g_b` likewise of `R_l`. In the gauge of eq 8 `R_r[1][2]` is
//! zero. `C^2 / V` is the whitened row offset of [`crate::whitening`], squared.

use nalgebra::Matrix3;

use crate::lanes::{Lanes, Value};
use crate::rectification::RectifyingRotations;
use crate::residual::MIN_DEPTH;
use crate::scalar::Scalar;

/// What the correspondences of a pass have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame<V> {
    /// `R_l`, `R_r`, row by row.
    left: [[V; 3]; 3],
    right: [[V; 3]; 3],
    /// `c^2`, `1 - c^2` and `c R_r[2][2]` of `c = R_r[0][2]`.
    kappa: V,
    rest: V,
    rho: V,
    min_depth: V,
}

/// A correspondence at a pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constraint<V> {
    a: [V; 3],
    b: [V; 3],
    /// `g_b`.
    g: V,
    /// Half the derivatives of `V` by `y_b` and `z_b`.
    by_b: [V; 2],
    /// `C`.
    pub(super) value: V,
    /// Of `C`, by turn of `R` about rectified x, y, z, then of the baseline about y, z.
    pub(super) jacobian: [V; 5],
    /// `V`.
    pub(super) variance: V,
}

impl<V: Value> Frame<V> {
    #[inline(always)]
    pub(super) fn at<T: Scalar, L: Lanes<T, Value = V>>(
        lanes: L,
        pose: &RectifyingRotations<T>,
    ) -> Self {
        let (l, r) = (pose.left().matrix(), pose.right().matrix());
        let rows = |m: &Matrix3<T>| {
            let row = |x, y, z| [lanes.all(x), lanes.all(y), lanes.all(z)];
            [row(m.m11, m.m12, m.m13), row(m.m21, m.m22, m.m23), row(m.m31, m.m32, m.m33)]
        };
        let kappa = r.m13 * r.m13;
        Self {
            left: rows(l),
            right: rows(r),
            kappa: lanes.all(kappa),
            rest: lanes.all(T::ONE - kappa),
            rho: lanes.all(r.m13 * r.m33),
            min_depth: lanes.all(T::lit(MIN_DEPTH)),
        }
    }
}

impl<V: Value> Constraint<V> {
    /// And whether it is in front of both cameras; if not, it says nothing.
    ///
    /// * `rays`: `x_l`, `y_l`, `x_r`, `y_r`, unit depth.
    #[inline(always)]
    pub(super) fn of<T: Scalar, L: Lanes<T, Value = V>>(
        lanes: L,
        frame: &Frame<V>,
        [x_l, y_l, x_r, y_r]: [V; 4],
    ) -> (Self, L::Mask) {
        let a = turned(lanes, &frame.left, x_l, y_l);
        let b = turned(lanes, &frame.right, x_r, y_r);
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (a, b);
        let [_, [_, _, l_23], [_, _, l_33]] = frame.left;
        let g = lanes.less_product(l_33 * y_b, l_23, z_b);
        let by_b = [lanes.less_product(y_b, l_33, g), lanes.mul_add(l_23, g, z_b)];
        let [by_y, by_z] = by_b;
        let of_b = lanes.mul_add(by_y, y_b, by_z * z_b);
        let variance = lanes.mul_add(frame.kappa * y_a, y_a, lanes.mul_add(z_a, z_a, of_b));
        let (across, ahead) = (x_a * y_b, x_a * z_b);
        let constraint = Self {
            a,
            b,
            g,
            by_b,
            value: lanes.less_product(y_a * z_b, z_a, y_b),
            jacobian: [
                lanes.all(T::MINUS_ONE) * lanes.mul_add(y_a, y_b, z_a * z_b),
                across,
                ahead,
                lanes.less_product(across, x_b, y_a),
                lanes.less_product(ahead, x_b, z_a),
            ],
            variance,
        };
        let least = frame.min_depth;
        (constraint, lanes.both(lanes.at_least(z_a, least), lanes.at_least(z_b, least)))
    }

    /// Whether its disparity is no less than so much, at unit depth.
    #[inline(always)]
    pub(super) fn has_disparity<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        least: V,
    ) -> L::Mask {
        let ([.., z_a], [.., z_b]) = (self.a, self.b);
        let [.., disparity] = self.jacobian;
        lanes.at_least(disparity, least * (z_a * z_b))
    }

    /// The row offset of eq 11, unit depth.
    #[cfg(feature = "simd")]
    #[inline(always)]
    pub(super) fn offset(&self) -> V {
        let ([.., z_a], [.., z_b]) = (self.a, self.b);
        self.value / (z_a * z_b)
    }

    /// The nine products of the rays that [`crate::moments`] sums, times `z_a z_b`.
    #[cfg(feature = "simd")]
    #[inline(always)]
    pub(super) fn products<T: Scalar, L: Lanes<T, Value = V>>(&self, lanes: L) -> [V; 9] {
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (self.a, self.b);
        let [_, _, _, down, disparity] = self.jacobian;
        [
            self.value,
            lanes.all(T::MINUS_ONE) * disparity,
            down,
            x_a * x_b,
            y_a * y_b,
            z_a * z_b,
            lanes.mul_add(x_a, y_b, y_a * x_b),
            lanes.mul_add(x_a, z_b, z_a * x_b),
            lanes.mul_add(y_a, z_b, z_a * y_b),
        ]
    }

    /// Derivatives of `C / sqrt V` times `sqrt V`.
    ///
    /// * `share`: `C / V`.
    #[inline(always)]
    pub(super) fn whole<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        frame: &Frame<V>,
        share: V,
    ) -> [V; 5] {
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (self.a, self.b);
        let [[_, _, l_13], [_, _, l_23], [_, _, l_33]] = frame.left;
        let [by_y, by_z] = self.by_b;
        let (a_yz, h) = (y_a * z_a, l_13 * self.g);
        let turned = lanes.mul_add(l_23, y_b, l_33 * z_b);
        let about_x = lanes.less_product(frame.rest * a_yz, self.g, turned);
        let about_y = lanes.less_product(h * y_b, x_a, z_a);
        let about_z = lanes.mul_add(h, z_b, frame.kappa * (x_a * y_a));
        let both_y = lanes.mul_add(frame.rho * y_a, y_a, lanes.less_product(about_y, x_b, by_z));
        let both_z = lanes.mul_add(frame.rho, a_yz, lanes.mul_add(x_b, by_y, about_z));
        let [j0, j1, j2, j3, j4] = self.jacobian;
        [
            lanes.less_product(j0, share, about_x),
            lanes.less_product(j1, share, about_y),
            lanes.less_product(j2, share, about_z),
            lanes.less_product(j3, share, both_y),
            lanes.less_product(j4, share, both_z),
        ]
    }
}

/// A rotation of the ray `(x, y, 1)`.
#[inline(always)]
fn turned<T: Scalar, L: Lanes<T>>(
    lanes: L,
    [r1, r2, r3]: &[[L::Value; 3]; 3],
    x: L::Value,
    y: L::Value,
) -> [L::Value; 3] {
    [
        lanes.mul_add(r1[0], x, lanes.mul_add(r1[1], y, r1[2])),
        lanes.mul_add(r2[0], x, lanes.mul_add(r2[1], y, r2[2])),
        lanes.mul_add(r3[0], x, lanes.mul_add(r3[1], y, r3[2])),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::correspondence::RayPair;
    use crate::lanes::Single;
    use crate::residual::Sight;
    use crate::residual::tests::pose;
    use crate::whitening::Whitening;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn whitened_it_is_the_whitened_row_offset_with_its_derivatives(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let sight = Sight::of(&pose, &RayPair::try_new(left, right).unwrap()).unwrap();
            let whitening = Whitening::at(&pose);
            let of_offset = whitening.variance(&sight);
            let row = whitening.whole(&whitening.row(&sight), &sight, &of_offset);
            let frame = Frame::at(Single, &pose);
            let rays = [left, right].as_flattened().try_into().unwrap();
            let (constraint, in_front) = Constraint::of(Single, &frame, rays);
            prop_assert!(in_front);
            let Constraint { value, variance, .. } = constraint;
            let whole = constraint.whole(Single, &frame, value / variance);
            let [sd, sd_of_offset] = [variance.sqrt(), of_offset.value().sqrt()];
            prop_assert!((value / sd - row.offset / sd_of_offset).abs() < 1e-13);
            let size = row.jacobian.iter().fold(0.0_f64, |m, j| m.max(j.abs())) / sd_of_offset;
            for (one, other) in whole.iter().zip(&row.jacobian) {
                let miss = one / sd - other / sd_of_offset;
                prop_assert!(miss.abs() < 1e-13 * size, "{whole:?} {row:?}");
            }
            let least = sight.disparity() - 1e-9;
            prop_assert!(constraint.has_disparity(Single, least));
            prop_assert!(!constraint.has_disparity(Single, least + 2e-9));
        }
    }
}
