//! Calibrations: extrinsics with the cameras that they belong to, and when the cameras are corrected.

use core::fmt;

use super::Calibrator;
use crate::batch::correspondence::Cameras;
use crate::error::ApplyError;
use crate::fusion::lens_reference::LensReference;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::CorrectedExtrinsics;
use crate::scalar::Scalar;

/// One calibration: extrinsics, and the cameras that they belong to. With other cameras the extrinsics are wrong.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Calibration<T: Scalar> {
    /// The cameras as given, or corrected with [`crate::LensTracking::Compensate`].
    pub cameras: Cameras<T>,
    /// `p_r = R p_l + t`.
    pub extrinsics: Extrinsics<T>,
}

impl<T: Scalar> fmt::Display for Calibration<T> {
    /// The extrinsics.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.extrinsics.fmt(f)
    }
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// The calibration in use; `None` without cameras.
    pub fn calibration_in_use(&self) -> Option<Calibration<T>> {
        self.calibration(&self.in_use)
    }

    /// Extrinsics with the corrected cameras that they belong to.
    #[inline(never)]
    pub(super) fn calibration(&self, of: &CorrectedExtrinsics<T>) -> Option<Calibration<T>> {
        let CorrectedExtrinsics { extrinsics, correction } = *of;
        let given = *self.cameras.as_ref()?;
        // As given, bit for bit.
        let cameras =
            if correction.is_none() { given } else { given.corrected(&correction).ok()? };
        Some(Calibration { cameras, extrinsics })
    }

    /// Begins again with other lens models, where that gains; whether it did.
    #[inline(never)]
    pub(super) fn correct_lens(&mut self) -> bool {
        let Some((reference, corrected)) = self.next_lens() else { return false };
        self.corrected = Some(corrected);
        self.estimator.begin_again(&reference);
        self.batch.clear();
        true
    }

    /// The lens to begin again with, and its cameras.
    fn next_lens(&self) -> Option<(LensReference<T>, Cameras<T>)> {
        let cameras = self.cameras.as_ref()?;
        let context = self.estimator.context(&self.config, &self.factory, self.cameras.as_ref())?;
        let reference = self.estimator.next_reference(&context)?;
        let corrected = cameras.corrected(reference.correction()).ok()?;
        Some((reference, corrected))
    }

    /// Puts a calibration into use and keeps the one before.
    ///
    /// # Errors
    /// [`ApplyError::Inconsistent`] where no cameras belong to it; nothing changes.
    // Out of line: its stack is not that of the proposal.
    #[inline(never)]
    pub(super) fn put_into_use(
        &mut self,
        applied: CorrectedExtrinsics<T>,
    ) -> Result<Calibration<T>, ApplyError> {
        // Before anything changes: cameras out of range are no calibration.
        let calibration = self.calibration(&applied).ok_or(ApplyError::Inconsistent)?;
        let before = self.in_use;
        if self.replace_in_use(applied) {
            self.before = Some(before);
        }
        Ok(calibration)
    }

    /// Replaces the calibration in use; whether it changed.
    // Out of line: a second copy took 0.7 kB at opt-level 3.
    #[inline(never)]
    pub(super) fn replace_in_use(&mut self, new: CorrectedExtrinsics<T>) -> bool {
        let changed = self.in_use != new;
        if changed {
            self.in_use = new;
            self.generation = self.generation.wrapping_add(1);
        }
        changed
    }
}
