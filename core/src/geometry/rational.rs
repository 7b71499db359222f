//! Rational lens model of OpenCV: the radial factor is the quotient of two polynomials.
//!
//! Calibrations with `cv::CALIB_RATIONAL_MODEL` and the factory files of some stereo cameras use this model. Points are
//! normalised image coordinates (unit depth), dimensionless. The model ends where its slope vanishes, or where its
//! denominator falls below 0.01.

use nalgebra::{Matrix2, Vector2};

use super::distortion::{Undistorted, as_coefficients, check_within, first_fold, newton_step};
use crate::error::CameraError;
use crate::scalar::Scalar;
use crate::thresholds::{
    MAX_NEWTON_STEPS, MAX_RATIONAL, MAX_TANGENT, MIN_LENS_DENOMINATOR, NEWTON_ULPS,
    RATIONAL_RESIDUAL_ULPS,
};

/// Rational radial and tangential distortion, `k1 k2 p1 p2 k3 k4 k5 k6`, with `s = x^2 + y^2` and
/// `g = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3)`:
/// `x_d = x g + 2 p1 x y + p2 (s + 2 x^2)`, `y_d = y g + p1 (s + 2 y^2) + 2 p2 x y`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "[T; 8]", bound(deserialize = "T: Scalar + serde::Deserialize<'de>"))
)]
pub struct Rational<T> {
    pub(super) coefficients: [T; 8],
    /// Undistorted radius at which the slope vanishes or the denominator falls below [`MIN_LENS_DENOMINATOR`]; at most
    /// [`MAX_TANGENT`].
    fold: T,
}

as_coefficients!(Rational, 8);

impl<T: Scalar> Rational<T> {
    /// Returns the lens with the coefficients `[k1, k2, p1, p2, k3, k4, k5, k6]`, in OpenCV's order.
    ///
    /// # Errors
    /// [`CameraError::Distortion`] if a coefficient is not finite or above 1e5 in magnitude.
    pub fn try_new(coefficients: [T; 8]) -> Result<Self, CameraError> {
        check_within(&coefficients, MAX_RATIONAL)?;
        let limit = T::lit(MAX_TANGENT);
        let mut lens = Self { coefficients, fold: limit };
        let slope = |r: T| lens.radial(r * r).map_or(T::MINUS_ONE, |at| at.rise(r));
        lens.fold = first_fold(&slope, limit);
        Ok(lens)
    }

    /// Returns `[k1, k2, p1, p2, k3, k4, k5, k6]`.
    pub fn coefficients(&self) -> [T; 8] {
        self.coefficients
    }

    /// Returns the lens with `by * s` added to its `g`. The numerator then gains the product of `by * s` and the
    /// denominator. The term of `s^4` in this product is left out, because the model has no such term.
    ///
    /// # Errors
    /// [`CameraError::Distortion`] if a coefficient is then out of range.
    pub(super) fn corrected(&self, by: T) -> Result<Self, CameraError> {
        let [k1, k2, p1, p2, k3, k4, k5, k6] = self.coefficients;
        Self::try_new([k1 + by, k2 + by * k4, p1, p2, k3 + by * k5, k4, k5, k6])
    }

    /// Returns `g` and its slope at a squared radius `s`; `None` where the denominator is below
    /// [`MIN_LENS_DENOMINATOR`].
    fn radial(&self, s: T) -> Option<Radial<T>> {
        let [k1, k2, _, _, k3, k4, k5, k6] = self.coefficients;
        let (two, three) = (T::lit(2.0), T::lit(3.0));
        let over = T::ONE + s * (k1 + s * (k2 + s * k3));
        let under = T::ONE + s * (k4 + s * (k5 + s * k6));
        if !(under >= T::lit(MIN_LENS_DENOMINATOR)) {
            return None;
        }
        let value = over / under;
        let over_slope = k1 + s * (two * k2 + s * three * k3);
        let under_slope = k4 + s * (two * k5 + s * three * k6);
        Some(Radial { value, slope: (over_slope - value * under_slope) / under })
    }

    pub(super) fn distort(&self, p: Vector2<T>) -> Option<Vector2<T>> {
        (p.norm_squared() < self.fold * self.fold).then(|| self.map(p)).flatten()
    }

    /// Returns the distorted point, without a check of the fold; `None` where the denominator is below
    /// [`MIN_LENS_DENOMINATOR`].
    fn map(&self, p: Vector2<T>) -> Option<Vector2<T>> {
        let [_, _, p1, p2, ..] = self.coefficients;
        let (xx, yy, xy) = (p.x * p.x, p.y * p.y, p.x * p.y);
        let (s, two) = (xx + yy, T::lit(2.0));
        let g = self.radial(s)?.value;
        Some(Vector2::new(
            p.x * g + two * p1 * xy + p2 * (s + two * xx),
            p.y * g + p1 * (s + two * yy) + two * p2 * xy,
        ))
    }

    /// Returns the derivative of [`Self::map`] by the point, with the rows `x_d` and `y_d`. The matrix is symmetric.
    fn jacobian(&self, p: Vector2<T>) -> Option<Matrix2<T>> {
        let [_, _, p1, p2, ..] = self.coefficients;
        let (two, six) = (T::lit(2.0), T::lit(6.0));
        let Radial { value, slope } = self.radial(p.norm_squared())?;
        let mixed = two * (p.x * p.y * slope + p1 * p.x + p2 * p.y);
        Some(Matrix2::new(
            value + two * (p.x * p.x * slope + p1 * p.y) + six * p2 * p.x,
            mixed,
            mixed,
            value + two * (p.y * p.y * slope + p2 * p.x) + six * p1 * p.y,
        ))
    }

    /// Undistorts by Newton's method, which starts at the point that the radial part alone gives. The result is
    /// distorted again; `None` if it differs from `d` by more than rounding. The density is that before the last step.
    pub(super) fn undistort(&self, d: Vector2<T>) -> Option<Undistorted<T>> {
        let mut p = self.radial_inverse(d)?;
        let mut density = T::ONE;
        for _ in 0..MAX_NEWTON_STEPS {
            let error = self.map(p)? - d;
            let (step, determinant) = newton_step(error, &self.jacobian(p)?)?;
            (p, density) = (p - step, determinant);
            if step.amax() <= T::lit(NEWTON_ULPS) * T::EPSILON * (T::ONE + p.amax()) {
                break;
            }
        }
        // Where the model is flat, rounding dominates every step. Therefore the residual decides, not the last step.
        let largest = T::lit(RATIONAL_RESIDUAL_ULPS) * T::EPSILON * (T::ONE + p.amax() + d.amax());
        let is_found = self.distort(p).is_some_and(|back| (back - d).amax() <= largest);
        is_found.then_some(Undistorted { point: p, density })
    }

    /// Returns the point in the direction of `d` that the radial part maps to `d`; a point near the fold if the radial
    /// part does not reach `d`; `None` for NaN. This is Newton's method in a bracket: the radial part rises up to the
    /// fold, so bisection can replace every step that leaves the bracket.
    fn radial_inverse(&self, d: Vector2<T>) -> Option<Vector2<T>> {
        let target = d.norm();
        if !(target > T::EPSILON) {
            return (target <= T::EPSILON).then_some(d);
        }
        let (mut low, mut high) = (T::ZERO, self.fold);
        let mut r = if target < high { target } else { high * T::HALF };
        for _ in 0..2 * MAX_NEWTON_STEPS {
            let at = self.radial(r * r)?;
            let error = at.value * r - target;
            if error > T::ZERO {
                high = r;
            } else {
                low = r;
            }
            let newton = r - error / at.rise(r);
            let next = if newton > low && newton < high { newton } else { (low + high) * T::HALF };
            let step = (next - r).abs();
            r = next;
            if step <= T::lit(NEWTON_ULPS) * T::EPSILON * (T::ONE + r) {
                break;
            }
        }
        Some(d * (r / target))
    }
}

/// The radial factor `g` at a squared radius `s`, and `dg/ds`.
#[derive(Debug, Clone, Copy)]
struct Radial<T> {
    value: T,
    slope: T,
}

impl<T: Scalar> Radial<T> {
    /// Returns the derivative of `r g` by the radius `r`.
    fn rise(&self, r: T) -> T {
        self.value + T::lit(2.0) * r * r * self.slope
    }
}

#[cfg(test)]
mod tests {
    use super::super::lens::{Lens, RadialTangential};
    use super::*;
    use proptest::prelude::*;

    /// A wide lens, as `cv::calibrateCamera` returns it: large coefficients in numerator and denominator.
    const WIDE: [f64; 8] = [9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2];

    fn any() -> impl Strategy<Value = Rational<f64>> {
        let wide = prop::array::uniform8(-1.0..1.0_f64).prop_map(|by| {
            let mut k = WIDE;
            k.iter_mut().zip(by).for_each(|(k, by)| *k *= 1.0 + 0.3 * by);
            k
        });
        let free = prop::array::uniform8(-2.0..2.0_f64).prop_map(|mut k| {
            (k[2], k[3]) = (k[2] / 20.0, k[3] / 20.0);
            k
        });
        prop_oneof![wide, free].prop_map(|k| Rational::try_new(k).unwrap())
    }

    proptest! {
        #[test]
        fn derivatives_match_central_differences(
            lens in any(), x in -0.8..0.8_f64, y in -0.6..0.6_f64,
        ) {
            let p = Vector2::new(x, y);
            // Beyond the fold the differences may cross the pole.
            prop_assume!(p.norm() < 0.9 * lens.fold);
            let jacobian = lens.jacobian(p).unwrap();
            let h = 1e-4;
            for column in 0..2 {
                let by = |h: f64| if column == 0 { Vector2::new(h, 0.0) } else { Vector2::new(0.0, h) };
                let at = |h: f64| lens.map(p + by(h)).unwrap();
                let numeric = ((at(h) - at(-h)) * 8.0 - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
                let error = (jacobian.column(column) - numeric).amax();
                prop_assert!(error < 1e-5 * (1.0 + numeric.amax()), "{error} {column} {lens:?}");
            }
        }

        #[test]
        fn a_point_within_the_fold_comes_back(
            lens in any(), part in 0.0..0.95_f64, turn in 0.0..6.3_f64,
        ) {
            let p = Vector2::new(turn.cos(), turn.sin()) * (lens.fold.min(2.0) * part);
            let d = lens.distort(p).unwrap();
            // With tangential terms the model may stop being invertible at a smaller radius than its radial part.
            prop_assume!(lens.jacobian(p).unwrap().determinant() > 0.02);
            let tangential = lens.coefficients[2].abs().max(lens.coefficients[3].abs());
            match lens.undistort(d) {
                Some(Undistorted { point, .. }) => {
                    let error = (lens.distort(point).unwrap() - d).amax();
                    prop_assert!(error < 1e-10 * (1.0 + d.amax()), "{error}");
                }
                None => prop_assert!(tangential > 2e-3, "{lens:?} {p}"),
            }
        }

        #[test]
        fn a_wide_lens_inverts_everywhere_in_single_precision(
            part in 0.0..0.97_f32, turn in 0.0..6.3_f32,
        ) {
            let lens = Rational::try_new(WIDE.map(f32::lit)).unwrap();
            let p = Vector2::new(turn.cos(), turn.sin()) * (lens.fold.min(2.5) * part);
            let back = lens.undistort(lens.distort(p).unwrap()).unwrap().point;
            prop_assert!((back - p).amax() < 2e-5 * (1.0 + p.amax()), "{back} {p}");
        }
    }

    #[test]
    fn a_rational_lens_without_a_denominator_is_the_radial_tangential_lens() {
        let brown = RadialTangential::try_new([-0.28, 0.04, 1e-3, -1e-4, 0.11]);
        let same = Rational::try_new([-0.28, 0.04, 1e-3, -1e-4, 0.11, 0.0, 0.0, 0.0]).unwrap();
        let [a, b] = [Lens::RadialTangential(brown.unwrap()), Lens::Rational(same)];
        for d in [[0.3, -0.2], [-0.05, 0.4], [0.0, 0.0]] {
            let [a, b] = [&a, &b].map(|lens| lens.undistort(d.into()).unwrap().point);
            assert!((a - b).amax() < 1e-12, "{a} {b}");
        }
    }

    #[test]
    fn a_point_comes_back_where_the_model_is_flat() {
        // The slope is about 0.1 there: rounding may move each step by more than the limit of a step.
        let lens = [11.542, 3.658, 9.81e-5, -2e-4, 0.2204, 10.298, 8.567, 1.4319];
        let lens = Rational::try_new(lens).unwrap();
        for part in 0..100 {
            let p = Vector2::new(1.4 + 0.001 * f64::from(part), 0.1);
            let back = lens.undistort(lens.distort(p).unwrap()).unwrap().point;
            assert!((back - p).amax() < 1e-12, "{back} {p}");
        }
    }

    #[test]
    fn the_model_ends_at_the_pole_of_the_quotient() {
        // 1 - s vanishes at radius 1.
        let lens = Rational::try_new([0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0]).unwrap();
        assert!((lens.fold - 0.99_f64.sqrt()).abs() < 1e-6, "{}", lens.fold);
        assert_eq!(lens.distort(Vector2::new(1.001, 0.0)), None);
        let d = lens.distort(Vector2::new(0.9, 0.0)).unwrap();
        assert!((lens.undistort(d).unwrap().point.x - 0.9).abs() < 1e-12);
        assert!(lens.undistort(Vector2::new(1e3, 0.0)).is_none());
        assert!(lens.undistort(Vector2::new(f64::NAN, 0.0)).is_none());
    }

    #[test]
    fn coefficients_out_of_range_are_refused() {
        for bad in [f32::NAN, f32::INFINITY, 2e5] {
            let k = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, bad];
            assert_eq!(Rational::try_new(k), Err(CameraError::Distortion));
        }
    }
}
