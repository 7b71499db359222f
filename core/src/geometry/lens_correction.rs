//! Correction of the given lens models, and calibrations that belong to corrected cameras.

use nalgebra::Vector2;

use super::extrinsics::Extrinsics;
use crate::codec::{Reader, Writer};
use crate::error::RestoreError;
use crate::scalar::Scalar;
use crate::thresholds::MAX_LENS_CORRECTION;

/// What is added to the lens model of the right camera: the two parameters that pairs tell from the extrinsics. Rows show
/// the difference of the cameras, not which of the two has changed: the left one stays as given.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LensCorrection<T> {
    /// Relative focal length: 0.001 makes the right one longer by 0.1 %.
    pub focal: T,
    /// Radial coefficient `k1`.
    pub k1: T,
}

impl<T: Scalar> LensCorrection<T> {
    /// The lens models as given.
    pub const NONE: Self = Self { focal: T::ZERO, k1: T::ZERO };

    /// Whether the lens models are as given.
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }

    /// Whether each part is finite and of a size that a lens may change by.
    pub(crate) fn is_valid(&self) -> bool {
        let most = T::lit(MAX_LENS_CORRECTION);
        self.focal.abs() <= most && self.k1.abs() <= most
    }

    /// The correction with a further one.
    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self { focal: self.focal + other.focal, k1: self.k1 + other.k1 }
    }

    /// Change of right rays from one correction to another.
    pub(crate) fn change_to(&self, other: &Self) -> RayChange<T> {
        let scale = (T::ONE + self.focal) / (T::ONE + other.focal);
        RayChange { scale, k1: other.k1 - self.k1 }
    }

    pub(crate) fn write(&self, to: &mut Writer<'_>) {
        to.numbers(&[self.focal, self.k1]);
    }

    /// # Errors
    /// [`RestoreError::Absurd`] beyond what a lens may change by.
    pub(crate) fn read(from: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let mut parts = [T::ZERO; 2];
        from.numbers(&mut parts)?;
        let [focal, k1] = parts;
        let read = Self { focal, k1 };
        if read.is_valid() { Ok(read) } else { Err(RestoreError::Absurd) }
    }
}

/// Change of the right rays when the lens model changes: exact in the focal length, of first order in `k1`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RayChange<T> {
    scale: T,
    k1: T,
}

impl<T: Scalar> RayChange<T> {
    /// A ray at unit depth with the new lens model.
    pub(crate) fn of(&self, ray: Vector2<T>) -> Vector2<T> {
        ray * (self.scale * (T::ONE - self.k1 * ray.norm_squared()))
    }
}

/// Extrinsics with the correction of the cameras that they belong to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CorrectedExtrinsics<T: Scalar> {
    pub(crate) extrinsics: Extrinsics<T>,
    pub(crate) correction: LensCorrection<T>,
}

impl<T: Scalar> CorrectedExtrinsics<T> {
    pub(crate) fn write(&self, to: &mut Writer<'_>) {
        self.extrinsics.write(to);
        self.correction.write(to);
    }

    /// # Errors
    /// [`RestoreError`].
    pub(crate) fn read(from: &mut Reader<'_>) -> Result<Self, RestoreError> {
        let extrinsics = Extrinsics::read(from)?;
        // Older records know no correction.
        let correction =
            if from.version() < 3 { LensCorrection::NONE } else { LensCorrection::read(from)? };
        Ok(Self { extrinsics, correction })
    }
}
