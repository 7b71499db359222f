//! The measured calls of the core, each in a function that is not inlined.

use stereo_selfcal::batch::Pushed;
use stereo_selfcal::depth::{MotionError, RangeError, RangeReading, Tracks, Witnessed};
use stereo_selfcal::geometry::{RectifiedCamera, RectifyError, RectifyingRotations};
use stereo_selfcal::link::{Decoder, FrameRefusal, FrameSink, Received};
use stereo_selfcal::outcome::Details;
use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{
    ApplyError, Calibration, Calibrator, Cameras, Config, Correspondence, Extrinsics,
    FactoryCalibration, Outcome, Proposal, PushError, RestoreError, Scalar,
};

use crate::lens;

/// Capacity of the batch.
pub(crate) const CAPACITY: usize = 256;

pub(crate) type CalibratorOf<T> = Calibrator<T, CAPACITY>;
pub(crate) type PaperOf<T> = PaperCalibrator<T, CAPACITY>;

/// Size of a snapshot, bytes.
pub(crate) const SNAPSHOT_BYTES: usize = CalibratorOf::<f32>::SNAPSHOT_BYTES;

/// A calibrator with pinhole cameras, before its first pair.
pub(crate) fn fresh<T: Scalar>(config: Config) -> CalibratorOf<T> {
    CalibratorOf::new(config, &FactoryCalibration::guess(lens::pinholes()))
}

/// The published method with pinhole cameras, before its first pair.
pub(crate) fn published<T: Scalar>() -> PaperOf<T> {
    PaperOf::new(Settings::DEFAULT, lens::pinholes(), Extrinsics::SIDE_BY_SIDE)
}

#[inline(never)]
pub(crate) fn advance_published<T: Scalar>(calibrator: &mut PaperOf<T>) -> Option<Outcome<T>> {
    calibrator.advance_pair()
}

#[inline(never)]
pub(crate) fn feed(
    decoder: &mut Decoder,
    bytes: &mut &[u8],
    intake: &mut impl FrameSink,
) -> Result<Option<Received>, FrameRefusal> {
    decoder.feed(bytes, intake)
}

#[inline(never)]
pub(crate) fn push<T: Scalar>(
    calibrator: &mut CalibratorOf<T>,
    c: &Correspondence<T>,
) -> Result<Pushed, PushError> {
    calibrator.push(c)
}

#[inline(never)]
pub(crate) fn advance<T: Scalar>(calibrator: &mut CalibratorOf<T>) -> Option<Outcome<T>> {
    calibrator.advance_pair()
}

#[inline(never)]
pub(crate) fn solve<T: Scalar>(calibrator: &mut CalibratorOf<T>) -> Outcome<T> {
    calibrator.solve_pair()
}

#[inline(never)]
pub(crate) fn details<T: Scalar>(calibrator: &CalibratorOf<T>) -> Option<Details<T>> {
    calibrator.details()
}

#[inline(never)]
pub(crate) fn proposal<T: Scalar>(calibrator: &CalibratorOf<T>) -> Option<Proposal<T>> {
    calibrator.proposal()
}

#[inline(never)]
pub(crate) fn apply<T: Scalar>(
    calibrator: &mut CalibratorOf<T>,
) -> Result<Calibration<T>, ApplyError> {
    calibrator.apply()
}

#[inline(never)]
pub(crate) fn push_range<T: Scalar>(
    calibrator: &mut CalibratorOf<T>,
    reading: &RangeReading<T>,
) -> Result<Witnessed, RangeError> {
    calibrator.push_range(reading)
}

#[inline(never)]
pub(crate) fn advance_tracks<T: Scalar>(
    calibrator: &mut CalibratorOf<T>,
    tracks: &mut Tracks<T, CAPACITY>,
) -> Option<Result<Witnessed, MotionError>> {
    calibrator.advance_tracks(tracks)
}

#[inline(never)]
pub(crate) fn push_tracks<T: Scalar>(
    calibrator: &mut CalibratorOf<T>,
    tracks: &mut Tracks<T, CAPACITY>,
) -> Result<Witnessed, MotionError> {
    calibrator.push_tracks(tracks)
}

#[inline(never)]
pub(crate) fn undo<T: Scalar>(
    calibrator: &mut CalibratorOf<T>,
) -> Result<Calibration<T>, ApplyError> {
    calibrator.undo()
}

#[inline(never)]
pub(crate) fn reset<T: Scalar>(calibrator: &mut CalibratorOf<T>) {
    calibrator.reset();
}

#[inline(never)]
pub(crate) fn rotations<T: Scalar>(extrinsics: &Extrinsics<T>) -> RectifyingRotations<T> {
    extrinsics.into()
}

#[inline(never)]
pub(crate) fn rectified_camera<T: Scalar>(
    cameras: &Cameras<T>,
    rotations: &RectifyingRotations<T>,
) -> Result<RectifiedCamera<T>, RectifyError> {
    RectifiedCamera::try_choose(cameras, rotations, T::ZERO)
}

#[inline(never)]
pub(crate) fn snapshot<T: Scalar>(calibrator: &CalibratorOf<T>) -> [u8; SNAPSHOT_BYTES] {
    calibrator.snapshot()
}

#[inline(never)]
pub(crate) fn restore<T: Scalar>(
    calibrator: &mut CalibratorOf<T>,
    record: &[u8],
) -> Result<(), RestoreError> {
    calibrator.restore(record)
}
