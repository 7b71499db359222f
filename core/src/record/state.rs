//! State of a calibrator as a record: the calibration in use, and the estimate as the prior of a new hypothesis.

use core::f32::consts::PI;

use nalgebra::Vector3;

use super::codec::{Range, Reader, Writer, bytes_of, seal};
use super::factory::{FactoryCalibration, fingerprint};
use super::{OVERHEAD_BYTES, STATE, believe};
use crate::algebra::prior_moments::MAX_RESPONSE;
use crate::batch::correspondence::Cameras;
use crate::calibrator::Calibrator;
use crate::config::{Context, LensTracking};
use crate::error::RestoreError;
use crate::fusion::prior::Learned;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3;
use crate::outcome::relief::Relief;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_LENS_CORRECTION, MAX_REDUCED_CHI_SQUARE, MAX_VIBRATION_RAD};

/// Largest information, 1/rad^2: a million pairs of a thousand matches. No configuration sets this range, nor those
/// below.
const MAX_INFORMATION: f32 = 1e15;
/// Largest component of a unit vector, by rounding.
const UNIT: f32 = 1.0 + 1e-5;
/// Rounding of a running mean over its largest term.
const MEAN_ROUNDING: f32 = 1.001;
/// Largest noise of a coordinate, px.
const MAX_NOISE: f32 = 1e6;
/// Largest number of matches in the short window: pairs of a million matches.
const MAX_MATCHES: f32 = 1e7;
/// Information on the lens, dimensionless.
const MAX_LENS_WEIGHT: f32 = 1e10;
/// Largest yaw, rad, and largest of its variances, rad^2.
const MAX_YAW: f32 = 10.0;

/// A threshold in the type of a record.
const fn single(threshold: f64) -> f32 {
    #[expect(clippy::as_conversions, clippy::cast_possible_truncation, reason = "const")]
    {
        threshold as f32
    }
}

const LENS: f32 = single(MAX_LENS_CORRECTION);
const CHI_SQUARE: f32 = single(MAX_REDUCED_CHI_SQUARE) * MEAN_ROUNDING;
const VIBRATION: f32 = single(MAX_VIBRATION_RAD * MAX_VIBRATION_RAD);

/// Numbers of a record, in order: two calibrations, the pose, then [`Learned::numbers`].
const RANGES: [Range; 23] = [
    (3, -PI, PI),
    (3, -UNIT, UNIT),
    (2, -LENS, LENS),
    (3, -PI, PI),
    (3, -UNIT, UNIT),
    (2, -LENS, LENS),
    (3, -PI, PI),
    (3, -UNIT, UNIT),
    (15 + 2 + 3, -MAX_INFORMATION, MAX_INFORMATION),
    (30, -MAX_RESPONSE, MAX_RESPONSE),
    (1, 0.0, CHI_SQUARE),
    (1, 0.0, MAX_NOISE),
    (1, 0.0, MEAN_ROUNDING),
    (1, -MEAN_ROUNDING, MEAN_ROUNDING),
    (2, 0.0, MAX_MATCHES),
    (4, -LENS, LENS),
    (2, 0.0, MAX_LENS_WEIGHT),
    (2, 0.0, VIBRATION),
    (2, 0.0, 1.0),
    (1, 0.0, 1.0),
    (2, -MAX_YAW, MAX_YAW),
    (2, 0.0, MAX_YAW),
    (1, -MAX_YAW, MAX_YAW),
];

/// Bytes of fingerprint, generation and pairs.
const WORDS_BYTES: usize = 3 * 4;
/// Length of a record.
pub(crate) const BYTES: usize = OVERHEAD_BYTES + WORDS_BYTES + bytes_of(&RANGES);
const _: () = assert!(BYTES <= 400);

/// Flags of the header: a calibration before the one in use exists; the calibrator is frozen; three flags of the mount;
/// pairs have shown depth.
const BEFORE: u8 = 1;
const FROZEN: u8 = 2;
const MOUNT: [u8; 3] = [4, 8, 16];
const RELIEF: u8 = 32;

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Length of a record of [`Calibrator::snapshot`]: 400 bytes.
    pub const SNAPSHOT_BYTES: usize = BYTES;

    /// The calibration in use and the estimate as a record, for storage that survives a loss of power.
    ///
    /// The estimate is a prior: pose and covariance, noise and inliers, vibration, and the knowledge of lens and mount.
    /// The record omits cameras and factory extrinsics ([`crate::FactoryCalibration`]), the batch, a challenger, the
    /// windows of the change detection, and the estimate of the paper preset.
    #[must_use]
    pub fn snapshot(&self) -> [u8; BYTES] {
        let mut record = [0; BYTES];
        let mut learned = Learned::nothing();
        self.learn(&mut learned);
        self.write_snapshot(&mut learned, &mut record);
        record
    }

    /// Fills in the estimate as a prior.
    // Apart from writing it: the place of the record need not be on the stack yet.
    #[inline(never)]
    pub(crate) fn learn(&self, learned: &mut Learned<T>) {
        let context = self.estimator.context(&self.config, &self.factory);
        self.estimator.learn(learned, &context);
    }

    /// Writes the record of [`Calibrator::snapshot`].
    #[inline(never)]
    pub(crate) fn write_snapshot(&self, learned: &mut Learned<T>, record: &mut [u8]) {
        self.write(learned, record);
        let is_within = Reader::begin(record, STATE, BYTES).is_ok_and(|(mut read, _)| {
            let _ = [(); 3].map(|()| read.word());
            read.is_within(&RANGES)
        });
        if !is_within {
            // An estimate beyond the ranges, for instance from wrong matches, is not kept.
            *learned = Learned::nothing();
            self.write(learned, record);
        }
    }

    /// Replaces everything learnt by a record: the calibration in use, and the estimate, which is
    /// [`crate::State::Suspect`] until a pair confirms it, because the rig may have changed meanwhile.
    ///
    /// # Errors
    /// [`RestoreError`]; the calibrator is as after [`Calibrator::reset`].
    pub fn restore(&mut self, record: &[u8]) -> Result<(), RestoreError> {
        let fresh = self.read(record)?;
        self.check_restored(fresh)
    }

    /// Restores a record, apart from the check that follows. Returns the generation after a reset.
    ///
    /// # Errors
    /// As [`Calibrator::restore`].
    // Two calls: the content of the record leaves the stack before the check.
    #[inline(never)]
    pub(crate) fn read(&mut self, record: &[u8]) -> Result<u32, RestoreError> {
        let generation = self.generation;
        self.reset();
        let fresh = self.generation;
        let read = self.read_onto_reset(record, generation);
        if read.is_err() {
            self.reset();
        }
        read.map(|()| fresh)
    }

    /// Checks what was restored.
    ///
    /// * `fresh`: the generation after a reset.
    ///
    /// # Errors
    /// As [`Calibrator::restore`].
    #[inline(never)]
    pub(crate) fn check_restored(&mut self, fresh: u32) -> Result<(), RestoreError> {
        let context = self.estimator.context(&self.config, &self.factory);
        if self.estimator.has_lens(&context) {
            return Ok(());
        }
        self.reset();
        self.generation = fresh;
        Err(RestoreError::Absurd)
    }

    /// * `generation`: that before the reset.
    #[inline(never)]
    fn read_onto_reset(&mut self, record: &[u8], generation: u32) -> Result<(), RestoreError> {
        let context = self.estimator.context(&self.config, &self.factory);
        let (mut from, [flags, changes]) = Reader::begin(record, STATE, BYTES)?;
        let is_set = |bit: u8| flags & bit != 0;
        let [rig, restored, pairs] = [(); 3].map(|()| from.word());
        if rig != fingerprint(&self.factory.cameras, context.factory) {
            return Err(RestoreError::OtherRig);
        }
        believe(from.is_within(&RANGES))?;
        let in_use = self.read_calibration(&context, &mut from)?;
        let before = self.read_calibration(&context, &mut from)?;
        self.before = is_set(BEFORE).then_some(before);
        let mut learned = Learned::nothing();
        let extrinsics = read_about(context.factory, &mut from)?;
        if !context.allows(&extrinsics) {
            return Err(RestoreError::Config);
        }
        learned.prior.pose = RectifyingRotations::from(&extrinsics);
        learned.numbers().into_iter().for_each(|numbers| from.fill(numbers));
        (learned.prior.pairs, learned.changes) = (pairs, changes);
        learned.mount_flags = MOUNT.map(is_set);
        believe(self.estimator.resume(&learned, &context).is_some())?;
        self.correct(&learned.correction())?;
        // A caller that has taken up a calibration meanwhile must notice that of the record.
        let changed = self.replace_in_use(in_use) && restored == generation;
        self.generation = restored.wrapping_add(changed.into());
        self.frozen = is_set(FROZEN);
        self.relief = Relief::kept(is_set(RELIEF));
        Ok(())
    }

    /// Reads a calibration that is or was in use.
    #[inline(never)]
    fn read_calibration(
        &self,
        context: &Context<'_, T>,
        from: &mut Reader<'_>,
    ) -> Result<CorrectedExtrinsics<T>, RestoreError> {
        let extrinsics = read_about(context.factory, from)?;
        let [focal, k1] = from.numbers();
        let correction = LensCorrection { focal, k1 };
        self.corrected(&correction)?;
        if !context.allows_in_use(&extrinsics) {
            return Err(RestoreError::Config);
        }
        Ok(CorrectedExtrinsics { extrinsics, correction })
    }

    /// The cameras with a correction.
    #[inline(never)]
    fn corrected(&self, correction: &LensCorrection<T>) -> Result<Cameras<T>, RestoreError> {
        // A calibrator that only reports the lens rectifies with the cameras as given.
        if !correction.is_none() && self.config.lens_tracking == LensTracking::Report {
            return Err(RestoreError::Config);
        }
        self.factory.cameras.corrected(correction).map_err(|_| RestoreError::Absurd)
    }

    /// Sets the cameras of the rays.
    #[inline(never)]
    fn correct(&mut self, correction: &LensCorrection<T>) -> Result<(), RestoreError> {
        self.corrected = self.corrected(correction)?;
        Ok(())
    }

    #[inline(never)]
    fn write(&self, learned: &mut Learned<T>, record: &mut [u8]) {
        let flags = [
            (self.before.is_some(), BEFORE),
            (self.frozen, FROZEN),
            (self.relief.is_shown(), RELIEF),
        ];
        let flags = flags.into_iter().chain(learned.mount_flags.into_iter().zip(MOUNT));
        let flags = flags.fold(0, |all, (is_set, bit)| if is_set { all | bit } else { all });
        let FactoryCalibration { cameras, extrinsics, .. } = &self.factory;
        let mut to = Writer::begin(record, STATE, [flags, learned.changes]);
        for word in [fingerprint(cameras, extrinsics), self.generation, learned.prior.pairs] {
            to.word(word);
        }
        for of in [&self.in_use, self.before.as_ref().unwrap_or(&self.in_use)] {
            write_about(extrinsics, &of.extrinsics, &mut to);
            to.numbers(&[of.correction.focal, of.correction.k1]);
        }
        // Without an estimate there is no pose.
        write_about(extrinsics, &learned.prior.pose.extrinsics().unwrap_or(*extrinsics), &mut to);
        learned.numbers().into_iter().for_each(|numbers| to.numbers(numbers));
        seal(record);
    }
}

/// Writes the turn of `R` from the factory extrinsics, rad, and `t`.
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
    let [turn, t] = [from.numbers::<T, 3>(), from.numbers()].map(Vector3::from);
    // Equal to the factory extrinsics, bit for bit.
    let made = factory.translation().map(|x| T::single(x.to_single()));
    if turn == Vector3::zeros() && t == made {
        return Ok(*factory);
    }
    let rotation = so3::left_update(&turn, factory.rotation());
    Extrinsics::try_new(rotation.matrix(), &t).map_err(|_| RestoreError::Absurd)
}
