//! Epipolar constraint of a correspondence at a pose, its variance, and the derivatives of constraint and variance.
//! These expressions need no division.
//!
//! Rectified rays `a = R_l p_l`, `b = R_r p_r` give the constraint `C = y_a z_b - z_a y_b`, which is the row offset of
//! eq 11 times `z_a z_b`. If the four image coordinates at unit depth have unit variance, `C` has to first order the
//! variance `V = y_a^2 + z_a^2 - g_a^2 + y_b^2 + z_b^2 - g_b^2`, times `s^2` for the local scale `s` of the lenses. Here
//! `g_a = R_r[2][2] y_a - R_r[1][2] z_a`, and `g_b = R_l[2][2] y_b - R_l[1][2] z_b`. The gauge of eq 8 makes `R_r[1][2]`
//! zero. `C / sqrt V` is the whitened residual (Sampson). No square root is needed, because only squares and products of
//! whitened quantities occur. They are the squares and products of the unwhitened quantities, divided by `V`. Derivation:
//! `ESTIMATOR.md`, sections 2 to 4.

use nalgebra::Matrix3;

use crate::algebra::moments::COORDINATES;
use crate::batch::correspondence::RayPair;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::MIN_DEPTH;

/// Coefficients of a pose, shared by the correspondences of a pass; dimensionless.
#[derive(Debug, Clone, Copy)]
pub(super) struct PoseTerms<T> {
    /// `R_l`, row by row.
    left: [[T; 3]; 3],
    /// `R_r`, row by row.
    right: [[T; 3]; 3],
    /// `R_r[0][2]^2`.
    kappa: T,
    /// `1 - kappa`.
    rest: T,
    /// `R_r[0][2] R_r[2][2]`.
    rho: T,
}

/// Constraint of a correspondence at a pose; dimensionless.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constraint<T> {
    /// Rectified rays, left and right.
    a: [T; 3],
    b: [T; 3],
    /// `g_b`.
    g: T,
    /// Half the derivatives of `V` with respect to `y_b` and `z_b`.
    by_b: [T; 2],
    /// `s`: local scale of the lenses ([`RayPair::scale`]), and its square.
    scale: T,
    pub(super) scale_squared: T,
    /// `C`.
    pub(super) value: T,
    /// Derivatives of `C`, 1/rad: with respect to rotations of `R` about rectified x, y, z, then of the baseline about
    /// y, z.
    pub(super) jacobian: [T; 5],
    /// `V s^2`.
    pub(super) variance: T,
}

impl<T: Scalar> PoseTerms<T> {
    pub(super) fn at(pose: &RectifyingRotations<T>) -> Self {
        let (l, r) = (pose.left().matrix(), pose.right().matrix());
        let rows =
            |m: &Matrix3<T>| [[m.m11, m.m12, m.m13], [m.m21, m.m22, m.m23], [m.m31, m.m32, m.m33]];
        let kappa = r.m13 * r.m13;
        Self { left: rows(l), right: rows(r), kappa, rest: T::ONE - kappa, rho: r.m13 * r.m33 }
    }
}

impl<T: Scalar> Constraint<T> {
    /// Returns the constraint of a correspondence; `None` if a ray has a rectified depth below [`MIN_DEPTH`].
    ///
    /// * `frame`: coefficients of the pose; `pair`: undistorted rays in the camera frames, unit depth.
    #[inline(always)]
    pub(super) fn of(frame: &PoseTerms<T>, pair: &RayPair<T>) -> Option<Self> {
        let [x_l, y_l, x_r, y_r] = pair.rays();
        let (a, b) = (rotated(&frame.left, x_l, y_l), rotated(&frame.right, x_r, y_r));
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (a, b);
        let least = T::lit(MIN_DEPTH);
        if !(z_a >= least && z_b >= least) {
            return None;
        }
        let [_, [_, _, l_23], [_, _, l_33]] = frame.left;
        let g = l_33 * y_b - l_23 * z_b;
        let by_b @ [by_y, by_z] = [y_b - l_33 * g, z_b + l_23 * g];
        let of_b = by_y * y_b + by_z * z_b;
        let (across, ahead) = (x_a * y_b, x_a * z_b);
        let scale = pair.scale();
        let scale_squared = scale * scale;
        Some(Self {
            scale,
            scale_squared,
            a,
            b,
            g,
            by_b,
            value: y_a * z_b - z_a * y_b,
            jacobian: [
                -(y_a * y_b + z_a * z_b),
                across,
                ahead,
                across - x_b * y_a,
                ahead - x_b * z_a,
            ],
            variance: (of_b + z_a * z_a + frame.kappa * y_a * y_a) * scale_squared,
        })
    }

    /// Returns whether the disparity in pixels is at least `least`, both over the focal length. The comparison needs no
    /// division.
    pub(super) fn has_disparity(&self, least: T) -> bool {
        let [disparity, least] = self.disparity_over(least);
        disparity >= least
    }

    /// Returns the disparity at unit depth, and `least`, in pixels over the focal length; each multiplied by the depths
    /// `z_a z_b` of the rectified rays, and `least` also by the local scale.
    pub(super) fn disparity_over(&self, least: T) -> [T; 2] {
        let ([.., z_a], [.., z_b]) = (self.a, self.b);
        let [.., disparity] = self.jacobian;
        [disparity, least * self.scale * (z_a * z_b)]
    }

    /// Returns the row offset of eq 11 in pixels over the focal length, dimensionless.
    pub(super) fn row_offset(&self) -> T {
        let ([.., z_a], [.., z_b]) = (self.a, self.b);
        self.value / (z_a * z_b * self.scale)
    }

    /// Returns the coordinates `k` that [`crate::algebra::moments`] sums. Nine are products of the rays, from `b a^T`:
    /// `cx`, `cy`, `cz`, `xx`, `yy`, `zz`, `xy`, `xz`, `yz`. Three are derivatives of `C` with respect to the lens:
    /// `k1` of the left camera, `k1` of the right camera, and the difference of `p1`, right minus left.
    ///
    /// * `rays`: as in [`Self::of`].
    pub(super) fn coordinates(
        &self,
        frame: &PoseTerms<T>,
        [x_l, y_l, x_r, y_r]: [T; 4],
    ) -> [T; COORDINATES] {
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (self.a, self.b);
        let [_, [_, r_22, _], [_, r_32, r_33]] = frame.right;
        let (rows_l, rows_r) = (y_l * y_l, y_r * y_r);
        let (squared_l, squared_r) = (x_l * x_l + rows_l, x_r * x_r + rows_r);
        // A change of the lens changes `V` too. The share of each camera in `V` is taken as half.
        let scaled = |squared: T, rows: T| self.value * (rows - T::HALF * squared);
        let [_, _, _, down, disparity] = self.jacobian;
        [
            self.value,
            -disparity,
            down,
            x_a * x_b,
            y_a * y_b,
            z_a * z_b,
            x_a * y_b + y_a * x_b,
            x_a * z_b + z_a * x_b,
            y_a * z_b + z_a * y_b,
            scaled(squared_l, rows_l) - squared_l * self.g,
            scaled(squared_r, rows_r) + squared_r * (r_33 * y_a),
            (squared_r + rows_r + rows_r) * (r_22 * z_a - r_32 * y_a),
        ]
    }

    /// Returns the derivatives of `C / sqrt V` times `sqrt V`, 1/rad: `J - (C / V) dV / 2`. The local scale has no
    /// effect.
    ///
    /// * `share`: `C / (V s^2)`, dimensionless.
    #[inline(always)]
    pub(super) fn whitened_jacobian(&self, frame: &PoseTerms<T>, share: T) -> [T; 5] {
        let share = share * self.scale_squared;
        let ([x_a, y_a, z_a], [x_b, y_b, z_b]) = (self.a, self.b);
        let [[_, _, l_13], [_, _, l_23], [_, _, l_33]] = frame.left;
        let [by_y, by_z] = self.by_b;
        let (a_yz, h) = (y_a * z_a, l_13 * self.g);
        let about_x = frame.rest * a_yz - self.g * (l_33 * z_b + l_23 * y_b);
        let about_y = h * y_b - x_a * z_a;
        let about_z = frame.kappa * (x_a * y_a) + h * z_b;
        let both_y = about_y - x_b * by_z + frame.rho * y_a * y_a;
        let both_z = about_z + x_b * by_y + frame.rho * a_yz;
        let [j0, j1, j2, j3, j4] = self.jacobian;
        [
            j0 - share * about_x,
            j1 - share * about_y,
            j2 - share * about_z,
            j3 - share * both_y,
            j4 - share * both_z,
        ]
    }
}

/// Rotates the ray `(x, y, 1)` by the matrix with rows `r1`, `r2`, `r3`.
#[inline(always)]
fn rotated<T: Scalar>([r1, r2, r3]: &[[T; 3]; 3], x: T, y: T) -> [T; 3] {
    [
        r1[0] * x + (r1[1] * y + r1[2]),
        r2[0] * x + (r2[1] * y + r2[2]),
        r3[0] * x + (r3[1] * y + r3[2]),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::row_offset::row_offset;
    use crate::geometry::rectification::tests::pose;
    use nalgebra::{Vector3, Vector5};
    use proptest::prelude::*;

    type Rays = [f64; 4];

    /// Generates a pose, and rays `x_l`, `y_l`, `x_r`, `y_r` on any rows.
    fn scene() -> impl Strategy<Value = (RectifyingRotations<f64>, Rays)> {
        let rays = [-0.7..0.7, -0.5..0.5, -0.7..0.7, -0.5..0.5];
        ([-0.2..0.2, -0.2..0.2, -0.2..0.2], [-0.3..0.3, -0.3..0.3], rays)
            .prop_map(|(rotation, t, rays)| (pose(rotation, t), rays))
    }

    fn at(pose: &RectifyingRotations<f64>, rays: Rays) -> Constraint<f64> {
        Constraint::of(&PoseTerms::at(pose), &RayPair::of_rays(rays)).unwrap()
    }

    /// Returns `C / sqrt V`.
    fn whitened(pose: &RectifyingRotations<f64>, rays: Rays) -> f64 {
        let Constraint { value, variance, .. } = at(pose, rays);
        value / variance.sqrt()
    }

    /// Returns the central difference of fourth order.
    fn difference(of: impl Fn(f64) -> f64) -> f64 {
        let h = 1e-3;
        (8.0 * (of(h) - of(-h)) - (of(2.0 * h) - of(-2.0 * h))) / (12.0 * h)
    }

    /// Returns the derivatives with respect to the five unknowns of the pose, by central differences.
    fn by_pose(
        pose: &RectifyingRotations<f64>,
        of: impl Fn(&RectifyingRotations<f64>) -> f64,
    ) -> [f64; 5] {
        let moved = |i, h| pose.stepped_by(&Vector5::ith(i, h)).unwrap();
        core::array::from_fn(|i| difference(|h| of(&moved(i, h))))
    }

    /// Returns the squared length of the gradient with respect to the four image coordinates.
    fn gradient_squared(rays: Rays, of: impl Fn(Rays) -> f64) -> f64 {
        let moved = |i, h| core::array::from_fn(|k| rays[k] + if k == i { h } else { 0.0 });
        (0..4_usize).map(|i| difference(|h| of(moved(i, h))).powi(2)).sum()
    }

    proptest! {
        #[test]
        fn jacobian_matches_central_differences((pose, rays) in scene()) {
            let constraint = at(&pose, rays);
            let Constraint { value, variance, jacobian, .. } = constraint;
            let frame = PoseTerms::at(&pose);
            let whole = constraint.whitened_jacobian(&frame, value / variance);
            let whole = whole.map(|j| j / variance.sqrt());
            let numeric = by_pose(&pose, |pose| at(pose, rays).value);
            let numeric_whole = by_pose(&pose, |pose| whitened(pose, rays));
            for (analytic, numeric) in [(jacobian, numeric), (whole, numeric_whole)] {
                let size = analytic.iter().fold(0.0_f64, |m, j| m.max(j.abs()));
                for (a, n) in analytic.iter().zip(numeric) {
                    prop_assert!((a - n).abs() < 1e-8 * size, "{analytic:?} {numeric:?}");
                }
            }
        }

        #[test]
        fn half_the_derivatives_of_the_variance_match_central_differences((pose, rays) in scene()) {
            let constraint = at(&pose, rays);
            // For `C / V` = 1, half the derivatives of `V` are the plain minus the whitened derivatives.
            let whole = constraint.whitened_jacobian(&PoseTerms::at(&pose), 1.0);
            let numeric = by_pose(&pose, |pose| at(pose, rays).variance / 2.0);
            for ((plain, whole), half) in constraint.jacobian.into_iter().zip(whole).zip(numeric) {
                prop_assert!((plain - whole - half).abs() < 1e-9, "{} {half}", plain - whole);
            }
        }

        #[test]
        fn the_constraint_is_the_row_offset_times_the_depths_and_one_of_the_products_of_the_rays(
            (pose, rays) in scene()
        ) {
            let constraint = at(&pose, rays);
            let [x_l, y_l, x_r, y_r] = rays;
            let offset = row_offset(&pose, &RayPair::of_rays(rays)).unwrap();
            prop_assert!((constraint.row_offset() - offset).abs() < 1e-14);
            let a = pose.left() * Vector3::new(x_l, y_l, 1.0);
            let b = pose.right() * Vector3::new(x_r, y_r, 1.0);
            let (apart, outer) = (a.cross(&b), b * a.transpose());
            let together = outer + outer.transpose();
            let products = [
                apart.x, apart.y, apart.z, outer.m11, outer.m22, outer.m33,
                together.m12, together.m13, together.m23,
            ];
            let frame = PoseTerms::at(&pose);
            for (ours, product) in constraint.coordinates(&frame, rays).iter().zip(products) {
                prop_assert!((ours - product).abs() < 1e-14, "{ours} {product}");
            }
            let least = a.x / a.z - b.x / b.z - 1e-9;
            prop_assert!(constraint.has_disparity(least));
            prop_assert!(!constraint.has_disparity(least + 2e-9));
        }

        #[test]
        fn the_local_scale_is_the_length_of_a_pixel(
            (pose, rays) in scene(), code in 0..64_u16,
        ) {
            let scale = f64::from(8 + code % 8) / 8.0 * f64::from(code / 8).exp2() / 4.0;
            let frame = PoseTerms::at(&pose);
            let (plain, pair) = (at(&pose, rays), RayPair::of_rays(rays).with_scale(scale));
            let scaled = Constraint::of(&frame, &pair).unwrap();
            prop_assert!((scaled.variance / plain.variance / (scale * scale) - 1.0).abs() < 1e-14);
            prop_assert!((scaled.row_offset() * scale - plain.row_offset()).abs() < 1e-15);
            let [disparity, _] = plain.disparity_over(0.0);
            let [same, least] = scaled.disparity_over(-1e-3);
            let [_, of_plain] = plain.disparity_over(-1e-3 * scale);
            prop_assert!(same == disparity && (least / of_plain - 1.0).abs() < 1e-14);
            let [whole, same] = [plain, scaled].map(|constraint| {
                constraint.whitened_jacobian(&frame, constraint.value / constraint.variance)
            });
            prop_assert!(whole.iter().zip(same).all(|(a, b)| (a - b).abs() < 1e-14), "{scale}");
        }

        #[test]
        fn coordinates_of_the_lens_match_central_differences((pose, rays) in scene()) {
            let [x_l, y_l, x_r, y_r] = rays;
            let constraint = at(&pose, rays);
            // Constraint of homogeneous rays that are corrected for an error of the lens.
            let of = |left: Vector3<f64>, right: Vector3<f64>| {
                let (a, b) = (pose.left() * left, pose.right() * right);
                a.y * b.z - a.z * b.y
            };
            let (left, right) = (Vector3::new(x_l, y_l, 1.0), Vector3::new(x_r, y_r, 1.0));
            let (squared_l, squared_r) = (left.xy().norm_squared(), right.xy().norm_squared());
            let z = Vector3::z();
            let along = Vector3::y() * (squared_r + 2.0 * y_r * y_r);
            let by_k1_l = difference(|k| of(left + z * (k * squared_l), right));
            let by_k1_r = difference(|k| of(left, right + z * (k * squared_r)));
            let by_p1 = difference(|p| of(left, right - along * p));
            // `C` times the relative change of `sqrt V` by the correction. The share of each camera in `V` is taken as
            // half.
            let noise = |squared: f64, y: f64| constraint.value * (squared / 2.0 - y * y);
            let [.., k1_l, k1_r, p1] =
                constraint.coordinates(&PoseTerms::at(&pose), rays);
            prop_assert!((k1_l - (by_k1_l - noise(squared_l, y_l))).abs() < 1e-9);
            prop_assert!((k1_r - (by_k1_r - noise(squared_r, y_r))).abs() < 1e-9);
            prop_assert!((p1 - by_p1).abs() < 1e-9);
        }

        #[test]
        fn variance_is_the_squared_gradient_of_the_constraint_off_the_epipolar_line_too(
            (pose, rays) in scene()
        ) {
            let squared = gradient_squared(rays, |rays| at(&pose, rays).value);
            prop_assert!((at(&pose, rays).variance / squared - 1.0).abs() < 1e-9);
        }

        #[test]
        fn unit_noise_on_the_coordinates_gives_the_whitened_constraint_unit_deviation(
            (pose, [x, y, ..]) in scene(), disparity in 0.0..0.3_f64,
        ) {
            // On the epipolar line the residual is zero, so the derivative of `V` has no effect.
            let p = pose.left() * Vector3::new(x, y, 1.0);
            let q = pose.right().inverse() * Vector3::new(p.x / p.z - disparity, p.y / p.z, 1.0);
            let rays = [x, y, q.x / q.z, q.y / q.z];
            let squared = gradient_squared(rays, |rays| whitened(&pose, rays));
            prop_assert!((squared - 1.0).abs() < 1e-6, "{squared}");
        }
    }
}
