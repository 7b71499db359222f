//! Lens models of OpenCV: distortion in closed form, its inverse by a bounded Newton iteration.
//!
//! Points are normalised image coordinates (unit depth), dimensionless; coefficients are in OpenCV's order. The
//! distorted radius of a model may rise only up to some undistorted radius, the fold, where its slope is 0. Beyond the
//! fold the model is not invertible. Both directions refuse points beyond the fold, so that every result of `undistort`
//! distorts to its argument. Close to a radial-tangential or rational fold, mostly within 3 % of its radius, the
//! iteration may not converge; such points are refused.

use nalgebra::{Matrix2, Vector2};

use super::distortion::{Undistorted, as_coefficients, check, first_fold, newton_step};
use super::rational::Rational;
use super::so3::sinc_cos;
use crate::error::CameraError;
use crate::scalar::Scalar;
use crate::thresholds::{
    FISHEYE_NEWTON_ULPS, MAX_NEWTON_STEPS, MAX_TANGENT, NEWTON_START, NEWTON_ULPS,
};

/// Distortion of a lens relative to a pinhole.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>")))]
pub enum Lens<T> {
    /// No distortion.
    Pinhole,
    /// Brown-Conrady model, five coefficients: `cv::undistortPoints`.
    RadialTangential(RadialTangential<T>),
    /// Kannala-Brandt equidistant model, four coefficients: `cv::fisheye`.
    Fisheye(Fisheye<T>),
    /// Rational model, eight coefficients: `cv::undistortPoints`, `CALIB_RATIONAL_MODEL`.
    Rational(Rational<T>),
}

impl<T: Scalar> Lens<T> {
    /// Returns the coefficients, in OpenCV's order.
    pub(crate) fn coefficients(&self) -> &[T] {
        match self {
            Self::Pinhole => &[],
            Self::RadialTangential(lens) => &lens.coefficients,
            Self::Fisheye(lens) => &lens.coefficients,
            Self::Rational(lens) => &lens.coefficients,
        }
    }

    /// Maps undistorted to distorted coordinates; returns `None` beyond the fold, beyond 85 degrees, and for NaN.
    pub(super) fn distort(&self, p: Vector2<T>) -> Option<Vector2<T>> {
        let limit = T::lit(MAX_TANGENT);
        if !(p.norm_squared() <= limit * limit) {
            return None;
        }
        match self {
            Self::Pinhole => Some(p),
            Self::RadialTangential(lens) => lens.distort(p),
            Self::Fisheye(lens) => lens.distort(p),
            Self::Rational(lens) => lens.distort(p),
        }
    }

    /// Returns the lens with `k1` added to its first radial coefficient. A pinhole becomes radial-tangential unless
    /// `k1` is 0. In a rational lens also `k2` and `k3` change ([`Rational::corrected`]).
    ///
    /// # Errors
    /// [`CameraError::Distortion`] if a coefficient is then out of range.
    pub(super) fn corrected(&self, k1: T) -> Result<Self, CameraError> {
        Ok(match self {
            Self::Pinhole if k1 == T::ZERO => Self::Pinhole,
            Self::Pinhole => {
                let coefficients = [k1, T::ZERO, T::ZERO, T::ZERO, T::ZERO];
                Self::RadialTangential(RadialTangential::try_new(coefficients)?)
            }
            Self::RadialTangential(lens) => {
                let [own, k2, p1, p2, k3] = lens.coefficients;
                Self::RadialTangential(RadialTangential::try_new([own + k1, k2, p1, p2, k3])?)
            }
            Self::Fisheye(lens) => {
                let [own, k2, k3, k4] = lens.coefficients;
                Self::Fisheye(Fisheye::try_new([own + k1, k2, k3, k4])?)
            }
            Self::Rational(lens) => Self::Rational(lens.corrected(k1)?),
        })
    }

    /// Maps distorted to undistorted coordinates. Returns `None` where the model is not invertible, where the iteration
    /// does not converge, and if the result is beyond 85 degrees.
    #[inline(always)]
    pub(super) fn undistort(&self, d: Vector2<T>) -> Option<Undistorted<T>> {
        let limit = T::lit(MAX_TANGENT);
        let undistorted = match self {
            Self::Pinhole => Undistorted { point: d, density: T::ONE },
            _ => self.undistort_by_iterations(d)?,
        };
        (undistorted.point.norm_squared() <= limit * limit).then_some(undistorted)
    }

    /// Undistorts by iteration. This function is separate from [`Self::undistort`], because that saves 30 instructions
    /// in the push of a match of a pinhole camera.
    fn undistort_by_iterations(&self, d: Vector2<T>) -> Option<Undistorted<T>> {
        match self {
            Self::Pinhole => Some(Undistorted { point: d, density: T::ONE }),
            Self::RadialTangential(lens) => lens.undistort(d),
            Self::Fisheye(lens) => lens.undistort(d),
            Self::Rational(lens) => lens.undistort(d),
        }
    }
}

/// Radial and tangential distortion (Brown-Conrady), `k1 k2 p1 p2 k3`, with `s = x^2 + y^2`:
/// `x_d = x (1 + k1 s + k2 s^2 + k3 s^3) + 2 p1 x y + p2 (s + 2 x^2)`,
/// `y_d = y (1 + k1 s + k2 s^2 + k3 s^3) + p1 (s + 2 y^2) + 2 p2 x y`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "[T; 5]", bound(deserialize = "T: Scalar + serde::Deserialize<'de>"))
)]
pub struct RadialTangential<T> {
    coefficients: [T; 5],
    /// Squared undistorted radius at which the slope of the distorted radius vanishes, without the tangential terms; at
    /// most [`MAX_TANGENT`] squared.
    fold_squared: T,
}

as_coefficients!(RadialTangential, 5);

impl<T: Scalar> RadialTangential<T> {
    /// Returns the lens with the coefficients `[k1, k2, p1, p2, k3]`, in OpenCV's order.
    ///
    /// # Errors
    /// [`CameraError::Distortion`] if a coefficient is not finite or above 1e3 in magnitude.
    pub fn try_new(coefficients: [T; 5]) -> Result<Self, CameraError> {
        check(&coefficients)?;
        let [k1, k2, _, _, k3] = coefficients;
        let slope = |r: T| {
            let s = r * r;
            T::ONE + s * (T::lit(3.0) * k1 + s * (T::lit(5.0) * k2 + s * T::lit(7.0) * k3))
        };
        let fold = first_fold(&slope, T::lit(MAX_TANGENT));
        Ok(Self { coefficients, fold_squared: fold * fold })
    }

    /// Returns `[k1, k2, p1, p2, k3]`.
    pub fn coefficients(&self) -> [T; 5] {
        self.coefficients
    }

    fn distort(&self, p: Vector2<T>) -> Option<Vector2<T>> {
        (p.norm_squared() < self.fold_squared).then(|| self.map(p))
    }

    /// Returns the distorted point, without a check of the fold.
    fn map(&self, p: Vector2<T>) -> Vector2<T> {
        let [k1, k2, p1, p2, k3] = self.coefficients;
        let (x, y) = (p.x, p.y);
        let (xx, yy, xy) = (x * x, y * y, x * y);
        let s = xx + yy;
        let radial = T::ONE + s * (k1 + s * (k2 + s * k3));
        let two = T::lit(2.0);
        Vector2::new(
            x * radial + two * p1 * xy + p2 * (s + two * xx),
            y * radial + p1 * (s + two * yy) + two * p2 * xy,
        )
    }

    /// Returns the derivative of [`Self::map`] by the point, with the rows `x_d` and `y_d`. The matrix is symmetric.
    fn jacobian(&self, p: Vector2<T>) -> Matrix2<T> {
        let [k1, k2, p1, p2, k3] = self.coefficients;
        let (x, y) = (p.x, p.y);
        let s = x * x + y * y;
        let (two, six) = (T::lit(2.0), T::lit(6.0));
        let radial = T::ONE + s * (k1 + s * (k2 + s * k3));
        let twice_slope = two * (k1 + s * (two * k2 + s * T::lit(3.0) * k3));
        let mixed = x * y * twice_slope + two * (p1 * x + p2 * y);
        Matrix2::new(
            radial + x * x * twice_slope + two * p1 * y + six * p2 * x,
            mixed,
            mixed,
            radial + y * y * twice_slope + six * p1 * y + two * p2 * x,
        )
    }

    /// Undistorts by Newton's method. It starts at the distorted point. If that is beyond the fold, it starts inside
    /// the fold, in the same direction from the centre. The density is that before the last step, which is negligible.
    fn undistort(&self, d: Vector2<T>) -> Option<Undistorted<T>> {
        let squared = d.norm_squared();
        let mut p = if squared < self.fold_squared {
            d
        } else {
            d * ((self.fold_squared / squared).sqrt() * T::lit(NEWTON_START))
        };
        for _ in 0..MAX_NEWTON_STEPS {
            let error = self.map(p) - d;
            let (step, density) = newton_step(error, &self.jacobian(p))?;
            p -= step;
            if step.amax() <= T::lit(NEWTON_ULPS) * T::EPSILON * (T::ONE + p.amax()) {
                let is_within = p.norm_squared() < self.fold_squared;
                return is_within.then_some(Undistorted { point: p, density });
            }
        }
        None
    }
}

/// Equidistant fisheye (Kannala-Brandt), `theta` the angle from the axis, rad:
/// `theta_d = theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8)`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "[T; 4]", bound(deserialize = "T: Scalar + serde::Deserialize<'de>"))
)]
pub struct Fisheye<T> {
    coefficients: [T; 4],
    /// Angle from the axis at which the polynomial folds back, rad, at most 85 degrees.
    fold: T,
}

as_coefficients!(Fisheye, 4);

impl<T: Scalar> Fisheye<T> {
    /// Returns the lens with the coefficients `[k1, k2, k3, k4]`, in OpenCV's order.
    ///
    /// # Errors
    /// [`CameraError::Distortion`] if a coefficient is not finite or above 1e3 in magnitude.
    pub fn try_new(coefficients: [T; 4]) -> Result<Self, CameraError> {
        check(&coefficients)?;
        let limit = T::lit(MAX_TANGENT).atan();
        let mut lens = Self { coefficients, fold: limit };
        lens.fold = first_fold(&|theta| lens.slope(theta), limit);
        Ok(lens)
    }

    /// Returns `[k1, k2, k3, k4]`.
    pub fn coefficients(&self) -> [T; 4] {
        self.coefficients
    }

    /// Returns the distorted angle `theta_d`, rad.
    fn angle(&self, theta: T) -> T {
        let [k1, k2, k3, k4] = self.coefficients;
        let s = theta * theta;
        theta * (T::ONE + s * (k1 + s * (k2 + s * (k3 + s * k4))))
    }

    /// Returns the derivative of [`Self::angle`].
    fn slope(&self, theta: T) -> T {
        let [k1, k2, k3, k4] = self.coefficients;
        let s = theta * theta;
        let [c1, c2, c3, c4] = [3.0, 5.0, 7.0, 9.0].map(T::lit);
        T::ONE + s * (c1 * k1 + s * (c2 * k2 + s * (c3 * k3 + s * c4 * k4)))
    }

    fn distort(&self, p: Vector2<T>) -> Option<Vector2<T>> {
        let radius = p.norm();
        let theta = radius.atan2(T::ONE);
        if !(theta < self.fold) {
            return None;
        }
        Some(if radius > T::EPSILON { p * (self.angle(theta) / radius) } else { p })
    }

    /// Undistorts by Newton's method in a bracket. The polynomial rises up to the fold, so bisection can replace every
    /// step that leaves the bracket.
    fn undistort(&self, d: Vector2<T>) -> Option<Undistorted<T>> {
        let target = d.norm();
        if target <= T::EPSILON {
            return Some(Undistorted { point: d, density: T::ONE });
        }
        let (mut low, mut high) = (T::ZERO, self.fold);
        if !(target < self.angle(high)) {
            return None;
        }
        let mut theta = if target < high { target } else { high * T::HALF };
        for _ in 0..4 * MAX_NEWTON_STEPS {
            let error = self.angle(theta) - target;
            if error > T::ZERO {
                high = theta;
            } else {
                low = theta;
            }
            let newton = theta - error / self.slope(theta);
            let next = if newton > low && newton < high { newton } else { (low + high) * T::HALF };
            let step = (next - theta).abs();
            theta = next;
            if step <= T::lit(FISHEYE_NEWTON_ULPS) * T::EPSILON * theta {
                break;
            }
        }
        let (sinc, cos) = sinc_cos(theta * theta);
        let radius = theta * sinc / cos;
        // `d theta_d / d radius` along the radius times `theta_d / radius` across it.
        let density = self.slope(theta) * cos * cos * target / radius;
        Some(Undistorted { point: d * (radius / target), density })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn derivatives_of_the_lens_models_match_central_differences(
            k in [-0.3..0.3_f64, -0.3..0.3, -0.01..0.01, -0.01..0.01, -0.3..0.3],
            x in -0.8..0.8_f64, y in -0.6..0.6_f64,
        ) {
            let difference = |of: &dyn Fn(f64) -> f64| {
                let h = 1e-3;
                (8.0 * (of(h) - of(-h)) - (of(2.0 * h) - of(-2.0 * h))) / (12.0 * h)
            };
            let brown = RadialTangential::try_new(k).unwrap();
            let jacobian = brown.jacobian(Vector2::new(x, y));
            for (row, column) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
                let numeric = difference(&|h| {
                    let d = if column == 0 { Vector2::new(h, 0.0) } else { Vector2::new(0.0, h) };
                    brown.map(Vector2::new(x, y) + d)[row]
                });
                prop_assert!((jacobian[(row, column)] - numeric).abs() < 1e-9, "{row} {column}");
            }
            let [k1, k2, p1, p2, k3] = k;
            let fisheye = Fisheye::try_new([k1, k2, p1 + p2, k3]).unwrap();
            let theta = x.hypot(y);
            let numeric = difference(&|h| fisheye.angle(theta + h));
            prop_assert!((fisheye.slope(theta) - numeric).abs() < 1e-9);
        }
    }
}
