//! Extrinsics as plain numbers.

use core::ffi::CStr;

use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::ExtrinsicsError;
use zerocopy::FromBytes;

/// `R` and unit `t` of `p_r = R p_l + t`. A plain side-by-side rig has `R = I`, `t = (-1, 0, 0)`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_extrinsics_t {
    /// `R`, left to right camera frame, row by row.
    pub rotation: [f32; 9],
    /// `t`: position of the left camera in the right camera frame. As a result it has unit length; as an argument it
    /// may have any length.
    pub translation: [f32; 3],
}

impl selfcal_extrinsics_t {
    /// All numbers are 0, which stands for cameras side by side.
    pub(crate) const ZERO: Self = Self { rotation: [0.0; 9], translation: [0.0; 3] };

    pub(crate) fn is_zero(&self) -> bool {
        *self == Self::ZERO
    }

    /// Returns the extrinsics of the core, or the text of the fault. It checks all fields, because the caller may have
    /// written any bits.
    pub(crate) fn core(&self) -> Result<Extrinsics<f32>, &'static CStr> {
        if self.is_zero() {
            return Ok(Extrinsics::SIDE_BY_SIDE);
        }
        let found = Extrinsics::from_row_major(self.rotation, self.translation);
        found.map_err(|error| match error {
            ExtrinsicsError::NotARotation => {
                c"extrinsics: R is not finite, not orthonormal to about 0.1, or a reflection"
            }
            ExtrinsicsError::NoDirection => c"extrinsics: t is not finite or has no direction",
            ExtrinsicsError::AlongOpticalAxis => {
                c"extrinsics: t is within 6 degrees of an optical axis; such a rig cannot be rectified"
            }
            _ => c"extrinsics: unknown",
        })
    }
}

impl From<&Extrinsics<f32>> for selfcal_extrinsics_t {
    fn from(extrinsics: &Extrinsics<f32>) -> Self {
        Self {
            rotation: extrinsics.rotation_row_major(),
            translation: extrinsics.translation().into_inner().into(),
        }
    }
}
