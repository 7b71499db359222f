//! Rotations: exponential, logarithm, left-perturbation update, projection onto SO(3).
//!
//! Rotation vectors are in radians; their direction is the axis. Every angle is computed by `atan2`, because the error
//! of `acos` of a trace is up to 5e-4 rad near zero in `f32`.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::scalar::Scalar;
use crate::thresholds::{MAX_ROTATION_DEFECT, NEWTON_SCHULZ_STEPS};

/// Returns `exp([w]x)`: the rotation by `|w|` radians about `w`.
///
/// The error of an element is below 5e-7 in `f32` for `|w|` up to pi, and grows with `|w|` above pi. `None` if the
/// squared length of `w` is not finite. Cost: one square root if `|w|` is above pi; no sine or cosine.
#[must_use]
pub fn exp<T: Scalar>(w: &Vector3<T>) -> Option<Rotation3<T>> {
    let squared = w.norm_squared();
    if !squared.is_finite() {
        return None;
    }
    let within = if squared <= T::pi() * T::pi() {
        *w
    } else {
        let angle = squared.sqrt();
        w * ((angle - (angle / T::two_pi()).round() * T::two_pi()) / angle)
    };
    Some(Rotation3::from_matrix_unchecked(newton_schulz(&exp_matrix(&within))))
}

/// Returns the rotation vector of `r` in radians, of length at most pi. This is the inverse of [`exp`], computed from
/// the unit quaternion.
///
/// Absolute error below 1e-6 rad in `f32` at any angle, relative error below 1e-6 near zero. For an angle within
/// rounding of pi, the opposite vector may be returned.
#[must_use]
pub fn log<T: Scalar>(r: &Rotation3<T>) -> Vector3<T> {
    let (real, imaginary) = quaternion(r.matrix());
    let norm = imaginary.norm();
    if norm > T::ZERO {
        imaginary * ((norm.atan2(real) / norm) / T::HALF)
    } else {
        imaginary / T::HALF
    }
}

/// Returns `exp([w]x) r`, orthonormalised: the left perturbation of eq 19.
///
/// * `w`: rad, `|w| <= pi`.
///
/// The deviation of the result from an orthonormal matrix does not grow with the number of updates.
#[must_use]
pub(crate) fn left_update<T: Scalar>(w: &Vector3<T>, r: &Rotation3<T>) -> Rotation3<T> {
    let turned = product(&exp_matrix(w), r.matrix());
    Rotation3::from_matrix_unchecked(newton_schulz(&turned))
}

/// Returns the rotation nearest to `m` (polar factor) if `m` is within about 0.1 of a rotation, by the Frobenius norm
/// of the difference.
///
/// `None` if `m` is not finite, further from a rotation, or a reflection.
#[must_use]
pub fn nearest_rotation<T: Scalar>(m: &Matrix3<T>) -> Option<Rotation3<T>> {
    let defect = (product(&m.transpose(), m) - Matrix3::identity()).norm_squared();
    // Negated `<` instead of `>=`, so that a `NaN` is refused.
    if !(defect < T::lit(MAX_ROTATION_DEFECT)) || m.determinant() <= T::ZERO {
        return None;
    }
    // The norm of `m^T m - I` falls from at most 0.2 to about 0.032, 7.8e-4, 4.5e-7, 1.5e-13, and then below rounding.
    let nearest = (0..NEWTON_SCHULZ_STEPS).fold(*m, |m, _| newton_schulz(&m));
    Some(Rotation3::from_matrix_unchecked(nearest))
}

/// Returns `a b`. The product is written out, because the generic product is a loop over slices at opt-level "s".
pub(crate) fn product<T: Scalar>(a: &Matrix3<T>, b: &Matrix3<T>) -> Matrix3<T> {
    Matrix3::new(
        a.m11 * b.m11 + a.m12 * b.m21 + a.m13 * b.m31,
        a.m11 * b.m12 + a.m12 * b.m22 + a.m13 * b.m32,
        a.m11 * b.m13 + a.m12 * b.m23 + a.m13 * b.m33,
        a.m21 * b.m11 + a.m22 * b.m21 + a.m23 * b.m31,
        a.m21 * b.m12 + a.m22 * b.m22 + a.m23 * b.m32,
        a.m21 * b.m13 + a.m22 * b.m23 + a.m23 * b.m33,
        a.m31 * b.m11 + a.m32 * b.m21 + a.m33 * b.m31,
        a.m31 * b.m12 + a.m32 * b.m22 + a.m33 * b.m32,
        a.m31 * b.m13 + a.m32 * b.m23 + a.m33 * b.m33,
    )
}

/// Takes one Newton-Schulz step towards the orthonormal polar factor, `m + m (I - m^T m) / 2`: products only, no square
/// root. It is written out for the same reason as [`product`].
#[rustfmt::skip]
fn newton_schulz<T: Scalar>(m: &Matrix3<T>) -> Matrix3<T> {
    let transposed =
        Matrix3::new(m.m11, m.m21, m.m31, m.m12, m.m22, m.m32, m.m13, m.m23, m.m33);
    let (s, one, zero) = (product(&transposed, m), T::ONE, T::ZERO);
    let half = |x: T| x * T::HALF;
    let half_defect = Matrix3::new(
        half(one - s.m11), half(zero - s.m12), half(zero - s.m13),
        half(zero - s.m21), half(one - s.m22), half(zero - s.m23),
        half(zero - s.m31), half(zero - s.m32), half(one - s.m33),
    );
    let step = product(m, &half_defect);
    Matrix3::new(
        m.m11 + step.m11, m.m12 + step.m12, m.m13 + step.m13,
        m.m21 + step.m21, m.m22 + step.m22, m.m23 + step.m23,
        m.m31 + step.m31, m.m32 + step.m32, m.m33 + step.m33,
    )
}

/// Returns the rotation matrix of the unit quaternion `(cos h, sin h / h * w / 2)`, `h = |w| / 2`.
///
/// * `w`: rad, `|w| <= pi`.
#[rustfmt::skip]
fn exp_matrix<T: Scalar>(w: &Vector3<T>) -> Matrix3<T> {
    let x = w.norm_squared() * T::HALF * T::HALF;
    let (sinc, cos) = sinc_cos(x);
    let v = w * (sinc * T::HALF);
    let [x, y, z] = [v.x + v.x, v.y + v.y, v.z + v.z];
    let [xx, yy, zz] = [x * v.x, y * v.y, z * v.z];
    let [xy, xz, yz] = [x * v.y, x * v.z, y * v.z];
    let [xw, yw, zw] = [x * cos, y * cos, z * cos];
    let one = T::ONE;
    Matrix3::new(
        one - (yy + zz), xy - zw, xz + yw,
        xy + zw, one - (xx + zz), yz - xw,
        xz - yw, yz + xw, one - (xx + yy),
    )
}

/// Returns `sin(h) / h` and `cos(h)` for `x = h^2`, `h` in `0..=pi/2` rad; truncation error below 1e-18.
///
/// This is a power series, because the sine of `libm` computes in `f64`, which a controller emulates in software.
pub(crate) fn sinc_cos<T: Scalar>(x: T) -> (T, T) {
    // `1 - c0 x (1 - c1 x (1 - ...))`.
    let nested = |c: &[T]| c.iter().rev().fold(T::ONE, |sum, c| T::ONE - x * *c * sum);
    (nested(&T::SINE), nested(&T::COSINE))
}

/// Returns the unit quaternion `(real, imaginary)`, `real >= 0`, of a rotation matrix. It is computed from the real
/// part if the trace is positive, otherwise from the largest imaginary part (Shepperd's method), so no divisor is
/// small.
fn quaternion<T: Scalar>(m: &Matrix3<T>) -> (T, Vector3<T>) {
    let quarter = T::HALF * T::HALF;
    let (xx, yy, zz) = (m.m11, m.m22, m.m33);
    let antisymmetric = Vector3::new(m.m32 - m.m23, m.m13 - m.m31, m.m21 - m.m12);
    let trace = xx + yy + zz;
    if trace > T::ZERO {
        let real = (T::ONE + trace).sqrt() * T::HALF;
        return (real, antisymmetric * (quarter / real));
    }
    let (real, imaginary) = if xx >= yy && xx >= zz {
        let x = (T::ONE + xx - yy - zz).sqrt() * T::HALF;
        let k = quarter / x;
        (antisymmetric.x * k, Vector3::new(x, (m.m12 + m.m21) * k, (m.m13 + m.m31) * k))
    } else if yy >= zz {
        let y = (T::ONE + yy - xx - zz).sqrt() * T::HALF;
        let k = quarter / y;
        (antisymmetric.y * k, Vector3::new((m.m12 + m.m21) * k, y, (m.m23 + m.m32) * k))
    } else {
        let z = (T::ONE + zz - xx - yy).sqrt() * T::HALF;
        let k = quarter / z;
        (antisymmetric.z * k, Vector3::new((m.m13 + m.m31) * k, (m.m23 + m.m32) * k, z))
    };
    if real < T::ZERO { (-real, -imaginary) } else { (real, imaginary) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn unit() -> impl Strategy<Value = Vector3<f64>> {
        [-1.0..1.0_f64, -1.0..1.0, -1.0..1.0]
            .prop_map(Vector3::from)
            .prop_filter("no direction", |v| v.norm() > 0.1)
            .prop_map(|v| v.normalize())
    }

    /// Generates the angle 0, angles from 1e-7 to 3.1 with a uniform logarithm, and angles up to 0.01 below pi, rad.
    fn angle() -> impl Strategy<Value = f64> {
        use core::f64::consts::PI;
        prop_oneof![
            Just(0.0),
            (-7.0..0.49_f64).prop_map(|e| 10.0_f64.powf(e)),
            (-7.0..-2.0_f64).prop_map(|e| PI - 10.0_f64.powf(e)),
        ]
    }

    proptest! {
        #[test]
        fn log_undoes_exp_in_f32_at_every_angle(axis in unit(), angle in angle()) {
            let w = (axis * angle).map(f32::lit);
            let back = log(&exp(&w).unwrap());
            // Near pi, `log` may return the opposite axis.
            let reversed = (back + w).norm() + 2.0 * (core::f32::consts::PI - w.norm()).abs();
            let miss = (back - w).norm().min(reversed);
            prop_assert!(miss <= 1e-6, "{w} {back} {miss:e}");
        }

        #[test]
        fn small_angles_keep_their_relative_accuracy_in_f32(axis in unit(), e in -7.0..-3.0_f64) {
            let w = (axis * 10.0_f64.powf(e)).map(f32::lit);
            let miss = (log(&exp(&w).unwrap()) - w).norm();
            prop_assert!(miss <= 1e-6 * w.norm(), "{miss:e}");
        }

        #[test]
        fn exp_is_the_closed_form_in_f64_and_in_f32_to_rounding(axis in unit(), angle in angle()) {
            let w = (axis * angle).map(f32::lit);
            let reference = *Rotation3::from_scaled_axis(w.map(f64::from)).matrix();
            let exact = *exp(&w.map(f64::from)).unwrap().matrix();
            prop_assert!((exact - reference).amax() < 1e-14);
            prop_assert!((exp(&w).unwrap().matrix().map(f64::from) - exact).amax() < 5e-7);
        }

        #[test]
        fn nearest_rotation_of_a_disturbed_rotation_is_orthonormal_and_near(
            axis in unit(), angle in angle(), noise in unit(),
        ) {
            let r = exp(&(axis * angle)).unwrap();
            let nearest = nearest_rotation(&(r.matrix() + noise * axis.transpose() * 0.05)).unwrap();
            let defect = nearest.matrix().transpose() * nearest.matrix() - Matrix3::identity();
            prop_assert!(defect.amax() < 1e-14);
            prop_assert!((nearest.matrix() - r.matrix()).norm() < 0.1);
        }
    }

    #[test]
    fn rotation_stays_orthonormal_over_a_million_updates_in_f32() {
        let mut r = Rotation3::<f32>::identity();
        let steps = [[0.3, -0.2, 0.1], [1e-7, 2e-7, -1e-7], [1e-3, 2e-3, 0.0]].map(Vector3::from);
        for _ in 0..333_334 {
            for step in &steps {
                r = left_update(step, &r);
            }
        }
        let defect = (r.matrix().transpose() * r.matrix() - Matrix3::identity()).amax();
        assert!(defect < 4e-7, "{defect:e}");
    }

    #[test]
    fn vectors_that_are_not_finite_and_matrices_far_from_a_rotation_are_refused() {
        for bad in [f32::NAN, f32::INFINITY] {
            assert_eq!(exp(&Vector3::new(0.0, bad, 0.0)), None);
        }
        let identity = Matrix3::<f32>::identity();
        for m in [Matrix3::zeros(), -identity, Matrix3::repeat(f32::NAN), identity * 1.2] {
            assert_eq!(nearest_rotation(&m), None);
        }
    }
}
