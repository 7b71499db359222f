//! Calibrations, which are extrinsics with the cameras that they belong to, and the correction of the cameras.

use core::fmt;

use nalgebra::Matrix3;

use super::{Calibrator, context};
use crate::error::{ApplyError, RectifyError};
use crate::fusion::lens_reference::LensReference;
use crate::geometry::cameras::Cameras;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::homography::RectifiedCamera;
use crate::geometry::lens_correction::CorrectedExtrinsics;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// One calibration: extrinsics, and the cameras that they belong to. With other cameras the extrinsics are wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Calibration<T: Scalar> {
    /// The cameras of the factory calibration. With [`crate::LensTracking::Compensate`] the right camera may be
    /// corrected.
    pub cameras: Cameras<T>,
    /// `p_r = R p_l + t`.
    pub extrinsics: Extrinsics<T>,
    /// Number that changes whenever the calibration in use changes; wraps around. [`Calibrator::restore`] may change
    /// the number alone.
    pub generation: u32,
}

impl<T: Scalar> fmt::Display for Calibration<T> {
    /// Writes the extrinsics.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.extrinsics.fmt(f)
    }
}

impl<T: Scalar> Calibration<T> {
    /// Returns the common camera of both rectified images, and the homographies `[H_l, H_r]` of eq 5. They map
    /// homogeneous undistorted pixels of each camera to rectified pixels.
    ///
    /// * `alpha`: zoom, 0 to 1. 0 leaves no rectified pixel without image; 1 shows both images entirely.
    ///
    /// # Errors
    /// [`RectifyError`].
    pub fn homographies(
        &self,
        alpha: T,
    ) -> Result<(RectifiedCamera<T>, [Matrix3<T>; 2]), RectifyError> {
        let rotations = RectifyingRotations::from(&self.extrinsics);
        let camera = RectifiedCamera::try_choose(&self.cameras, &rotations, alpha)?;
        Ok((camera, camera.homographies(&self.cameras, &rotations)))
    }
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Returns the calibration in use; at first this is the factory calibration. Load the rectifier with it at start,
    /// and again whenever its generation has changed.
    pub fn in_use(&self) -> Calibration<T> {
        // A calibration whose cameras are out of range is never put into use.
        let cameras = self.cameras_of(&self.in_use).unwrap_or(self.factory.cameras);
        Calibration { cameras, extrinsics: self.in_use.extrinsics, generation: self.generation }
    }

    /// Returns the cameras that the extrinsics belong to; `None` if the correction puts them out of range.
    #[inline(never)]
    fn cameras_of(&self, of: &CorrectedExtrinsics<T>) -> Option<Cameras<T>> {
        let given = self.factory.cameras;
        // Without a correction the cameras stay as given, bit for bit.
        if of.correction.is_none() { Some(given) } else { given.corrected(&of.correction).ok() }
    }

    /// Begins the estimate again with corrected lens models, if that makes it more certain. Then also empties the
    /// batch, because its rays belong to the old lens models. Returns whether the estimate began again.
    #[inline(never)]
    pub(super) fn correct_lens(&mut self) -> bool {
        let Some((reference, corrected)) = self.next_lens() else { return false };
        self.corrected = corrected;
        let context = context(&self.config, &self.factory, &self.fusion);
        self.fusion.begin_again(&reference, &context);
        self.batch.clear();
        true
    }

    /// Returns the corrected lens to begin again with, and the cameras that belong to it.
    fn next_lens(&self) -> Option<(LensReference<T>, Cameras<T>)> {
        let context = context(&self.config, &self.factory, &self.fusion);
        let reference = self.fusion.next_reference(&context)?;
        let corrected = self.factory.cameras.corrected(reference.correction()).ok()?;
        Some((reference, corrected))
    }

    /// Puts a calibration into use, and keeps the previous one for [`Calibrator::undo`] if the calibration changes.
    ///
    /// # Errors
    /// [`ApplyError::Inconsistent`]: the cameras of the calibration are out of range; nothing changes.
    #[inline(never)]
    pub(super) fn put_into_use(
        &mut self,
        applied: CorrectedExtrinsics<T>,
    ) -> Result<Calibration<T>, ApplyError> {
        // Checked before anything changes.
        self.cameras_of(&applied).ok_or(ApplyError::Inconsistent)?;
        let before = self.in_use;
        if self.replace_in_use(applied) {
            self.before = Some(before);
        }
        Ok(self.in_use())
    }

    /// Replaces the calibration in use, and changes the generation if the calibration changes. Returns whether it
    /// changed.
    #[inline(never)]
    pub(super) fn replace_in_use(&mut self, new: CorrectedExtrinsics<T>) -> bool {
        self.next = None;
        let changed = self.in_use != new;
        if changed {
            self.in_use = new;
            self.generation = self.generation.wrapping_add(1);
        }
        changed
    }
}
