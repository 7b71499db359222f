//! Extrinsics of a stereo rig: `p_r = R p_l + t`, `|t| = 1` (eq 1).

use core::fmt;

use nalgebra::{ArrayStorage, ComplexField, Matrix3, Rotation3, Unit, Vector3};

use super::so3;
use crate::error::ExtrinsicsError;
use crate::scalar::Scalar;
use crate::thresholds::MIN_LATERAL;

/// Largest rounding error of an element of a rotation or of a unit vector, in units in the last place of 1.
const ROUNDING: f64 = 16.0;

/// `R` and unit `t` of `p_r = R p_l + t`. For a plain side-by-side rig `t = (-1, 0, 0)`.
///
/// The scale is not observable: multiply `t` by the known baseline length to get metres.
///
/// Invariants: finite, `R` orthonormal, `|t| = 1`, `t` at least 6 degrees off both optical axes.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::Extrinsics;
/// // As cv::stereoCalibrate returns R, row by row, and T, here in m.
/// let r = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
/// let extrinsics = Extrinsics::<f32>::from_row_major(r, [-0.12, 0.0, 0.0])?;
/// assert_eq!(extrinsics, Extrinsics::SIDE_BY_SIDE);
/// let in_metres = extrinsics.translation().into_inner() * 0.12;
/// # assert_eq!(in_metres.x, -0.12);
/// assert_eq!(extrinsics.to_string(), "R 0.00000 0.00000 0.00000 rad, t -1.00000 0.00000 0.00000");
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(into = "Plain<T>", try_from = "Plain<T>"))]
pub struct Extrinsics<T: Scalar> {
    rotation: Rotation3<T>,
    translation: Unit<Vector3<T>>,
}

impl<T: Scalar> Extrinsics<T> {
    /// `R = I`, `t = (-1, 0, 0)`: two parallel cameras side by side.
    pub const SIDE_BY_SIDE: Self = {
        let (zero, one) = (T::ZERO, T::ONE);
        Self {
            rotation: Rotation3::from_matrix_unchecked(Matrix3::from_array_storage(ArrayStorage(
                [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
            ))),
            translation: Unit::new_unchecked(Vector3::new(T::MINUS_ONE, zero, zero)),
        }
    };

    /// Returns extrinsics with the rotation nearest to `r` and the direction of `t`.
    ///
    /// * `r`: left to right camera frame, within about 0.1 of a rotation ([`so3::nearest_rotation`]).
    /// * `t`: position of the left camera in the right camera frame, any unit.
    ///
    /// # Errors
    /// [`ExtrinsicsError`]: `r` is not a rotation, `t` has no direction, or the baseline is within 6 degrees of an
    /// optical axis.
    pub fn try_new(r: &Matrix3<T>, t: &Vector3<T>) -> Result<Self, ExtrinsicsError> {
        let rotation = so3::nearest_rotation(r).ok_or(ExtrinsicsError::NotARotation)?;
        // Scaled first, because the square of a tiny or huge component under- or overflows.
        let largest = t.amax();
        let finite = t.iter().all(ComplexField::is_finite);
        if !finite || largest == T::ZERO {
            return Err(ExtrinsicsError::NoDirection);
        }
        let translation = Unit::new_normalize(t / largest);
        // The baseline in the left camera frame is R^T t.
        let lateral = |t: &Vector3<T>| t.x * t.x + t.y * t.y >= T::lit(MIN_LATERAL * MIN_LATERAL);
        if lateral(&translation) && lateral(&rotation.inverse_transform_vector(&translation)) {
            Ok(Self { rotation, translation })
        } else {
            Err(ExtrinsicsError::AlongOpticalAxis)
        }
    }

    /// Returns extrinsics as [`Extrinsics::try_new`] does, from `R` row by row, the order of files and wire formats. A
    /// rotation and a unit vector that are exact up to rounding are kept bit for bit, so that writing and reading do
    /// not change extrinsics.
    ///
    /// # Errors
    /// As [`Extrinsics::try_new`].
    pub fn from_row_major(r: [T; 9], t: [T; 3]) -> Result<Self, ExtrinsicsError> {
        let (r, t) = (row_major(r), Vector3::from(t));
        let nearest = Self::try_new(&r, &t)?;
        let off = (nearest.rotation.matrix() - r)
            .amax()
            .max((nearest.translation.into_inner() - t).amax());
        let rotation = Rotation3::from_matrix_unchecked(r);
        let given = Self { rotation, translation: Unit::new_unchecked(t) };
        Ok(if off <= T::EPSILON * T::lit(ROUNDING) { given } else { nearest })
    }

    /// Returns `R`, left to right camera frame: `p_r = R p_l + t`.
    pub const fn rotation(&self) -> &Rotation3<T> {
        &self.rotation
    }

    /// Returns the unit vector `t`, in the right camera frame.
    pub fn translation(&self) -> &Unit<Vector3<T>> {
        &self.translation
    }

    /// Returns `R` row by row, the order of files and wire formats.
    pub fn rotation_row_major(&self) -> [T; 9] {
        let m = self.rotation.matrix();
        [m.m11, m.m12, m.m13, m.m21, m.m22, m.m23, m.m31, m.m32, m.m33]
    }
}

impl<T: Scalar> fmt::Display for Extrinsics<T> {
    /// Writes `R` as a rotation vector, rad, and unit `t`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([[a, b, c]], [[x, y, z]]) = (so3::log(&self.rotation).data.0, self.translation.data.0);
        write!(f, "R {a:.5} {b:.5} {c:.5} rad, t {x:.5} {y:.5} {z:.5}")
    }
}

#[cfg(feature = "defmt")]
impl<T: Scalar + defmt::Format> defmt::Format for Extrinsics<T> {
    fn format(&self, f: defmt::Formatter<'_>) {
        let ([w], [t]) = (so3::log(&self.rotation).data.0, self.translation.data.0);
        defmt::write!(f, "R {} rad, t {}", w, t);
    }
}

/// Serialised form: `R` row by row, and `t`.
#[cfg(feature = "serde")]
#[derive(serde::Serialize, serde::Deserialize)]
struct Plain<T> {
    rotation: [T; 9],
    translation: [T; 3],
}

#[cfg(feature = "serde")]
impl<T: Scalar> From<Extrinsics<T>> for Plain<T> {
    fn from(extrinsics: Extrinsics<T>) -> Self {
        let [translation] = extrinsics.translation.data.0;
        Self { rotation: extrinsics.rotation_row_major(), translation }
    }
}

#[cfg(feature = "serde")]
impl<T: Scalar> TryFrom<Plain<T>> for Extrinsics<T> {
    type Error = ExtrinsicsError;

    fn try_from(plain: Plain<T>) -> Result<Self, ExtrinsicsError> {
        Self::from_row_major(plain.rotation, plain.translation)
    }
}

/// Returns a matrix from its rows. `from_row_slice` of nalgebra can panic.
fn row_major<T: Scalar>([a, b, c, d, e, f, g, h, i]: [T; 9]) -> Matrix3<T> {
    Matrix3::new(a, b, c, d, e, f, g, h, i)
}
