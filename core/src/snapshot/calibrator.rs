//! State of a calibrator as a record.

use super::factory::fingerprint;
use crate::batch::correspondence::Cameras;
use crate::calibrator::Calibrator;
use crate::calibrator::estimator::Estimator;
use crate::codec::{self, OVERHEAD_BYTES, Reader, RecordHeader, RecordKind, Writer, believe};
use crate::config::{Context, LensTracking};
use crate::error::{RestoreError, SnapshotError};
use crate::geometry::lens_correction::CorrectedExtrinsics;
use crate::scalar::Scalar;

/// Numbers and words beside the estimator's: what is in use and was before; generation, frozen, whether
/// anything was before.
const NUMBERS: usize = 28;
const WORDS: usize = 3;

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Length of the longest record of [`Calibrator::snapshot`]: 4,240 bytes in `f32`.
    pub const SNAPSHOT_BYTES: usize = OVERHEAD_BYTES
        + 4 * (WORDS + Estimator::<T>::WORDS)
        + (NUMBERS + Estimator::<T>::NUMBERS) * size_of::<T>();

    /// Writes the estimate and the calibration in use as a record, for storage that survives power loss; returns the
    /// part of the buffer that it takes. Not in it: cameras and factory extrinsics ([`crate::FactoryCalibration`]),
    /// the batch, and a pair being solved.
    ///
    /// # Errors
    /// [`SnapshotError`].
    pub fn snapshot<'b>(&self, buffer: &'b mut [u8]) -> Result<&'b [u8], SnapshotError> {
        let label = self.label().ok_or(SnapshotError::NoCameras)?;
        codec::write::<T>(label, buffer, |to| self.write(to))
            .map_err(|needed| SnapshotError::Room { needed })
    }

    /// Restores a record: the extrinsics in use, and the estimate with the pairs behind it. The state is
    /// [`crate::State::Suspect`] until a pair confirms the estimate, because the rig may have changed meanwhile.
    ///
    /// For a calibrator without pairs, right after [`Calibrator::set_cameras`] and [`Calibrator::set_factory`].
    ///
    /// # Errors
    /// [`RestoreError`]; nothing changes, except that a pair solved before can no longer be fused.
    pub fn restore(&mut self, record: &[u8]) -> Result<(), RestoreError> {
        let label = self.label().ok_or(RestoreError::NoCameras)?;
        if self.estimator.has_pairs() || self.estimator.is_busy() {
            return Err(RestoreError::NotFresh);
        }
        self.read(&mut codec::open::<T>(label, record)?)
    }

    fn label(&self) -> Option<RecordHeader> {
        let rig = fingerprint(self.cameras.as_ref()?, &self.factory);
        Some(RecordHeader { kind: RecordKind::State, method: self.estimator.number(), rig })
    }

    fn write(&self, to: &mut Writer<'_>) {
        self.in_use.write(to);
        to.flag(self.before.is_some());
        if let Some(before) = &self.before {
            before.write(to);
        }
        to.word(self.generation);
        to.flag(self.frozen);
        self.estimator.write(to);
    }

    fn read(&mut self, from: &mut Reader<'_>) -> Result<(), RestoreError> {
        let in_use = CorrectedExtrinsics::read(from)?;
        let before = if from.flag()? { Some(CorrectedExtrinsics::read(from)?) } else { None };
        let generation = from.word()?;
        let frozen = from.flag()?;
        let cameras = self.cameras.as_ref().ok_or(RestoreError::NoCameras)?;
        let context = Context::new(&self.config, &self.factory, cameras.mean_focal());
        let put = [Some(in_use), before];
        put.iter().flatten().try_for_each(|put| check(put, cameras, &context))?;
        self.estimator.read(&context, from)?;
        let corrected = self.corrected_by(&put).inspect_err(|_| self.estimator.reset())?;
        // Whoever has taken up the extrinsics of now must notice those of the record.
        let unnoticed = in_use != self.in_use && generation == self.generation;
        self.generation = if unnoticed { generation.wrapping_add(1) } else { generation };
        (self.in_use, self.before, self.frozen) = (in_use, before, frozen);
        self.corrected = Some(corrected);
        Ok(())
    }

    /// The cameras of the rays, once the estimator and what was put into use are read.
    ///
    /// # Errors
    /// [`RestoreError::Preset`] where the configuration only reports and a camera was corrected: its caller rectifies
    /// with the given cameras, and the extrinsics of others would mislead.
    fn corrected_by(
        &self,
        put: &[Option<CorrectedExtrinsics<T>>; 2],
    ) -> Result<Cameras<T>, RestoreError> {
        let rays = self.estimator.correction();
        let given = rays.is_none() && put.iter().flatten().all(|put| put.correction.is_none());
        if !given && self.config.lens_tracking == LensTracking::Report {
            return Err(RestoreError::Preset);
        }
        let cameras = self.cameras.as_ref().ok_or(RestoreError::NoCameras)?;
        cameras.corrected(&rays).map_err(|_| RestoreError::Absurd)
    }
}

/// Checks that extrinsics were once put into use: within the correction limit, of cameras that there are.
fn check<T: Scalar>(
    put: &CorrectedExtrinsics<T>,
    cameras: &Cameras<T>,
    context: &Context<'_, T>,
) -> Result<(), RestoreError> {
    let CorrectedExtrinsics { extrinsics, correction } = put;
    if !context.allows_in_use(extrinsics) {
        return Err(RestoreError::CorrectionLimit);
    }
    believe(correction.is_none() || cameras.corrected(correction).is_ok())
}
