//! Facade of the crate: it takes correspondences and returns extrinsics.
//!
//! [`Calibrator::take_pair`] updates the estimate and never changes the calibration in use. [`Calibrator::verdict`]
//! compares the two, and [`Calibrator::apply`] puts the estimate into use.

mod calibration;
pub(crate) mod record;
mod step;
mod witness;

pub use calibration::Calibration;

use crate::batch::correspondence::Correspondence;
use crate::batch::{Batch, Pushed};
use crate::config::{Config, Context};
use crate::error::{ApplyError, PushError, Rejection};
use crate::fusion::Fusion;
use crate::geometry::cameras::Cameras;
use crate::geometry::lens_correction::CorrectedExtrinsics;
use crate::outcome::cause::Causes;
use crate::outcome::details::Details;
use crate::outcome::pair_report::Outcome;
use crate::outcome::proposal::Proposal;
use crate::outcome::recent::Recent;
use crate::outcome::relief::Relief;
use crate::outcome::verdict::Verdict;
use crate::record::factory::FactoryCalibration;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{SCREEN_NOISES, SPARE_STEPS};
use step::Step;

/// Online calibrator of one stereo rig, for up to `N` correspondences per pair.
///
/// The same correspondences in the same order give the same result, bit for bit. The calibrator uses no heap, no clock
/// and no I/O. A call takes at most about the time of one pass over the batch; only [`Calibrator::take_pair`] and
/// [`Calibrator::solve_pair`] take all passes of a pair.
///
/// The batch holds the correspondences of one pair, which were pushed since the previous pair ended; from more than `N`
/// it holds a selection. A pair ends with its outcome, fused or not. Its correspondences stay in the batch for
/// [`Calibrator::details`] and [`Calibrator::push_range`], except after [`crate::Fused::LensCorrected`]. The next
/// pushed correspondence begins a new batch.
///
/// [`Calibrator::new`] is `const`. In a firmware, construct the calibrator in its static cell with
/// `StaticCell::init_with(|| Calibrator::new(..))`. That needs 11 kB less flash than a `const` block (256
/// correspondences, `f32`), because the value of a `const` block is stored in flash and copied to the cell.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{
///     Calibrator, Camera, Cameras, Config, Correspondence, FactoryCalibration, Intrinsics, Lens,
/// };
/// # fn main() -> Result<(), Box<dyn core::error::Error>> {
/// let intrinsics = Intrinsics { focal: [1400.0; 2], principal: [959.5, 599.5], size: [1920, 1200] };
/// let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
/// let factory = FactoryCalibration::guess(Cameras { left: camera, right: camera });
/// let mut calibrator = Calibrator::<f32, 256>::new(Config::robust(), &factory);
/// # let matches = (0..200_u16).map(|i| {
/// #     let (u, v, d) = (700.0 + f32::from(i * 37 % 900), f32::from(i * 71 % 1100), 20.0 + f32::from(i * 13 % 97));
/// #     Correspondence { left: [u, v], right: [u - d, v + 1.5], score: 1.0, grid_step: 0.0 }
/// # });
/// let outcome = calibrator.take_pair(matches);
/// outcome.fused?; // refused pairs are normal
/// let pair = outcome.pair.expect("a fused pair has been solved");
/// assert!(pair.rms_px_after < pair.rms_px_before);
/// if let Ok(calibration) = calibrator.apply() {
///     // p_r = R p_l + t, and the cameras: load the rectifier if the generation is new.
///     let _ = (calibration.extrinsics, calibration.cameras, calibration.generation);
/// }
/// # Ok(())
/// # }
/// ```
#[derive(Debug, Clone)]
pub struct Calibrator<T: Scalar, const N: usize> {
    config: Config,
    pub(crate) factory: FactoryCalibration<T>,
    /// Cameras that the rays of the batch belong to.
    pub(crate) corrected: Cameras<T>,
    in_use: CorrectedExtrinsics<T>,
    /// Calibration that the last change replaced, for [`Calibrator::undo`].
    before: Option<CorrectedExtrinsics<T>>,
    pub(crate) generation: u32,
    frozen: bool,
    /// Progress of the pair in the batch.
    step: Step,
    /// Mistakes in rig file or matcher that pairs have shown since the last lock.
    causes: Causes,
    /// Evidence of depth in pairs whose matches all have the same motion between the images.
    relief: Relief<T>,
    /// Numbers of range readings and of motions that contradicted the yaw since the last reset. The record does not
    /// contain them.
    contradicting: [u16; 2],
    /// How the last pairs fitted the calibration in use, and the verdict after the last one.
    recent: Recent<T>,
    verdict: Verdict<T>,
    /// The calibration that [`Calibrator::apply`] puts into use, as the last verdict computed it. `None` once anything
    /// that it depends on has changed.
    next: Option<CorrectedExtrinsics<T>>,
    pub(crate) batch: Batch<T, N>,
    fusion: Fusion<T>,
}

impl<T: Scalar, const N: usize> Calibrator<T, N> {
    /// Returns a calibrator that starts at the factory calibration. The first pairs are solved from it, and the
    /// correction limit is measured from it. Row offsets alone do not determine yaw: the estimate starts at the factory
    /// yaw, weighted by [`FactoryCalibration::yaw_sd_rad`], and follows the turns of the mount.
    ///
    /// Another factory calibration needs a new calibrator: a firmware saves that calibration and restarts.
    // Inlined, so that the value is written in place, without a copy on the stack.
    #[must_use]
    #[inline(always)]
    pub const fn new(config: Config, factory: &FactoryCalibration<T>) -> Self {
        Self {
            config,
            factory: *factory,
            corrected: factory.cameras,
            in_use: CorrectedExtrinsics::as_given(factory.extrinsics),
            before: None,
            generation: 0,
            frozen: false,
            step: Step::Collecting,
            causes: Causes::NONE,
            relief: Relief::NONE,
            contradicting: [0; 2],
            recent: Recent::NONE,
            verdict: Verdict::NONE,
            next: None,
            batch: Batch::new(),
            fusion: Fusion::new(factory.yaw_sd_rad.is_some()),
        }
    }

    /// Puts the factory calibration back into use, and releases a freeze. Forgets the batch, the pair, all fused pairs,
    /// all witness measurements, and the calibration that [`Calibrator::undo`] would put back.
    pub fn reset(&mut self) {
        self.replace_in_use(CorrectedExtrinsics::as_given(self.factory.extrinsics));
        self.corrected = self.factory.cameras;
        self.before = None;
        self.frozen = false;
        self.causes = Causes::NONE;
        self.relief = Relief::NONE;
        self.contradicting = [0; 2];
        self.forget_verdict();
        self.abandon_pair();
        self.batch.forget_cells();
        self.fusion.reset();
    }

    /// Offers one correspondence to the batch. A full batch keeps a selection. The first correspondence after the end
    /// of a pair begins a new batch. Cost: two undistortions, and a search in the list of one image cell.
    ///
    /// # Errors
    /// [`PushError::Busy`]: a pair is being solved; nothing changes. Any other [`PushError`]: the correspondence is not
    /// in the batch, and [`Batch::refused`] counts it.
    pub fn push(&mut self, correspondence: &Correspondence<T>) -> Result<Pushed, PushError> {
        match self.step {
            Step::Collecting => {}
            Step::Ended => self.abandon_pair(),
            Step::Solving | Step::Solved | Step::Judging { .. } => return Err(PushError::Busy),
        }
        self.batch.push(&self.corrected, correspondence)
    }

    /// Takes one stereo pair: pushes its correspondences into a new batch, solves the pair and fuses the result.
    /// [`Batch::refused`] counts the refused correspondences. A pair that was being solved is abandoned.
    pub fn take_pair(
        &mut self,
        correspondences: impl IntoIterator<Item = Correspondence<T>>,
    ) -> Outcome<T> {
        self.discard_pair();
        for correspondence in correspondences {
            let _ = self.batch.push(&self.corrected, &correspondence);
        }
        self.solve_pair()
    }

    /// Solves the batch and fuses the result in one call: calls [`Calibrator::advance_pair`] until the pair has ended.
    pub fn solve_pair(&mut self) -> Outcome<T> {
        // The limit is above the number of steps that a pair takes.
        for _ in 0..self.config.max_passes.saturating_add(SPARE_STEPS) {
            if let Some(outcome) = self.advance_pair() {
                return outcome;
            }
        }
        self.unsolved(Rejection::NotBegun)
    }

    /// Abandons the pair and empties the batch. A pair that has already been fused, or that has failed, cannot be
    /// abandoned: it gets its verdict first.
    pub fn discard_pair(&mut self) {
        if let Step::Judging { solved, fused } = self.step {
            let _ = self.end(solved, fused);
        }
        self.abandon_pair();
    }

    /// Abandons the pair without a verdict, and empties the batch.
    fn abandon_pair(&mut self) {
        self.step = Step::Collecting;
        self.batch.clear();
        self.fusion.discard();
    }

    /// Returns the reliability of the estimate.
    pub fn state(&self) -> State {
        self.fusion.state()
    }

    /// Returns the estimate over all fused pairs. `None` without an estimate, or if the fused pairs give no valid one
    /// ([`ApplyError::NoProposal`], [`ApplyError::Inconsistent`]).
    pub fn proposal(&self) -> Option<Proposal<T>> {
        let context = context(&self.config, &self.factory, &self.fusion);
        self.fusion.proposal(&context, &self.in_use)
    }

    /// Returns the verdict after the last pair: whether the rig may arm, and whether to apply. It stays until the next
    /// pair has ended.
    pub const fn verdict(&self) -> &Verdict<T> {
        &self.verdict
    }

    /// Compares the calibration in use with the estimate over the matches in the batch. These are the matches of the
    /// last pair until the next match is pushed. Takes one pass. `None` without an estimate, or without a match that
    /// fits it.
    pub fn details(&self) -> Option<Details<T>> {
        let cameras = &self.factory.cameras;
        let of_image = [cameras.mean_focal(), cameras.right.corner()];
        // The proposal is borrowed: moving it out of the option would take its stack space twice.
        let proposal = self.proposal();
        let proposal = proposal.as_ref()?;
        let limit = T::single(self.config.fit_limit_px);
        let screen = limit.max(T::lit(SCREEN_NOISES) * self.fusion.noise());
        let rays = self.fusion.reference().correction();
        let (matches, contradicting) = (self.batch.matches(), self.contradicting);
        Details::over(matches, rays, &self.in_use, proposal, contradicting, of_image, screen)
    }

    /// Puts the estimate ([`Proposal::applicable`]) into use, and returns it with the cameras that it belongs to. The
    /// generation changes if the calibration changes.
    ///
    /// # Errors
    /// [`ApplyError`]; nothing changes. [`ApplyError::NoProposal`] and [`ApplyError::NotLocked`] are ordinary until
    /// four pairs agree.
    #[inline(never)]
    pub fn apply(&mut self) -> Result<Calibration<T>, ApplyError> {
        if self.frozen {
            return Err(ApplyError::Frozen);
        }
        let next = match self.next {
            Some(next) => next,
            None => self.applicable()?,
        };
        let generation = self.generation;
        let applied = self.put_into_use(next)?;
        if applied.generation != generation {
            self.recent.change();
        }
        Ok(applied)
    }

    /// Returns the calibration that [`Calibrator::apply`] puts into use.
    ///
    /// # Errors
    /// [`ApplyError`].
    fn applicable(&self) -> Result<CorrectedExtrinsics<T>, ApplyError> {
        if !self.fusion.has_pairs() {
            return Err(ApplyError::NoProposal);
        }
        let proposal = self.proposal();
        applicable_of(proposal.as_ref().ok_or(ApplyError::Inconsistent)?)
    }

    /// Puts the calibration that the last effective [`Calibrator::apply`] replaced back into use, and returns it. A
    /// second call in a row has nothing to undo. The estimate does not change. The verdict forbids arming until pairs
    /// have confirmed this calibration.
    ///
    /// # Errors
    /// [`ApplyError::NothingToUndo`], [`ApplyError::Frozen`]; nothing changes.
    pub fn undo(&mut self) -> Result<Calibration<T>, ApplyError> {
        if self.frozen {
            return Err(ApplyError::Frozen);
        }
        let before = self.before.take().ok_or(ApplyError::NothingToUndo)?;
        self.replace_in_use(before);
        self.recent = Recent::NONE;
        self.verdict.disarm();
        Ok(self.in_use())
    }

    /// Freezes the estimate and the calibration in use, or releases them. While they are frozen, pairs are still
    /// solved, and [`Calibrator::verdict`] still judges them, but they change nothing ([`Rejection::Frozen`]). Witnesses
    /// are refused. [`Calibrator::reset`] and [`Calibrator::restore`] still work, and replace this setting.
    pub fn set_frozen(&mut self, frozen: bool) {
        self.frozen = frozen;
    }

    /// Returns the batch that is being collected or solved, or the batch of the last pair.
    pub fn batch(&self) -> &Batch<T, N> {
        &self.batch
    }

    /// Returns whether a pair is being solved. Correspondences are refused until that pair has ended.
    pub(crate) fn is_solving(&self) -> bool {
        matches!(self.step, Step::Solving | Step::Solved | Step::Judging { .. })
    }
}

/// Returns the context of a call: configuration, rig and vibration. It borrows no fusion, so a caller can change the
/// fusion while it holds the context.
#[inline(never)]
fn context<'a, T: Scalar>(
    config: &'a Config,
    factory: &'a FactoryCalibration<T>,
    fusion: &Fusion<T>,
) -> Context<'a, T> {
    let context = Context::new(config, &factory.extrinsics, factory.cameras.mean_focal());
    context.knowing_yaw(factory.yaw_sd_rad).vibrating(fusion.vibration())
}

/// Returns the calibration of a proposal that may be put into use.
///
/// # Errors
/// [`ApplyError::NotLocked`], [`ApplyError::Doubtful`].
fn applicable_of<T: Scalar>(proposal: &Proposal<T>) -> Result<CorrectedExtrinsics<T>, ApplyError> {
    let Proposal { applicable: extrinsics, applicable_correction: correction, .. } = *proposal;
    match proposal.state {
        State::Locked if proposal.doubts.is_doubtful() => Err(ApplyError::Doubtful),
        State::Locked => Ok(CorrectedExtrinsics { extrinsics, correction }),
        state => Err(ApplyError::NotLocked(state)),
    }
}

/// Returns whether every length is within the capacity of its array. The result is false only if something outside has
/// overwritten the memory of the calibrator. The C library checks this in each call.
#[doc(hidden)]
pub fn has_valid_lengths<T: Scalar, const N: usize>(calibrator: &Calibrator<T, N>) -> bool {
    calibrator.batch.is_within() && calibrator.fusion.is_within()
}
