//! The epipolar constraint of a correspondence at a pose, its variance, and the derivatives of both,
//! without a division.
//!
//! With the rectified rays `a = R_l p_l`, `b = R_r p_r` it is `C = y_a z_b - z_a y_b`, the row offset of
//! eq 11 times `z_a z_b`. Noise of one variance on the four image coordinates gives it the variance
//! `V = y_a^2 + z_a^2 - g_a^2 + y_b^2 + z_b^2 - g_b^2` (to first order, at unit depth), with
//! `g_a = R_r[2][2] y_a - R_r[1][2] z_a` and `g_b` likewise of `R_l`. In the gauge of eq 8 `R_r[1][2]` is
//! zero. `C / sqrt V` is the row offset over its own standard deviation (Sampson). Nothing is divided by
//! the root: squares and products of whitened quantities are those of plain ones over the variance.

use nalgebra::Matrix3;

use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Value};
use crate::thresholds::MIN_DEPTH;

/// What the correspondences of a pass have in common.
#[derive(Debug, Clone, Copy)]
pub(super) struct PoseTerms<V> {
    /// `R_l`, `R_r`, row by row.
    left: [[V; 3]; 3],
    right: [[V; 3]; 3],
    /// `c^2`, `1 - c^2` and `c R_r[2][2]` of `c = R_r[0][2]`.
    kappa: V,
    rest: V,
    rho: V,
    pub(super) min_depth: V,
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

impl<V: Value> PoseTerms<V> {
    #[inline(always)]
    pub(super) fn at<T: Scalar, L: Lanes<T, Value = V>>(
        lanes: L,
        pose: &RectifyingRotations<T>,
    ) -> Self {
        let (l, r) = (pose.left().matrix(), pose.right().matrix());
        let rows = |m: &Matrix3<T>| {
            let row = |x, y, z| [lanes.splat(x), lanes.splat(y), lanes.splat(z)];
            [row(m.m11, m.m12, m.m13), row(m.m21, m.m22, m.m23), row(m.m31, m.m32, m.m33)]
        };
        let kappa = r.m13 * r.m13;
        Self {
            left: rows(l),
            right: rows(r),
            kappa: lanes.splat(kappa),
            rest: lanes.splat(T::ONE - kappa),
            rho: lanes.splat(r.m13 * r.m33),
            min_depth: lanes.splat(T::lit(MIN_DEPTH)),
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
        frame: &PoseTerms<V>,
        [x_l, y_l, x_r, y_r]: [V; 4],
    ) -> (Self, L::Mask) {
        let a = turned(lanes, &frame.left, x_l, y_l);
        let b = turned(lanes, &frame.right, x_r, y_r);
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (a, b);
        let [_, [_, _, l_23], [_, _, l_33]] = frame.left;
        let g = lanes.neg_mul_add(l_23, z_b, l_33 * y_b);
        let by_b = [lanes.neg_mul_add(l_33, g, y_b), lanes.mul_add(l_23, g, z_b)];
        let [by_y, by_z] = by_b;
        let of_b = lanes.mul_add(by_y, y_b, by_z * z_b);
        let variance = lanes.mul_add(frame.kappa * y_a, y_a, lanes.mul_add(z_a, z_a, of_b));
        let (across, ahead) = (x_a * y_b, x_a * z_b);
        let constraint = Self {
            a,
            b,
            g,
            by_b,
            value: lanes.neg_mul_add(z_a, y_b, y_a * z_b),
            jacobian: [
                lanes.splat(T::MINUS_ONE) * lanes.mul_add(y_a, y_b, z_a * z_b),
                across,
                ahead,
                lanes.neg_mul_add(x_b, y_a, across),
                lanes.neg_mul_add(x_b, z_a, ahead),
            ],
            variance,
        };
        let least = frame.min_depth;
        (constraint, lanes.and(lanes.ge(z_a, least), lanes.ge(z_b, least)))
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
        lanes.ge(disparity, least * (z_a * z_b))
    }

    /// The row offset of eq 11, unit depth.
    #[inline(always)]
    pub(super) fn row_offset(&self) -> V {
        let ([.., z_a], [.., z_b]) = (self.a, self.b);
        self.value / (z_a * z_b)
    }

    /// The nine products of the rays that [`crate::algebra::moments`] sums, times `z_a z_b`.
    #[inline(always)]
    pub(super) fn products<T: Scalar, L: Lanes<T, Value = V>>(&self, lanes: L) -> [V; 9] {
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (self.a, self.b);
        let [_, _, _, down, disparity] = self.jacobian;
        [
            self.value,
            lanes.splat(T::MINUS_ONE) * disparity,
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
    pub(super) fn whitened_jacobian<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        frame: &PoseTerms<V>,
        share: V,
    ) -> [V; 5] {
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (self.a, self.b);
        let [[_, _, l_13], [_, _, l_23], [_, _, l_33]] = frame.left;
        let [by_y, by_z] = self.by_b;
        let (a_yz, h) = (y_a * z_a, l_13 * self.g);
        let turned = lanes.mul_add(l_23, y_b, l_33 * z_b);
        let about_x = lanes.neg_mul_add(self.g, turned, frame.rest * a_yz);
        let about_y = lanes.neg_mul_add(x_a, z_a, h * y_b);
        let about_z = lanes.mul_add(h, z_b, frame.kappa * (x_a * y_a));
        let both_y = lanes.mul_add(frame.rho * y_a, y_a, lanes.neg_mul_add(x_b, by_z, about_y));
        let both_z = lanes.mul_add(frame.rho, a_yz, lanes.mul_add(x_b, by_y, about_z));
        let [j0, j1, j2, j3, j4] = self.jacobian;
        [
            lanes.neg_mul_add(share, about_x, j0),
            lanes.neg_mul_add(share, about_y, j1),
            lanes.neg_mul_add(share, about_z, j2),
            lanes.neg_mul_add(share, both_y, j3),
            lanes.neg_mul_add(share, both_z, j4),
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
#[cfg(feature = "paper")]
mod tests {
    use super::*;
    use crate::batch::correspondence::RayPair;
    use crate::geometry::rectification::tests::pose;
    use crate::paper::residual::RectifiedPair;
    use crate::simd::Single;
    use nalgebra::{Vector2, Vector3};
    use proptest::prelude::*;

    fn at(pose: &RectifyingRotations<f64>, left: [f64; 2], right: [f64; 2]) -> Constraint<f64> {
        let rays = [left, right].as_flattened().try_into().unwrap();
        let (constraint, in_front) = Constraint::of(Single, &PoseTerms::at(Single, pose), rays);
        assert!(in_front);
        constraint
    }

    /// `C / sqrt V`.
    fn whitened(pose: &RectifyingRotations<f64>, left: [f64; 2], right: [f64; 2]) -> f64 {
        let Constraint { value, variance, .. } = at(pose, left, right);
        value / variance.sqrt()
    }

    proptest! {
        #[test]
        fn jacobian_matches_central_differences(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let constraint = at(&pose, left, right);
            let Constraint { value, variance, jacobian, .. } = constraint;
            let frame = PoseTerms::at(Single, &pose);
            let whole = constraint.whitened_jacobian(Single, &frame, value / variance);
            let moved = |i: usize, h: f64, of: &dyn Fn(&RectifyingRotations<f64>) -> f64| {
                let at = |h: f64| {
                    let d: [f64; 5] = core::array::from_fn(|k| if k == i { h } else { 0.0 });
                    let [x, y, z, by, bz] = d;
                    of(&pose.stepped(&Vector3::new(x, y, z), &Vector2::new(by, bz)).unwrap())
                };
                (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h)
            };
            let size = whole.iter().fold(0.0_f64, |m, j| m.max(j.abs())) / variance.sqrt();
            for (i, whole) in whole.into_iter().enumerate() {
                let numeric = moved(i, 1e-3, &|pose| whitened(pose, left, right));
                let miss = whole / variance.sqrt() - numeric;
                prop_assert!(miss.abs() < 1e-8 * size, "{i}: {whole} {numeric}");
            }
            let size = jacobian.iter().fold(0.0_f64, |m, j| m.max(j.abs()));
            for (i, of_value) in jacobian.into_iter().enumerate() {
                let numeric = moved(i, 1e-3, &|pose| at(pose, left, right).value);
                prop_assert!((of_value - numeric).abs() < 1e-8 * size, "{i}: {of_value} {numeric}");
            }
        }

        #[test]
        fn it_is_the_row_offset_times_the_depths_and_one_of_the_products_of_the_rays(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let constraint = at(&pose, left, right);
            let sight = RectifiedPair::of(&pose, &RayPair::try_new(left, right).unwrap()).unwrap();
            prop_assert!((constraint.row_offset() - (sight.left.v - sight.right.v)).abs() < 1e-14);
            let a = pose.left() * Vector3::new(left[0], left[1], 1.0);
            let b = pose.right() * Vector3::new(right[0], right[1], 1.0);
            let (apart, outer) = (a.cross(&b), b * a.transpose());
            let together = outer + outer.transpose();
            let products = [
                apart.x, apart.y, apart.z, outer.m11, outer.m22, outer.m33,
                together.m12, together.m13, together.m23,
            ];
            for (ours, product) in constraint.products(Single).iter().zip(products) {
                prop_assert!((ours - product).abs() < 1e-14, "{ours} {product}");
            }
            let least = sight.disparity() - 1e-9;
            prop_assert!(constraint.has_disparity(Single, least));
            prop_assert!(!constraint.has_disparity(Single, least + 2e-9));
        }

        #[test]
        fn unit_noise_on_the_coordinates_gives_it_unit_deviation(
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
                        whitened(&pose, left, [right[0] + d(2), right[1] + d(3)])
                    };
                    ((moved(h) - moved(-h)) / (2.0 * h)).powi(2)
                })
                .sum();
            prop_assert!((gradient_squared - 1.0).abs() < 1e-6, "{gradient_squared}");
        }
    }

    /// Central difference of fourth order.
    fn difference(of: impl Fn(f64) -> f64) -> f64 {
        let h = 1e-3;
        (8.0 * (of(h) - of(-h)) - (of(2.0 * h) - of(-2.0 * h))) / (12.0 * h)
    }

    proptest! {
        #[test]
        fn variance_is_the_squared_gradient_of_the_constraint_off_the_epipolar_line_too(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let gradient_squared: f64 = (0..4_usize)
                .map(|i| {
                    let d = |k: usize, h: f64| if k == i { h } else { 0.0 };
                    let value = |h: f64| {
                        let left = [left[0] + d(0, h), left[1] + d(1, h)];
                        at(&pose, left, [right[0] + d(2, h), right[1] + d(3, h)]).value
                    };
                    difference(value).powi(2)
                })
                .sum();
            let variance = at(&pose, left, right).variance;
            prop_assert!((variance / gradient_squared - 1.0).abs() < 1e-9);
        }

        #[test]
        fn half_the_derivatives_of_the_variance_match_central_differences(
            rotation in [-0.2..0.2, -0.2..0.2, -0.2..0.2], t in [-0.3..0.3, -0.3..0.3],
            left in [-0.7..0.7, -0.5..0.5], right in [-0.7..0.7, -0.5..0.5],
        ) {
            let pose = pose(rotation, t);
            let constraint = at(&pose, left, right);
            // With `C / V` = 1 they are all that the whitened derivatives differ by.
            let whole = constraint.whitened_jacobian(Single, &PoseTerms::at(Single, &pose), 1.0);
            for (i, (plain, whole)) in constraint.jacobian.into_iter().zip(whole).enumerate() {
                let variance = |h: f64| {
                    let moved = pose.stepped_by(&(nalgebra::Vector5::ith(i, h))).unwrap();
                    at(&moved, left, right).variance
                };
                let half = difference(variance) / 2.0;
                prop_assert!((plain - whole - half).abs() < 1e-9, "{i}: {} {half}", plain - whole);
            }
        }
    }
}
