//! The facade: correspondences in, extrinsics out.
//!
//! Estimating ([`Calibrator::solve_pair`], [`Calibrator::fuse`]) never changes the extrinsics in use,
//! [`Calibrator::health`] compares them with the estimate, and the caller puts the estimate into use
//! ([`Calibrator::apply`]).

mod calibration;
pub(crate) mod estimator;
mod witness;

pub use calibration::Calibration;

use crate::batch::correspondence::{Cameras, Correspondence};
use crate::batch::{Batch, Pushed};
use crate::config::{Config, LensTracking};
use crate::depth::mount::MountYaw;
use crate::error::{ApplyError, PairError, PushError, Refusal, Rejection};
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::CorrectedExtrinsics;
use crate::outcome::cause::{Cause, Causes};
use crate::outcome::health::{Health, LastPair};
use crate::outcome::pair_report::{Fused, PairReport};
use crate::outcome::proposal::Proposal;
use crate::record::factory::FactoryCalibration;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{DIFFERENCE_VARIANCE, SCREEN, SCREEN_NOISES, SPARE_PASSES};
use estimator::Estimator;

/// Online calibrator of one stereo rig, for up to `N` correspondences a pair.
///
/// Same correspondences in the same order give the same bits. No heap, no clock, no I/O. Every call
/// takes at most one pass over the batch, but for [`Calibrator::solve_pair`], which takes all of them.
///
/// [`Calibrator::new`] is `const`. In a firmware, construct it in its static cell with
/// `StaticCell::init_with(|| Calibrator::new(..))`: that needs 11.4 kB less flash than a `const` block, whose value the
/// start-up code copies from flash (256 correspondences, `f32`).
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{
///     Calibrator, Camera, Cameras, Config, Correspondence, Intrinsics, Lens, State,
/// };
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// let mut calibrator = Calibrator::<f32, 256>::new(Config::robust());
/// let intrinsics = Intrinsics { focal: [1400.0; 2], principal: [960.0, 600.0], size: [1920, 1200] };
/// let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
/// calibrator.set_cameras(Cameras { left: camera, right: camera });
/// # let matches = (0..200_u16).map(|i| {
/// #     let (u, v, d) = (700.0 + f32::from(i * 37 % 900), f32::from(i * 71 % 1100), 20.0 + f32::from(i * 13 % 97));
/// #     Correspondence { left: [u, v], right: [u - d, v + 1.5], score: 1.0, grid_step: 0.0 }
/// # });
/// for m in matches {
///     calibrator.push(&m)?;
/// }
/// let pair = calibrator.solve_pair()?;
/// calibrator.fuse()?;
/// calibrator.clear_pair(); // on errors too: the crate documentation has the loop
/// assert!(pair.rms_px_after < pair.rms_px_before);
/// if calibrator.state() == State::Locked {
///     let calibration = calibrator.apply()?; // p_r = R p_l + t, and the cameras
///     let _ = (calibration.extrinsics, calibration.cameras);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Calibrator<T: Scalar, const N: usize> {
    pub(crate) config: Config,
    pub(crate) cameras: Option<Cameras<T>>,
    /// The cameras that the rays of the batch are of.
    pub(crate) corrected: Option<Cameras<T>>,
    pub(crate) factory: Extrinsics<T>,
    pub(crate) in_use: CorrectedExtrinsics<T>,
    pub(crate) before: Option<CorrectedExtrinsics<T>>,
    pub(crate) generation: u32,
    pub(crate) frozen: bool,
    /// Whether the rig turns too fast for the pair of the batch.
    turning: bool,
    rejection: Option<Rejection>,
    /// Mistakes that pairs have shown.
    causes: Causes,
    pub(crate) batch: Batch<T, N>,
    pub(crate) estimator: Estimator<T>,
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// A calibrator without cameras, at `R = I`, `t = (-1, 0, 0)`.
    #[must_use]
    pub const fn new(config: Config) -> Self {
        Self {
            config,
            cameras: None,
            corrected: None,
            factory: Extrinsics::SIDE_BY_SIDE,
            in_use: CorrectedExtrinsics::as_given(Extrinsics::SIDE_BY_SIDE),
            before: None,
            generation: 0,
            frozen: false,
            turning: false,
            rejection: None,
            causes: Causes::NONE,
            batch: Batch::new(),
            estimator: Estimator::new(&config),
        }
    }

    /// Sets both cameras, and resets: [`Calibrator::reset`].
    pub fn set_cameras(&mut self, cameras: Cameras<T>) {
        self.cameras = Some(cameras);
        self.reset();
    }

    /// Sets the factory extrinsics, and resets: [`Calibrator::reset`]. Every pair is solved from them, and the limit of
    /// corrections is measured from them. Their yaw is that of the mount, as far as
    /// [`Config::with_factory_yaw_sd_rad`] says, until the rig changes: rows alone cannot tell it. Extrinsics that are a
    /// guess take [`Config::without_factory_yaw`].
    pub fn set_factory(&mut self, factory: Extrinsics<T>) {
        self.factory = factory;
        if let Some(mount) = self.estimator.mount_mut() {
            *mount = MountYaw::CALIBRATED;
        }
        self.reset();
    }

    /// Sets cameras and extrinsics as they left the factory, and what is known of them in place of the numbers of the
    /// configuration; resets: [`Calibrator::reset`].
    #[inline(never)]
    pub fn install(&mut self, factory: &FactoryCalibration<T>) {
        self.config = factory.configure(self.config).unwrap_or(self.config);
        (self.cameras, self.factory) = (Some(factory.cameras), factory.extrinsics);
        if let Some(mount) = self.estimator.mount_mut() {
            *mount = factory.yaw_sd_rad.map_or(MountYaw::UNKNOWN, |_| MountYaw::CALIBRATED);
        }
        self.reset();
    }

    /// Cameras and extrinsics as they left the factory, and what is known of them; `None` without cameras.
    pub fn factory_calibration(&self) -> Option<FactoryCalibration<T>> {
        let Config { factory_yaw_sd_rad: yaw_sd_rad, baseline_m, .. } = self.config;
        let (cameras, extrinsics) = (self.cameras?, self.factory);
        Some(FactoryCalibration { cameras, extrinsics, yaw_sd_rad, baseline_m })
    }

    /// Back to the factory extrinsics and the given lens models; batch, pair and fused pairs are forgotten. Not
    /// frozen any more.
    pub fn reset(&mut self) {
        self.replace_in_use(CorrectedExtrinsics::as_given(self.factory));
        self.corrected = self.cameras;
        self.before = None;
        self.frozen = false;
        self.rejection = None;
        self.causes = Causes::NONE;
        self.clear_pair();
        self.batch.forget_cells();
        self.estimator.reset();
    }

    /// Offers one correspondence to the batch, which selects once it is full: two undistortions, and
    /// the search for its place in the list of a cell.
    ///
    /// # Errors
    /// [`PushError`]; the batch is unchanged. [`PushError::Busy`] while a pair is being solved.
    pub fn push(&mut self, correspondence: &Correspondence<T>) -> Result<Pushed, PushError> {
        if self.is_solving() {
            return Err(PushError::Busy);
        }
        let cameras = self.corrected.as_ref().ok_or(PushError::NoCameras)?;
        self.batch.push(cameras, correspondence)
    }

    /// Tells how fast the rig turned about any axis while the pair of the batch was taken, rad/s, as a gyroscope
    /// measures it. Holds until [`Calibrator::clear_pair`]; without [`Config::with_max_angular_rate`] nothing comes of
    /// it. A number that is not finite is too fast.
    pub fn set_angular_rate(&mut self, rad_per_s: T) {
        let allowed = |max: f32| rad_per_s.abs() <= T::single(max);
        self.turning = !self.config.max_angular_rate.is_none_or(allowed);
    }

    /// Empties the batch and abandons a pair being solved.
    pub fn clear_pair(&mut self) {
        self.turning = false;
        self.batch.clear();
        self.estimator.abandon();
    }

    /// Begins to solve the batch, with its first pass. Then call [`Calibrator::advance_pair`].
    ///
    /// # Errors
    /// [`PairError::NoCameras`], [`PairError::TooFew`], [`PairError::Turning`]; the estimate and [`Calibrator::state`]
    /// are unchanged. The batch is kept and may be added to. A pair solved before can no longer be fused.
    pub fn begin_pair(&mut self) -> Result<(), PairError> {
        let begun =
            match &self.estimator.context(&self.config, &self.factory, self.cameras.as_ref()) {
                _ if self.turning => {
                    self.estimator.discard();
                    Err(PairError::Turning)
                }
                Some(context) => self.estimator.begin(context, self.batch.matches()),
                None => Err(PairError::NoCameras),
            };
        self.note_unsolved(begun.err());
        begun
    }

    /// Takes one more pass; the report once the pair is solved. The batch may then be changed.
    ///
    /// # Errors
    /// [`PairError::NotBegun`] where no pair is being solved: nothing changes. Otherwise the pair is abandoned, the
    /// batch is kept, and solving it again fails again: [`Calibrator::clear_pair`].
    ///
    /// What is in use never changes, nor do the numbers of a confirmed estimate. In the robust preset the failure
    /// counts against each hypothesis that was asked and disagreed:
    /// - a locked estimate becomes [`State::Suspect`], after ten such pairs in a row [`State::Lost`]; the next pair
    ///   that agrees with it locks it again;
    /// - a challenger, or an estimate that is still [`State::Acquiring`], is dropped once at least two pairs, and more
    ///   than half as many as support it, disagree: [`Calibrator::proposal`] is then `None` until a pair is fused.
    pub fn advance_pair(&mut self) -> Result<Option<PairReport<T>>, PairError> {
        if self.take_pass()? { self.report().map(Some) } else { Ok(None) }
    }

    /// Solves the batch in one call. The batch is kept, for [`Calibrator::health`]; call [`Calibrator::clear_pair`]
    /// before the next pair, after an error too.
    ///
    /// # Errors
    /// [`PairError::NoCameras`], [`PairError::TooFew`], [`PairError::Turning`]: as [`Calibrator::begin_pair`], nothing
    /// counts against the estimate. [`PairError::NoConsensus`], [`PairError::Behind`], [`PairError::Unobservable`]: as
    /// [`Calibrator::advance_pair`], the pair may count against the estimate, and [`Calibrator::state`] may change.
    pub fn solve_pair(&mut self) -> Result<PairReport<T>, PairError> {
        self.begin_pair()?;
        // More passes than any preset takes.
        for _ in 0..self.config.max_passes.saturating_add(SPARE_PASSES) {
            if self.take_pass()? {
                return self.report();
            }
        }
        Err(PairError::NotBegun)
    }

    /// Takes one more pass; whether the pair is solved.
    // Out of line: its context leaves the stack of the caller.
    #[inline(never)]
    fn take_pass(&mut self) -> Result<bool, PairError> {
        let solved =
            match &self.estimator.context(&self.config, &self.factory, self.cameras.as_ref()) {
                Some(context) => self.estimator.advance(context, self.batch.matches()),
                None => Err(PairError::NoCameras),
            };
        self.note_unsolved(solved.err());
        solved
    }

    /// Notes why the pair could not be solved, and the cause that this shows.
    fn note_unsolved(&mut self, why: Option<PairError>) {
        self.rejection = why.map(Rejection::Unsolved);
        let size = self.cameras.as_ref().map_or([1; 2], |cameras| cameras.left.intrinsics().size);
        if let Some(cause) = why.and_then(|why| self.batch.cause_of(why, size)) {
            self.causes.add(cause);
        }
    }

    /// Report of the solved pair.
    // Out of line: its context leaves the stack of the caller.
    #[inline(never)]
    fn report(&mut self) -> Result<PairReport<T>, PairError> {
        let report =
            match &self.estimator.context(&self.config, &self.factory, self.cameras.as_ref()) {
                Some(context) => self.estimator.report(context, self.batch.matches()),
                None => Err(PairError::NoCameras),
            };
        self.note_unsolved(report.as_ref().err().copied());
        report
    }

    /// Fuses the pair that was solved last, once. The batch may be cleared before. What is in use does not change,
    /// unless the configuration says so ([`Config::with_automatic_apply`]).
    ///
    /// # Errors
    /// [`Refusal`], which [`Calibrator::health`] shows until the next pair; what is in use and the numbers of a
    /// confirmed estimate are bit-identical to those before. After [`Refusal::Disagrees`] its deviations may be wider:
    /// the pair may show a vibration.
    /// - [`Refusal::NothingSolved`]: the estimate is unchanged.
    /// - [`Refusal::Frozen`]: the estimate is unchanged; the pair can be fused once the calibrator is not frozen.
    /// - [`Refusal::TooUncertain`] (paper preset): nothing counts against the estimate.
    /// - [`Refusal::Disagrees`], [`Refusal::CorrectionLimit`], [`Refusal::NoRig`]: in the robust preset the pair counts
    ///   against the hypotheses that it disagrees with, and against the one that cannot take it in, as a failed solve
    ///   does ([`Calibrator::advance_pair`]); [`Calibrator::state`] may change.
    pub fn fuse(&mut self) -> Result<Fused, Refusal> {
        let fused =
            match &self.estimator.context(&self.config, &self.factory, self.cameras.as_ref()) {
                _ if self.frozen => Err(Refusal::Frozen),
                Some(context) => self.estimator.fuse(context),
                None => Err(Refusal::NothingSolved),
            };
        self.rejection = fused.err().map(Rejection::Refused);
        match self.batch.cause().filter(|_| fused.is_ok()) {
            Some(cause) => self.causes.add(cause),
            None if self.state() == State::Locked => self.causes = Causes::NONE,
            None => {}
        }
        if self.config.applies_itself && fused.is_ok() {
            self.try_apply();
        }
        let corrects = fused.is_ok() && self.config.lens_tracking == LensTracking::Compensate;
        if corrects && self.correct_lens() { Ok(Fused::LensCorrected) } else { fused }
    }

    /// Applies where that is allowed; the proposal says why not. Out of line: the result stays off the caller's stack.
    #[inline(never)]
    fn try_apply(&mut self) {
        let _ = self.apply();
    }

    /// The likeliest mistake in rig file or matcher, once four pairs have shown one since the estimate was last locked; of
    /// an estimate that there is, that of its health ([`Health::cause`]) with the matches at hand. At most one pass.
    ///
    /// `None` as long as nothing is wrong, or too little is known.
    pub fn likely_cause(&self) -> Option<Cause> {
        self.causes.likeliest().or_else(|| self.health()?.cause)
    }

    /// How far the estimate can be relied on.
    pub fn state(&self) -> State {
        self.estimator.state()
    }

    /// The estimate over all fused pairs; `None` before the first.
    pub fn proposal(&self) -> Option<Proposal<T>> {
        let context = self.estimator.context(&self.config, &self.factory, self.cameras.as_ref())?;
        self.estimator.proposal(&context, &self.in_use)
    }

    /// Fit of the extrinsics in use and of the estimate to the batch, and the reliability of the estimate. One pass.
    ///
    /// `None` without cameras, fused pairs, or matches that fit the estimate.
    // Out of line: inlined into the endless loop of a firmware it took 3.7 kB more at opt-level 3.
    #[inline(never)]
    pub fn health(&self) -> Option<Health<T>> {
        let cameras = self.cameras.as_ref()?;
        let of_image = [cameras.mean_focal(), cameras.right.corner()];
        // By reference: moved out of the option it would take its stack twice.
        let proposal = self.proposal();
        let proposal = proposal.as_ref()?;
        let screen = T::single(self.config.huber_threshold_px) * T::lit(SCREEN);
        let noise = self.estimator.noise();
        let screen = screen.max(T::lit(SCREEN_NOISES) * noise);
        let rows = noise * T::lit(DIFFERENCE_VARIANCE).sqrt();
        let rays = self.estimator.correction();
        let last = LastPair {
            rejection: self.rejection,
            repeated: self.estimator.is_repeated(),
            cause: self.batch.cause().or_else(|| {
                proposal.cause(&self.config.lens_prior, rows, self.batch.is_moved_alike())
            }),
        };
        Health::over(&self.batch, &rays, &self.in_use, proposal, last, of_image, screen)
    }

    /// Puts the estimate into use and returns it, with the cameras that it belongs to: [`Proposal::applicable`]. The
    /// generation changes if the calibration does.
    ///
    /// # Errors
    /// [`ApplyError`]; nothing changes. [`ApplyError::NoProposal`] and [`ApplyError::NotLocked`] are ordinary until
    /// four pairs agree.
    #[inline(never)]
    pub fn apply(&mut self) -> Result<Calibration<T>, ApplyError> {
        if self.frozen {
            return Err(ApplyError::Frozen);
        }
        if !self.estimator.has_pairs() {
            return Err(ApplyError::NoProposal);
        }
        let proposal = self.proposal();
        let proposal = proposal.as_ref().ok_or(ApplyError::Inconsistent)?;
        if proposal.state != State::Locked {
            return Err(ApplyError::NotLocked(proposal.state));
        }
        if proposal.is_doubtful() {
            return Err(ApplyError::Doubtful);
        }
        let Proposal { applicable: extrinsics, applicable_correction: correction, .. } = *proposal;
        self.put_into_use(CorrectedExtrinsics { extrinsics, correction })
    }

    /// Puts back what was in use before the last change, once; the estimate stays.
    ///
    /// # Errors
    /// [`ApplyError::NothingToUndo`], [`ApplyError::Frozen`]; what is in use stays.
    pub fn undo(&mut self) -> Result<Calibration<T>, ApplyError> {
        if self.frozen {
            return Err(ApplyError::Frozen);
        }
        let before = self.before.ok_or(ApplyError::NothingToUndo)?;
        let calibration = self.calibration(&before).ok_or(ApplyError::NothingToUndo)?;
        self.before = None;
        self.replace_in_use(before);
        Ok(calibration)
    }

    /// Freezes both the estimate and what is in use, or releases them. Pairs may still be solved and
    /// [`Calibrator::health`] read; a solve that fails still counts against the estimate.
    pub fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    /// Whether the calibrator is frozen.
    pub fn is_frozen(&self) -> bool {
        self.frozen
    }

    /// The parameters.
    pub fn config(&self) -> &Config {
        &self.config
    }

    /// The factory extrinsics: `p_r = R p_l + t`.
    pub fn factory(&self) -> &Extrinsics<T> {
        &self.factory
    }

    /// The extrinsics in use: `p_r = R p_l + t`. They belong to the cameras of [`Calibrator::calibration_in_use`].
    pub fn in_use(&self) -> &Extrinsics<T> {
        &self.in_use.extrinsics
    }

    /// Changes exactly when the extrinsics in use, or the correction of the cameras that they belong to, do; wraps
    /// around.
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// The batch that is being collected or was solved last.
    pub fn batch(&self) -> &Batch<T, N> {
        &self.batch
    }

    /// Whether every length that an access depends on is within its capacity. It always is, unless the memory of the
    /// calibrator has been overwritten from outside.
    #[doc(hidden)]
    pub fn has_valid_lengths(&self) -> bool {
        self.batch.is_within() && self.estimator.is_within()
    }

    /// Whether a pair has been begun and is not solved: until then correspondences are refused.
    pub fn is_solving(&self) -> bool {
        self.estimator.is_busy()
    }

    /// The cameras as given, once set.
    pub fn cameras(&self) -> Option<&Cameras<T>> {
        self.cameras.as_ref()
    }
}
