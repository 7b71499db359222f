//! Common parts of the lens models: range of the coefficients, fold of the distortion, Newton step of an undistortion,
//! and serialisation.

use nalgebra::{Matrix2, Vector2};

use crate::error::CameraError;
use crate::scalar::Scalar;
use crate::thresholds::{FOLD_BISECTIONS, FOLD_SAMPLES, MAX_DISTORTION};

/// Refuses coefficients that are not finite or above 1e3 in magnitude.
pub(super) fn check<T: Scalar>(coefficients: &[T]) -> Result<(), CameraError> {
    check_within(coefficients, MAX_DISTORTION)
}

/// Refuses coefficients that are not finite or above `most` in magnitude.
pub(super) fn check_within<T: Scalar>(coefficients: &[T], most: f64) -> Result<(), CameraError> {
    let sane = |k: &T| k.abs() <= T::lit(most);
    if coefficients.iter().all(sane) { Ok(()) } else { Err(CameraError::Distortion) }
}

/// Returns the smallest argument in `0..=limit` at which `slope` is not positive, or `limit` if `slope` is positive
/// everywhere.
///
/// Cost: up to 256 samples, then 30 bisections if the slope vanishes. A dip narrower than 1/256 of the range may stay
/// undetected.
#[inline(never)]
pub(super) fn first_fold<T: Scalar>(slope: &dyn Fn(T) -> T, limit: T) -> T {
    let at = |i: u32| limit * (T::count(i) / T::count(FOLD_SAMPLES));
    let folded = |x: T| !(slope(x) > T::ZERO);
    let Some(first) = (1..=FOLD_SAMPLES).find(|&i| folded(at(i))) else {
        return limit;
    };
    let (mut low, mut high) = (at(first.saturating_sub(1)), at(first));
    for _ in 0..FOLD_BISECTIONS {
        let middle = (low + high) * T::HALF;
        if folded(middle) { high = middle } else { low = middle }
    }
    low
}

/// Undistorted point of a lens, and the density of the image there.
#[derive(Debug, Clone, Copy)]
pub(super) struct Undistorted<T> {
    /// Point at unit depth, dimensionless.
    pub(super) point: Vector2<T>,
    /// Determinant of the Jacobian of the distortion: area in the image over area at unit depth, relative to a pinhole
    /// of the same focal length. It is above 0.
    pub(super) density: T,
}

/// Returns the Newton step of an undistortion, to be subtracted from the undistorted point, and the determinant of the
/// Jacobian. `None` if the determinant is not positive.
///
/// * `error`: distorted point minus the given point, dimensionless.
/// * `j`: Jacobian of the distortion.
#[inline(always)]
pub(super) fn newton_step<T: Scalar>(error: Vector2<T>, j: &Matrix2<T>) -> Option<(Vector2<T>, T)> {
    let determinant = j.m11 * j.m22 - j.m12 * j.m21;
    (determinant > T::ZERO).then(|| {
        let step = Vector2::new(
            (j.m22 * error.x - j.m12 * error.y) / determinant,
            (j.m11 * error.y - j.m21 * error.x) / determinant,
        );
        (step, determinant)
    })
}

/// Serialises a lens model as its coefficients; `TryFrom` checks coefficients that are read.
macro_rules! as_coefficients {
    ($lens:ident, $count:literal) => {
        #[cfg(feature = "serde")]
        impl<T: Scalar> TryFrom<[T; $count]> for $lens<T> {
            type Error = CameraError;

            fn try_from(coefficients: [T; $count]) -> Result<Self, CameraError> {
                Self::try_new(coefficients)
            }
        }

        #[cfg(feature = "serde")]
        impl<T: serde::Serialize> serde::Serialize for $lens<T> {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                self.coefficients.serialize(to)
            }
        }
    };
}
pub(super) use as_coefficients;
