//! Extrinsics of a stereo rig: `p_r = R p_l + t`, `|t| = 1` (eq 1).

use nalgebra::{ArrayStorage, ComplexField, Matrix3, Rotation3, Unit, Vector3};

use super::so3;
use crate::codec::{Reader, Writer};
use crate::error::{ExtrinsicsError, RestoreError};
use crate::scalar::Scalar;
use crate::thresholds::MIN_LATERAL;

/// Largest distance of a component of a recorded baseline from its unit vector.
const UNIT: f64 = 2e-6;

/// `R` and unit `t` of `p_r = R p_l + t`. For a plain side-by-side rig `t = (-1, 0, 0)`.
///
/// The scale is not observable: multiply `t` by the known baseline length to get metres.
///
/// Invariants: finite, `R` orthonormal, `|t| = 1`, `t` at least 6 degrees off both optical axes.
#[derive(Debug, Clone, Copy, PartialEq)]
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

    /// The nearest rotation to a matrix, and the direction of a baseline of any length.
    ///
    /// * `r`: left to right camera frame, orthonormal to about 0.1 in its elements.
    /// * `t`: position of the left camera in the right camera frame, any unit.
    ///
    /// # Errors
    /// [`ExtrinsicsError`]: no rotation, no direction, or a baseline along an optical axis.
    pub fn try_new(r: &Matrix3<T>, t: &Vector3<T>) -> Result<Self, ExtrinsicsError> {
        let rotation = so3::nearest_rotation(r).ok_or(ExtrinsicsError::NotARotation)?;
        // Scaled first: the square of a tiny or huge component under- or overflows.
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

    /// `R`, left to right camera frame: `p_r = R p_l + t`.
    pub const fn rotation(&self) -> &Rotation3<T> {
        &self.rotation
    }

    /// Unit `t`, right camera frame.
    pub fn translation(&self) -> &Unit<Vector3<T>> {
        &self.translation
    }

    /// Writes `R` column by column, then `t`.
    pub(crate) fn write(&self, to: &mut Writer<'_>) {
        to.numbers(self.rotation.matrix());
        to.numbers(self.translation.iter());
    }

    /// Reads what [`Self::write`] writes, bit-identical.
    ///
    /// # Errors
    /// [`RestoreError::Absurd`] if the numbers are no extrinsics.
    pub(crate) fn read(from: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let rotation = so3::read(from)?;
        let mut translation = Vector3::zeros();
        from.numbers(translation.iter_mut())?;
        let exact = Self::try_new(rotation.matrix(), &translation);
        let exact = exact.map_err(|_| RestoreError::Absurd)?.translation;
        if (exact.into_inner() - translation).amax() <= T::lit(UNIT) {
            Ok(Self { rotation, translation: Unit::new_unchecked(translation) })
        } else {
            Err(RestoreError::Absurd)
        }
    }

    /// `R` row by row, the order of files and wire formats.
    pub fn rotation_row_major(&self) -> [T; 9] {
        let m = self.rotation.matrix();
        [m.m11, m.m12, m.m13, m.m21, m.m22, m.m23, m.m31, m.m32, m.m33]
    }
}
