//! State of a calibrator as a record: the calibration in use, and the estimate as the prior of a new hypothesis.

use core::f32::consts::PI;

use nalgebra::Vector3;

use super::{Calibrator, context};
use crate::algebra::prior_moments::MAX_RESPONSE;
use crate::config::{Context, LensTracking};
use crate::depth::yaw::MAX_YAW_VARIANCE;
use crate::error::RestoreError;
use crate::fusion::lens_reference::LensReference;
use crate::fusion::prior::{Learned, MAX_INFORMATION, Place, ROUNDED};
use crate::geometry::cameras::Cameras;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3;
use crate::outcome::relief::Relief;
use crate::record::codec::{Range, Reader, Writer, bytes_of, limit, seal};
use crate::record::factory::{FactoryCalibration, fingerprint};
use crate::record::{HEADER_BYTES, OVERHEAD_BYTES, STATE, believe};
use crate::scalar::Scalar;
use crate::thresholds::{
    MAX_IN_USE, MAX_LENS_CORRECTION, MAX_REDUCED_CHI_SQUARE, MAX_VIBRATION_RAD,
};

/// Largest component of a unit vector after rounding.
const UNIT: f32 = 1.0 + 1e-5;
/// Largest ratio of a running mean to its largest term. Rounding can raise the mean slightly above this term.
const MEAN_ROUNDING: f32 = 1.001;
/// Largest magnitude of a yaw, rad, and largest variance of a yaw, rad^2.
const MAX_YAW: f32 = MAX_YAW_VARIANCE;

/// Converts a threshold to the number type of a record.
const fn single(threshold: f64) -> f32 {
    #[expect(clippy::as_conversions, clippy::cast_possible_truncation, reason = "const")]
    {
        threshold as f32
    }
}

const LENS: f32 = single(MAX_LENS_CORRECTION);
const CHI_SQUARE: f32 = single(MAX_REDUCED_CHI_SQUARE) * MEAN_ROUNDING;
const VIBRATION: f32 = single(MAX_VIBRATION_RAD * MAX_VIBRATION_RAD);

/// Ranges of the numbers of [`write_about`].
const ABOUT: [Range; 2] = [(3, -PI, PI), (3, -UNIT, UNIT)];
/// Largest information on a parameter of the lens, dimensionless: a standard deviation of 1e-5, which moves a point at
/// the edge of an image of 4096 px by 0.02 px, a seventh of the noise floor. In `f32`, more information loses the
/// digits of the prior of the other camera beside it.
const LENS_INFORMATION: f32 = 1e10;

/// Ranges of the numbers of [`Learned::numbers`]. The configuration does not change them. A snapshot moves a number to
/// its range: less information on the lens, and in the other cases a difference without an effect. Parts of a matrix
/// are within their ranges before, because a matrix must be scaled as a whole.
const LEARNED: [Range; 15] = [
    // Information, 1/rad^2, gradient, 1/rad, and noise of disparities, 1/rad^2.
    (15 + 2 + 3, -MAX_INFORMATION, MAX_INFORMATION),
    (30, -MAX_RESPONSE, MAX_RESPONSE),
    (1, 0.0, CHI_SQUARE),
    // Noise of a coordinate, px.
    (1, 0.0, 1e6),
    (1, 0.0, MEAN_ROUNDING),
    (1, -MEAN_ROUNDING, MEAN_ROUNDING),
    // Fading sums of matches of high leverage: enough for pairs of a million matches.
    (2, 0.0, 1e7),
    (4, -LENS, LENS),
    (2, 0.0, LENS_INFORMATION),
    (2, 0.0, VIBRATION),
    (2, 0.0, 1.0),
    (1, 0.0, 1.0),
    (2, -MAX_YAW, MAX_YAW),
    (2, 0.0, MAX_YAW),
    (1, -MAX_YAW, MAX_YAW),
];

/// Number of words between the header and the learnt numbers: fingerprint, generation, pairs, two calibrations with
/// their corrections, and the pose.
const WORDS: usize = 3 + 3 * 6 + 2 * 2;
/// Length of a record, bytes.
pub(crate) const BYTES: usize = OVERHEAD_BYTES + 4 * WORDS + bytes_of(&LEARNED);
const _: () = assert!(BYTES <= 400);

/// Flags of the header: a calibration before the one in use exists; the calibrator is frozen; the yaws are known; pairs
/// have shown depth.
const FLAGS: [u8; 4] = [1, 2, 4, 8];

/// Function that reads the calibrations of a record into a calibrator, and the estimate of the record into [`Learned`];
/// it returns whether there is a record.
type Read<'a, C, T> = dyn FnMut(&mut C, &mut Learned<T>) -> Result<bool, RestoreError> + 'a;

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Length of a record of [`Calibrator::snapshot`]: 400 bytes.
    pub const SNAPSHOT_BYTES: usize = BYTES;

    /// Returns the calibration in use and the estimate as a record, for storage that survives a loss of power.
    ///
    /// The estimate is a prior: pose and covariance, noise and inliers, vibration, and the knowledge of lens and mount.
    /// The record also has the calibration for [`Calibrator::undo`], the generation, and whether the calibrator is
    /// frozen. It omits cameras and factory extrinsics ([`crate::FactoryCalibration`]), the batch, a challenger, the
    /// window of the change detection, and the image halves.
    #[must_use]
    pub fn snapshot(&self) -> [u8; BYTES] {
        let mut record = [0; BYTES];
        let mut write = |learned: &mut _| self.write_snapshot(learned, &mut record);
        self.learn(&mut write);
        record
    }

    /// Returns the place of the estimate that a record keeps; `None` without such an estimate.
    pub(crate) fn place(&self) -> Option<Place<T>> {
        self.fusion.place(&context(&self.config, &self.factory, &self.fusion))
    }

    /// Passes the estimate as a prior to `write`.
    // Split into several functions, so that neither the prior nor the record is on the stack while the lens is
    // solved.
    #[inline(never)]
    pub(crate) fn learn<R>(&self, write: &mut dyn FnMut(&mut Learned<T>) -> R) -> R {
        let lens = self.learned_lens();
        self.pass_learned(&lens, write)
    }

    #[inline(never)]
    fn learned_lens(&self) -> LensReference<T> {
        self.fusion.learned_lens(&context(&self.config, &self.factory, &self.fusion))
    }

    #[inline(never)]
    fn pass_learned<R>(
        &self,
        lens: &LensReference<T>,
        write: &mut dyn FnMut(&mut Learned<T>) -> R,
    ) -> R {
        let mut learned = Learned::of_lens(lens);
        self.fill_in(&mut learned);
        write(&mut learned)
    }

    #[inline(never)]
    fn fill_in(&self, learned: &mut Learned<T>) {
        let context = context(&self.config, &self.factory, &self.fusion);
        self.fusion.learn(learned, &context);
    }

    /// Writes the record of [`Calibrator::snapshot`].
    pub(crate) fn write_snapshot(&self, learned: &mut Learned<T>, record: &mut [u8]) {
        let (before, relief) = (self.before.is_some(), self.relief.is_shown());
        let flags = [before, self.frozen, learned.knows_mount, relief];
        let flags = flags.into_iter().zip(FLAGS).filter(|(is_set, _)| *is_set);
        let flags = flags.fold(0, |all, (_, bit)| all | bit);
        let FactoryCalibration { cameras, extrinsics, .. } = &self.factory;
        let mut to = Writer::begin(record, STATE, [flags, learned.changes]);
        for word in [fingerprint(cameras, extrinsics), self.generation, learned.prior.pairs] {
            to.word(word);
        }
        for of in [&self.in_use, self.before.as_ref().unwrap_or(&self.in_use)] {
            write_about(extrinsics, &of.extrinsics, &mut to);
            to.numbers(&[of.correction.focal, of.correction.k1]);
        }
        // Without an estimate there is no pose, and the factory extrinsics take its place.
        write_about(extrinsics, &learned.prior.pose.extrinsics().unwrap_or(*extrinsics), &mut to);
        learned.numbers().into_iter().for_each(|numbers| to.numbers(numbers));
        limit(record.get_mut(HEADER_BYTES + 4 * WORDS..).unwrap_or_default(), &LEARNED);
        seal(record);
    }

    /// Restores the calibration in use and the estimate from a record, and forgets everything learnt before. The
    /// restored estimate is [`crate::State::Suspect`] until a pair confirms it, because the rig may have changed in the
    /// meantime. A calibrator that was frozen at the snapshot is frozen again.
    ///
    /// # Errors
    /// [`RestoreError`]; the calibrator is in the state after [`Calibrator::reset`].
    pub fn restore(&mut self, record: &[u8]) -> Result<(), RestoreError> {
        let mut read = |to: &mut Self, learned: &mut _| to.read(record, learned).map(|()| true);
        self.restore_by(&mut read).map(drop)
    }

    /// Restores the record that `read` passes to [`Calibrator::read`]; returns whether there is a record.
    ///
    /// # Errors
    /// As [`Calibrator::restore`].
    pub(crate) fn restore_by(
        &mut self,
        read: &mut Read<'_, Self, T>,
    ) -> Result<bool, RestoreError> {
        let generation = self.generation;
        self.reset();
        let fresh = core::mem::replace(&mut self.generation, generation);
        let found = self.resume(read);
        let found = found.and_then(|found| believe(self.has_lens()).map(|()| found));
        if found != Ok(true) {
            self.reset();
            self.generation = fresh;
        }
        found
    }

    fn has_lens(&self) -> bool {
        self.fusion.has_lens(&context(&self.config, &self.factory, &self.fusion))
    }

    /// Reads a record and takes up its estimate; returns whether there is a record.
    #[inline(never)]
    fn resume(&mut self, read: &mut Read<'_, Self, T>) -> Result<bool, RestoreError> {
        let mut learned = Learned::nothing();
        let found = read(self, &mut learned)?;
        if found { self.take_up(&learned).map(|()| true) } else { Ok(false) }
    }

    // A separate function, so that the record and these values are never on the stack together.
    #[inline(never)]
    fn take_up(&mut self, learned: &Learned<T>) -> Result<(), RestoreError> {
        let context = context(&self.config, &self.factory, &self.fusion);
        believe(self.fusion.resume(learned, &context).is_some())?;
        self.corrected = self.corrected(&learned.correction())?;
        Ok(())
    }

    /// Reads the calibrations of a record into this calibrator, and the estimate of the record into `learned`. The
    /// calibrator has been reset, but still has the generation before the reset.
    ///
    /// # Errors
    /// As [`Calibrator::restore`].
    pub(crate) fn read(
        &mut self,
        record: &[u8],
        learned: &mut Learned<T>,
    ) -> Result<(), RestoreError> {
        let context = context(&self.config, &self.factory, &self.fusion);
        let (mut from, [flags, changes]) = Reader::begin(record, STATE, BYTES)?;
        let [has_before, frozen, knows_mount, relief] = FLAGS.map(|bit| flags & bit != 0);
        let [rig, generation, pairs] = [(); 3].map(|()| from.word());
        if rig != fingerprint(&self.factory.cameras, context.factory) {
            return Err(RestoreError::OtherRig);
        }
        let in_use = self.read_calibration(&context, &mut from)?;
        let before = self.read_calibration(&context, &mut from)?;
        let extrinsics = read_about(context.factory, &mut from)?;
        if !context.allows_times(T::lit(ROUNDED), &extrinsics) {
            return Err(RestoreError::Config);
        }
        believe(from.is_within(&LEARNED))?;
        learned.prior.pose = RectifyingRotations::from(&extrinsics);
        learned.numbers().into_iter().for_each(|numbers| from.fill(numbers));
        (learned.prior.pairs, learned.changes) = (pairs, changes);
        learned.knows_mount = knows_mount;
        // A record may have the present generation and another calibration. The generation then grows, so that a
        // caller with the present calibration in its rectifier notices the change.
        let is_known = generation == self.generation;
        let is_other = self.replace_in_use(in_use);
        self.generation = generation.wrapping_add((is_known && is_other).into());
        self.before = has_before.then_some(before);
        self.frozen = frozen;
        self.relief = Relief::kept(relief);
        Ok(())
    }

    /// Reads a calibration that is or was in use.
    fn read_calibration(
        &self,
        context: &Context<'_, T>,
        from: &mut Reader<'_>,
    ) -> Result<CorrectedExtrinsics<T>, RestoreError> {
        let extrinsics = read_about(context.factory, from)?;
        believe(from.is_within(&[(2, -LENS, LENS)]))?;
        let [focal, k1] = from.numbers();
        let correction = LensCorrection { focal, k1 };
        self.corrected(&correction)?;
        if !context.allows_times(T::lit(MAX_IN_USE * ROUNDED), &extrinsics) {
            return Err(RestoreError::Config);
        }
        Ok(CorrectedExtrinsics { extrinsics, correction })
    }

    /// Returns the cameras of the factory calibration with a correction.
    #[inline(never)]
    fn corrected(&self, correction: &LensCorrection<T>) -> Result<Cameras<T>, RestoreError> {
        // A calibrator that only reports lens errors rectifies with the cameras as given, and can use no correction.
        if !correction.is_none() && self.config.lens_tracking == LensTracking::Report {
            return Err(RestoreError::Config);
        }
        self.factory.cameras.corrected(correction).map_err(|_| RestoreError::Absurd)
    }
}

/// Writes the rotation vector of `R` relative to the factory `R`, rad, and `t`.
#[inline(never)]
fn write_about<T: Scalar>(factory: &Extrinsics<T>, of: &Extrinsics<T>, to: &mut Writer<'_>) {
    to.numbers(so3::log(&(of.rotation() * factory.rotation().inverse())).as_slice());
    to.numbers(of.translation().as_slice());
}

/// Reads extrinsics that [`write_about`] has written.
#[inline(never)]
fn read_about<T: Scalar>(
    factory: &Extrinsics<T>,
    from: &mut Reader<'_>,
) -> Result<Extrinsics<T>, RestoreError> {
    believe(from.is_within(&ABOUT))?;
    let [turn, t] = [from.numbers::<T, 3>(), from.numbers()].map(Vector3::from);
    // These numbers were written for the factory extrinsics, which are returned bit for bit.
    let made = factory.translation().map(|x| T::single(x.to_single()));
    if turn == Vector3::zeros() && t == made {
        return Ok(*factory);
    }
    let rotation = so3::left_update(&turn, factory.rotation());
    Extrinsics::try_new(rotation.matrix(), &t).map_err(|_| RestoreError::Absurd)
}
