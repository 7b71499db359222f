//! The two cameras of a rig.

use crate::error::CameraError;
use crate::geometry::camera::Camera;
use crate::geometry::lens_correction::LensCorrection;
use crate::scalar::Scalar;

/// The two cameras of a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(bound(deserialize = "T: Scalar + serde::Deserialize<'de>")))]
pub struct Cameras<T> {
    /// Left camera.
    pub left: Camera<T>,
    /// Right camera.
    pub right: Camera<T>,
}

impl<T: Scalar> Cameras<T> {
    /// Returns the mean focal length of both cameras, px. Its product with a row offset at unit depth is the row offset
    /// in px.
    pub fn mean_focal(&self) -> T {
        (self.left.mean_focal() + self.right.mean_focal()) * T::HALF
    }

    /// Returns the cameras with the lens model of the right camera corrected. A pinhole model becomes radial-tangential
    /// if the correction has a `k1`.
    ///
    /// # Errors
    /// [`CameraError`] names the quantity that the correction moves out of range.
    pub fn corrected(&self, correction: &LensCorrection<T>) -> Result<Self, CameraError> {
        Ok(Self { right: self.right.corrected(correction)?, ..*self })
    }
}
