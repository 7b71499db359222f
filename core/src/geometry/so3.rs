//! Rotations: exponential and logarithm, the left-perturbation update, the way back to orthonormal.
//!
//! Rotation vectors are in radians. Every angle comes from `atan2`, never from `acos` of a trace,
//! which is off by up to 5e-4 rad near zero in `f32`.

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::codec::Reader;
use crate::error::RestoreError;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_ROTATION_DEFECT, NEWTON_SCHULZ_STEPS};

/// Largest defect of a recorded rotation.
const ORTHONORMAL: f64 = 2e-6;

/// `exp([w]x)`: the rotation by `|w|` radians about `w`.
///
/// Error of an element below 5e-7 in `f32` up to pi, growing with `|w|` beyond.
/// `None` if the square of `w` is not finite. Cost: no sine, no cosine; one root above pi.
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

/// Rotation vector in radians, `|w| <= pi`, whose [`exp`] is `r`.
///
/// Absolute error below 1e-6 rad in `f32` at any angle, relative error below 1e-6 near zero.
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

/// `exp([w]x) r`, re-orthonormalised: the update of eq. 19.
///
/// The error does not grow with the number of updates. `w` must be at most a half turn.
#[must_use]
pub(crate) fn left_update<T: Scalar>(w: &Vector3<T>, r: &Rotation3<T>) -> Rotation3<T> {
    let turned = product(&exp_matrix(w), r.matrix());
    Rotation3::from_matrix_unchecked(newton_schulz(&turned))
}

/// The rotation nearest to `m`, if `m` is a rotation up to about 0.1 in its elements.
///
/// `None` if it is not finite, too far from orthonormal, or a reflection.
#[must_use]
pub fn nearest_rotation<T: Scalar>(m: &Matrix3<T>) -> Option<Rotation3<T>> {
    let defect = (m.transpose() * m - Matrix3::identity()).norm_squared();
    // Not `>`: a NaN must fail this test.
    if !(defect < T::lit(MAX_ROTATION_DEFECT)) || m.determinant() <= T::ZERO {
        return None;
    }
    // Quadratic convergence: 0.2, 3e-2, 7e-4, 4e-7, 1e-13, below rounding.
    let nearest = (0..NEWTON_SCHULZ_STEPS).fold(*m, |m, _| newton_schulz(&m));
    Some(Rotation3::from_matrix_unchecked(nearest))
}

/// Reads a rotation matrix of a record, column by column.
///
/// # Errors
/// [`RestoreError::Absurd`] where it is off from orthonormal by more than the rounding of `f32` leaves, 4e-7.
pub(crate) fn read<T: Scalar>(from: &mut Reader<'_>) -> Result<Rotation3<T>, RestoreError> {
    let mut rotation = Rotation3::identity();
    let m = rotation.matrix_mut_unchecked();
    from.numbers(m.iter_mut())?;
    // The stored matrix is returned: it is bit-identical.
    let nearest = nearest_rotation(m).ok_or(RestoreError::Absurd)?;
    let orthonormal = (nearest.matrix() - rotation.matrix()).amax() <= T::lit(ORTHONORMAL);
    if orthonormal { Ok(rotation) } else { Err(RestoreError::Absurd) }
}

/// `a b`, written out: small at `opt-level = "s"`, where the generic product is a loop.
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

/// One Newton-Schulz step towards the orthonormal polar factor: products only, no loop, no root.
fn newton_schulz<T: Scalar>(m: &Matrix3<T>) -> Matrix3<T> {
    let half_defect = (Matrix3::identity() - product(&m.transpose(), m)) * T::HALF;
    m + product(m, &half_defect)
}

/// Rotation matrix by way of the unit quaternion `(cos h, sin h / h * w / 2)`, `h = |w| / 2`.
///
/// * `w`: at most a half turn.
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
        one - (yy + zz),
        xy - zw,
        xz + yw,
        xy + zw,
        one - (xx + zz),
        yz - xw,
        xz - yw,
        yz + xw,
        one - (xx + yy),
    )
}

/// `sin(h) / h` and `cos(h)` of `x = h^2`, `h` up to a right angle: truncated below 1e-18. A sine of
/// its own, because that of `libm` computes in `f64`, which a controller does in software.
pub(crate) fn sinc_cos<T: Scalar>(x: T) -> (T, T) {
    // `1 - c0 x (1 - c1 x (1 - ...))`.
    let nested = |c: &[T]| c.iter().rev().fold(T::ONE, |sum, c| T::ONE - x * *c * sum);
    (nested(&T::SINE), nested(&T::COSINE))
}

/// Unit quaternion with a real part `>= 0`, by the largest of its four squares (Shepperd).
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

    /// 1e-7 to pi by orders of magnitude, and the neighbourhoods of 0 and pi.
    fn angle() -> impl Strategy<Value = f64> {
        use core::f64::consts::PI;
        prop_oneof![
            Just(0.0),
            (-7.0..0.49_f64).prop_map(|e| 10.0_f64.powf(e)),
            (-7.0..-2.0_f64).prop_map(|e| PI - 10.0_f64.powf(e)),
        ]
    }

    fn single(v: &Vector3<f64>) -> Vector3<f32> {
        v.map(f32::lit)
    }

    fn double(v: &Vector3<f32>) -> Vector3<f64> {
        v.map(f64::from)
    }

    proptest! {
        #[test]
        fn log_undoes_exp_in_f32_at_every_angle(axis in unit(), angle in angle()) {
            let w = single(&(axis * angle));
            let back = log(&exp(&w).unwrap());
            // Near pi the axis may come back reversed.
            let miss = (back - w).norm().min((back + w).norm() + 2.0 * (core::f32::consts::PI - w.norm()).abs());
            prop_assert!(miss <= 1e-6, "{w} {back} {miss:e}");
        }

        #[test]
        fn small_angles_keep_their_relative_accuracy_in_f32(axis in unit(), e in -7.0..-3.0_f64) {
            let w = single(&(axis * 10.0_f64.powf(e)));
            let miss = (log(&exp(&w).unwrap()) - w).norm();
            prop_assert!(miss <= 1e-6 * w.norm(), "{miss:e}");
        }

        #[test]
        fn exp_in_f32_is_that_of_f64_rounded(axis in unit(), angle in angle()) {
            let w = single(&(axis * angle));
            let [a, b] = [exp(&w).unwrap().matrix().map(f64::from), *exp(&double(&w)).unwrap().matrix()];
            prop_assert!((a - b).amax() < 5e-7, "{}", a - b);
        }

        #[test]
        fn exp_in_f64_is_the_closed_form(axis in unit(), angle in angle()) {
            let w = axis * angle;
            let reference = Rotation3::from_scaled_axis(w);
            prop_assert!((exp(&w).unwrap().matrix() - reference.matrix()).amax() < 1e-14);
        }

        #[test]
        fn nearest_rotation_mends_what_is_nearly_one(axis in unit(), angle in angle(), noise in unit()) {
            let r = exp(&(axis * angle)).unwrap();
            let mended = nearest_rotation(&(r.matrix() + noise * axis.transpose() * 0.05)).unwrap();
            let defect = mended.matrix().transpose() * mended.matrix() - Matrix3::identity();
            prop_assert!(defect.amax() < 1e-14);
            prop_assert!((mended.matrix() - r.matrix()).norm() < 0.1);
        }
    }

    #[test]
    fn stays_orthonormal_over_a_million_updates_in_f32() {
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
    fn refuses_what_is_not_finite_or_no_rotation() {
        assert_eq!(exp(&Vector3::new(0.0, f32::NAN, 0.0)), None);
        assert_eq!(exp(&Vector3::new(f32::INFINITY, 0.0, 0.0)), None);
        assert_eq!(nearest_rotation(&Matrix3::<f32>::zeros()), None);
        assert_eq!(nearest_rotation(&-Matrix3::<f32>::identity()), None);
        assert_eq!(nearest_rotation(&Matrix3::<f32>::repeat(f32::NAN)), None);
        assert_eq!(nearest_rotation(&(Matrix3::<f32>::identity() * 1.2)), None);
    }
}
