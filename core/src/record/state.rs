//! State of a calibrator as a record: the calibration in use, and the estimate as the prior of a new hypothesis.

use nalgebra::{Vector3, Vector5};

use super::factory::{FactoryCalibration, fingerprint};
use super::reader::Reader;
use super::writer::{Writer, seal};
use super::{Kind, OVERHEAD_BYTES, believe};
use crate::algebra::block_variances::BlockVariances;
use crate::algebra::disparity_noise::{BaselineNoise, BiasedEquations};
use crate::algebra::information::{Information, StandardDeviations};
use crate::algebra::normal_equations::NormalEquations;
use crate::algebra::prior_moments::{MAX_RESPONSE, Response};
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::correspondence::Cameras;
use crate::calibrator::Calibrator;
use crate::config::{Context, LensTracking};
use crate::depth::mount::MountYaw;
use crate::error::RestoreError;
use crate::fusion::lens_reference::LensReference;
use crate::fusion::prior::{Learned, Prior};
use crate::fusion::vibration::KnownVibration;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::geometry::rectification::RectifyingRotations;
use crate::geometry::so3;
use crate::outcome::relief::Relief;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_NOISE_PX, MAX_REDUCED_CHI_SQUARE, MAX_VIBRATION_RAD};

/// Bytes of fingerprint, generation and pairs.
const WORDS: usize = 3;
/// Numbers: two calibrations of eight, the pose of six, equations, response, the fit of six, lens of six, vibration of
/// four, mount of six.
const NUMBERS: usize = 2 * 8 + PRIOR + 6 + 4 + 6;
const PRIOR: usize = 6 + 15 + 2 + 3 + 30 + 6;
/// Length of a record.
pub(crate) const BYTES: usize = OVERHEAD_BYTES + 4 * (WORDS + NUMBERS);
const _: () = assert!(BYTES <= 400);

/// Flags of the header: an estimate exists; a calibration before the one in use exists; the calibrator is frozen; three
/// flags of the mount; pairs have shown depth.
const ESTIMATE: u8 = 1;
const BEFORE: u8 = 2;
const FROZEN: u8 = 4;
const MOUNT: [u8; 3] = [8, 16, 32];
const RELIEF: u8 = 64;

/// Largest information, 1/rad^2: a million pairs of a thousand matches. No configuration sets this range, nor those
/// below.
const MAX_INFORMATION: f32 = 1e15;
/// Distance of the length of a baseline from 1.
const UNIT: f32 = 1e-5;
/// Rounding of a running mean over its largest term.
const MEAN_ROUNDING: f64 = 1.001;
/// Largest number of matches in the short window: pairs of a million matches.
const MAX_MATCHES: f64 = 1e7;
/// Largest sums of a prior over the weights that they cancel to: rounding in `f32` is then 0.6 % of the weights.
const MAX_CANCELLATION: f64 = 1e5;
/// Information on the lens, dimensionless.
const MAX_LENS_WEIGHT: f32 = 1e10;
/// Largest yaw, rad, and largest of its variances, rad^2.
const MAX_YAW: f32 = 10.0;

/// Content of a record.
struct Found<T: Scalar> {
    in_use: CorrectedExtrinsics<T>,
    before: Option<CorrectedExtrinsics<T>>,
    corrected: Cameras<T>,
    generation: u32,
    is_frozen: bool,
    has_relief: bool,
    learned: Learned<T>,
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Length of a record of [`Calibrator::snapshot`]: 400 bytes.
    pub const SNAPSHOT_BYTES: usize = BYTES;

    /// The calibration in use and the estimate as a record, for storage that survives a loss of power.
    ///
    /// The estimate is a prior: pose and covariance, noise and inliers, vibration, and the knowledge of lens and mount.
    /// The record omits cameras and factory extrinsics ([`crate::FactoryCalibration`]), the batch, a challenger, the
    /// windows of the change detection, and the estimate of the paper preset.
    #[must_use]
    #[inline(never)]
    pub fn snapshot(&self) -> [u8; BYTES] {
        let FactoryCalibration { cameras, extrinsics, .. } = &self.factory;
        let rig = fingerprint(cameras, extrinsics);
        let context = self.estimator.context(&self.config, &self.factory);
        let mut record = [0; BYTES];
        self.write(rig, &self.estimator.learned(&context), &mut record);
        if !is_readable(&record, cameras, &context) {
            // An estimate beyond the ranges, for instance from wrong matches, is not kept.
            self.write(rig, &Learned::NOTHING, &mut record);
        }
        record
    }

    /// Replaces everything learnt by a record: the calibration in use, and the estimate, which is
    /// [`crate::State::Suspect`] until a pair confirms it, because the rig may have changed meanwhile.
    ///
    /// # Errors
    /// [`RestoreError`]; the calibrator is as after [`Calibrator::reset`].
    #[inline(never)]
    pub fn restore(&mut self, record: &[u8]) -> Result<(), RestoreError> {
        let generation = self.generation;
        self.reset();
        let context = self.estimator.context(&self.config, &self.factory);
        let mut found = Found::nothing(&self.factory.cameras, self.in_use);
        found.read(record, &self.factory.cameras, &context)?;
        if !self.estimator.resume(&found.learned, &context) {
            self.estimator.reset();
            return Err(RestoreError::Absurd);
        }
        // A caller that has taken up a calibration meanwhile must notice that of the record.
        let changed = found.in_use != self.in_use && found.generation == generation;
        self.generation = found.generation.wrapping_add(changed.into());
        (self.in_use, self.before) = (found.in_use, found.before);
        (self.frozen, self.corrected) = (found.is_frozen, found.corrected);
        self.relief = Relief::kept(found.has_relief);
        Ok(())
    }

    #[inline(never)]
    fn write(&self, rig: u32, learned: &Learned<T>, record: &mut [u8; BYTES]) {
        let Learned { prior, reference, vibration, mount } = learned;
        let (mount, mount_flags) = mount.parts();
        let flags = [
            (prior.is_some(), ESTIMATE),
            (self.before.is_some(), BEFORE),
            (self.frozen, FROZEN),
            (self.relief.is_shown(), RELIEF),
        ];
        let flags = flags.into_iter().chain(mount_flags.into_iter().zip(MOUNT));
        let flags = flags.fold(0, |all, (is_set, bit)| if is_set { all | bit } else { all });
        let mut to = Writer::begin(record, Kind::State, [flags, reference.changes()]);
        to.word(rig);
        to.word(self.generation);
        to.word(prior.map_or(0, |prior| prior.pairs));
        let before = self.before.unwrap_or(self.in_use);
        for CorrectedExtrinsics { extrinsics, correction } in [&self.in_use, &before] {
            write_about(&self.factory.extrinsics, extrinsics, &mut to);
            to.numbers(&[correction.focal, correction.k1]);
        }
        write_prior(prior.as_ref(), &self.factory.extrinsics, &mut to);
        to.numbers(&reference.numbers());
        let KnownVibration { variances, deviations } = vibration;
        to.numbers(&[variances.rotation, variances.baseline]);
        to.numbers(deviations);
        to.numbers(&mount);
        seal(record);
    }
}

/// Writes pose, information, response and fit; writes zeros if there is no estimate.
#[inline(never)]
fn write_prior<T: Scalar>(prior: Option<&Prior<T>>, factory: &Extrinsics<T>, to: &mut Writer<'_>) {
    let Some(Prior { pose, equations, response, chi_square, noise, shares, high_leverage, .. }) =
        prior
    else {
        to.numbers(&[T::ZERO; PRIOR]);
        return;
    };
    write_about(factory, &pose.extrinsics().unwrap_or(*factory), to);
    let BiasedEquations {
        normal: NormalEquations { information, gradient },
        noise: of_disparities,
    } = equations;
    to.numbers(&information.0.0);
    to.numbers(&[gradient.w, gradient.a]);
    to.numbers(&of_disparities.0);
    response.0.iter().for_each(|column| to.numbers(column));
    to.numbers(&[*chi_square, *noise]);
    to.numbers(shares);
    to.numbers(high_leverage);
}

/// Writes the turn of `R` from the factory extrinsics, rad, and `t`.
fn write_about<T: Scalar>(factory: &Extrinsics<T>, of: &Extrinsics<T>, to: &mut Writer<'_>) {
    let [[a, b, c]] = so3::log(&(of.rotation() * factory.rotation().inverse())).data.0;
    let [[x, y, z]] = of.translation().into_inner().data.0;
    to.numbers(&[a, b, c, x, y, z]);
}

impl<T: Scalar> Found<T> {
    fn nothing(cameras: &Cameras<T>, in_use: CorrectedExtrinsics<T>) -> Self {
        let (corrected, learned) = (*cameras, Learned::NOTHING);
        Self {
            in_use,
            before: None,
            corrected,
            generation: 0,
            is_frozen: false,
            has_relief: false,
            learned,
        }
    }

    /// Reads and checks a record in place: returning its content would take twice the stack.
    #[inline(never)]
    fn read(
        &mut self,
        record: &[u8],
        cameras: &Cameras<T>,
        context: &Context<'_, T>,
    ) -> Result<(), RestoreError> {
        let (mut from, [flags, changes]) = Reader::begin(record, Kind::State, BYTES)?;
        let is_set = |bit: u8| flags & bit != 0;
        self.has_relief = is_set(RELIEF);
        if from.word()? != fingerprint(cameras, context.factory) {
            return Err(RestoreError::OtherRig);
        }
        self.generation = from.word()?;
        let pairs = from.word()?;
        self.is_frozen = is_set(FROZEN);
        self.in_use = read_calibration(cameras, context, &mut from)?;
        let before = read_calibration(cameras, context, &mut from)?;
        self.before = Some(before).filter(|_| is_set(BEFORE));
        let prior = &mut self.learned.prior;
        if is_set(ESTIMATE) {
            read_prior(prior, pairs, context, &mut from)?;
        } else {
            skip_prior(&mut from)?;
        }
        self.read_rest(&mut from, [flags, changes])?;
        self.correct(cameras, context)
    }

    /// Reads the knowledge beside the estimate.
    #[inline(never)]
    fn read_rest(
        &mut self,
        from: &mut Reader<'_>,
        [flags, changes]: [u8; 2],
    ) -> Result<(), RestoreError> {
        let reference = LensReference::of(from.numbers(MAX_LENS_WEIGHT)?, changes);
        self.learned.reference = reference.ok_or(RestoreError::Absurd)?;
        self.learned.vibration = read_vibration(from)?;
        let mount = MountYaw::of(from.numbers(MAX_YAW)?, MOUNT.map(|bit| flags & bit != 0));
        self.learned.mount = mount.ok_or(RestoreError::Absurd)?;
        Ok(())
    }

    /// Sets the cameras of the rays.
    #[inline(never)]
    fn correct(
        &mut self,
        cameras: &Cameras<T>,
        context: &Context<'_, T>,
    ) -> Result<(), RestoreError> {
        let correction = self.learned.reference.correction();
        let before = self.before.as_ref().map(|before| &before.correction);
        let corrections = [Some(correction), Some(&self.in_use.correction), before];
        let is_given = corrections.into_iter().flatten().all(LensCorrection::is_none);
        // A calibrator that only reports the lens rectifies with the cameras as given.
        if !is_given && context.config.lens_tracking == LensTracking::Report {
            return Err(RestoreError::Config);
        }
        self.corrected = cameras.corrected(correction).map_err(|_| RestoreError::Absurd)?;
        Ok(())
    }
}

/// Checks that a written record can be read.
#[inline(never)]
fn is_readable<T: Scalar>(
    record: &[u8; BYTES],
    cameras: &Cameras<T>,
    context: &Context<'_, T>,
) -> bool {
    let mut found = Found::nothing(cameras, CorrectedExtrinsics::as_given(*context.factory));
    found.read(record, cameras, context).is_ok()
}

/// Skips the zeros in place of an absent estimate.
#[inline(never)]
fn skip_prior(from: &mut Reader<'_>) -> Result<(), RestoreError> {
    for _ in 0..PRIOR {
        from.within(0.0_f32, 0.0)?;
    }
    Ok(())
}

/// Reads a calibration that is or was in use.
#[inline(never)]
fn read_calibration<T: Scalar>(
    cameras: &Cameras<T>,
    context: &Context<'_, T>,
    from: &mut Reader<'_>,
) -> Result<CorrectedExtrinsics<T>, RestoreError> {
    let extrinsics = read_about(context.factory, from)?;
    let [focal, k1] = from.numbers(1.0)?;
    let correction = LensCorrection { focal, k1 };
    believe(correction.is_valid() && cameras.corrected(&correction).is_ok())?;
    if !context.allows_in_use(&extrinsics) {
        return Err(RestoreError::Config);
    }
    Ok(CorrectedExtrinsics { extrinsics, correction })
}

#[inline(never)]
fn read_prior<T: Scalar>(
    prior: &mut Option<Prior<T>>,
    pairs: u32,
    context: &Context<'_, T>,
    from: &mut Reader<'_>,
) -> Result<(), RestoreError> {
    let extrinsics = read_about(context.factory, from)?;
    if !context.allows(&extrinsics) {
        return Err(RestoreError::Config);
    }
    let pose = RectifyingRotations::from(&extrinsics);
    let information = Information(Symmetric5(from.numbers(MAX_INFORMATION)?));
    let [forward, down] = from.numbers(MAX_INFORMATION)?;
    let of_disparities = BaselineNoise(from.numbers(MAX_INFORMATION)?);
    // `R` is observed: its gradient balances the prior about the factory extrinsics.
    let mut gradient = pose.unknowns_to(&context.factory_pose) * context.prior;
    (gradient.w, gradient.a) = (forward, down);
    let normal = NormalEquations { information, gradient };
    let equations = BiasedEquations { normal, noise: of_disparities };
    let mut response = Response([[T::ZERO; 5]; 6]);
    for column in &mut response.0 {
        *column = from.numbers(MAX_RESPONSE)?;
    }
    let zero = T::ZERO;
    let window = T::lit(MAX_MATCHES);
    let over = T::lit(MEAN_ROUNDING);
    let chi_square = from.within(zero, over * T::lit(MAX_REDUCED_CHI_SQUARE))?;
    // An update may have changed the floor.
    let floor = T::single(context.config.noise_floor_px);
    let noisiest = floor.max(T::lit(MAX_NOISE_PX)) * T::lit(2.0);
    let noise = from.within(floor.min(T::lit(MAX_NOISE_PX)) * T::HALF, noisiest)?;
    let shares = [from.within(zero, over)?, from.within(-over, over)?];
    let high_leverage = [from.within(zero, window)?, from.within(zero, window)?];
    believe(pairs > 0 && leads_to_covariance(&equations, context.prior))?;
    believe(is_response(&response, &equations.normal.information))?;
    *prior =
        Some(Prior { pose, equations, response, chi_square, pairs, noise, shares, high_leverage });
    Ok(())
}

/// Whether sums `E^T H E` keep the digits of `H`. The covariance of a vibrating rig has less information than the
/// weight of its matches, while the response is as large as before, so no smaller bound holds.
fn is_response<T: Scalar>(Response(columns): &Response<T>, information: &Information<T>) -> bool {
    let [weights, ..] = information.0.diagonal();
    columns.iter().all(|column| {
        let column = Vector5::from(*column);
        column.dot(&information.times(&column)) <= weights * T::lit(MAX_CANCELLATION)
    })
}

/// Whether equations have a covariance, and finite deviations once debiased; and their noise is a part of them.
#[inline(never)]
fn leads_to_covariance<T: Scalar>(equations: &BiasedEquations<T>, prior: T) -> bool {
    let [forward, mixed, down] = equations.noise.0;
    let [_, _, _, all_forward, all_down] = equations.normal.information.0.diagonal();
    let is_part = |noise: T, all: T| noise >= T::ZERO && noise <= all.max(T::ZERO) * T::lit(4.0);
    let is_noise = is_part(forward, all_forward)
        && is_part(down, all_down)
        && mixed * mixed <= forward * down * T::lit(1.01);
    let joint = equations.debiased().with_prior(prior).information.0;
    let is_finite = |covariance| StandardDeviations::of(&covariance).is_finite();
    is_noise
        && equations.normal.with_prior(prior).information.0.inverse().is_some()
        && joint.inverse().is_some_and(is_finite)
}

fn read_vibration<T: Scalar>(from: &mut Reader<'_>) -> Result<KnownVibration<T>, RestoreError> {
    let most = T::lit(MAX_VIBRATION_RAD * MAX_VIBRATION_RAD);
    let mut number = || from.within(T::ZERO, most);
    let variances = BlockVariances { rotation: number()?, baseline: number()? };
    let deviations = [from.within(T::ZERO, T::ONE)?, from.within(T::ZERO, T::ONE)?];
    Ok(KnownVibration { variances, deviations })
}

/// Reads extrinsics that [`write_about`] has written.
fn read_about<T: Scalar>(
    factory: &Extrinsics<T>,
    from: &mut Reader<'_>,
) -> Result<Extrinsics<T>, RestoreError> {
    let turn = from.vector::<T>(core::f32::consts::PI)?;
    let t = from.vector::<T>(1.0 + UNIT)?;
    // Equal to the factory extrinsics, bit for bit.
    let made = factory.translation().map(|x| T::single(x.to_single()));
    if turn == Vector3::zeros() && t == made {
        return Ok(*factory);
    }
    believe((t.norm() - T::ONE).abs() <= T::single(UNIT))?;
    let turn = so3::exp(&turn).ok_or(RestoreError::Absurd)?;
    let rotation = so3::product(turn.matrix(), factory.rotation().matrix());
    Extrinsics::try_new(&rotation, &t).map_err(|_| RestoreError::Absurd)
}
