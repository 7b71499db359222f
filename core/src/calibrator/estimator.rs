//! Dispatch between the robust method ([`Fusion`]) and the published one (`Paper`), by configuration.

use crate::algebra::block_variances::BlockVariances;
use crate::batch::correspondence::RayPair;
use crate::config::{Config, Context, Method};
use crate::depth::mount::{MountYaw, RowsYaw};
use crate::error::Rejection;
use crate::fusion::Fusion;
use crate::fusion::lens_reference::LensReference;
use crate::fusion::prior::{Learned, Place};
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::pair_report::{Fused, PairReport};
use crate::outcome::proposal::Proposal;
#[cfg(feature = "paper")]
use crate::paper::Paper;
use crate::record::factory::FactoryCalibration;
use crate::scalar::Scalar;
use crate::state::State;

/// State of the method that the configuration names.
#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "there is no heap to box it on")]
pub(crate) enum Estimator<T: Scalar> {
    /// Mean directions of Huber estimates.
    #[cfg(feature = "paper")]
    Paper(Paper<T>),
    /// Hypotheses over M-estimates.
    Robust(Fusion<T>),
}

/// Calls the same method of either state.
macro_rules! dispatch {
    ($estimator:expr, $state:ident => $call:expr) => {
        match $estimator {
            #[cfg(feature = "paper")]
            Estimator::Paper($state) => $call,
            Estimator::Robust($state) => $call,
        }
    };
}

impl<T: Scalar> Estimator<T> {
    /// A state without pairs.
    ///
    /// * `is_calibrated`: whether a calibration measured the factory extrinsics.
    #[inline(always)]
    pub(crate) const fn new(config: &Config, is_calibrated: bool) -> Self {
        match config.method {
            #[cfg(feature = "paper")]
            Method::Paper => Self::Paper(Paper::new(config.paper.angle)),
            Method::Robust => Self::Robust(Fusion::new(is_calibrated)),
        }
    }

    /// Context of a call.
    #[inline(never)]
    pub(crate) fn context<'a>(
        &self,
        config: &'a Config,
        factory: &'a FactoryCalibration<T>,
    ) -> Context<'a, T> {
        let focal = factory.cameras.mean_focal();
        let context = Context::new(config, &factory.extrinsics, focal);
        context.knowing_yaw(factory.yaw_sd_rad).vibrating(self.vibration())
    }

    /// Pose of the reported estimate by rows, and its yaw.
    pub(crate) fn rows(
        &self,
        context: &Context<'_, T>,
    ) -> Option<(RectifyingRotations<T>, RowsYaw<T>)> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => None,
            Self::Robust(fusion) => fusion.rows(context),
        }
    }

    /// The mount yaw, for a witness to update.
    #[cfg_attr(
        not(feature = "paper"),
        expect(clippy::unnecessary_wraps, reason = "the paper preset has no mount yaw")
    )]
    pub(crate) fn mount_mut(&mut self) -> Option<&mut MountYaw<T>> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => None,
            Self::Robust(fusion) => Some(fusion.mount_mut()),
        }
    }

    /// Forgets all pairs.
    pub(crate) fn reset(&mut self) {
        dispatch!(self, state => state.reset());
    }

    /// Whether the lengths are within their capacities.
    pub(crate) fn is_within(&self) -> bool {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => true,
            Self::Robust(fusion) => fusion.is_within(),
        }
    }

    /// Discards the pair, whether it is solved or being solved.
    pub(crate) fn discard(&mut self) {
        dispatch!(self, state => state.discard());
    }

    /// Begins a batch, with its first pass.
    ///
    /// # Errors
    /// [`Rejection`]; there is no pair then.
    #[inline(never)]
    pub(crate) fn begin(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        dispatch!(self, state => state.begin(context, matches))
    }

    /// Takes one more pass; true once the pair is solved.
    ///
    /// * `frozen`: whether a pair that fails does not count against the estimate.
    ///
    /// # Errors
    /// [`Rejection`]; the batch is abandoned.
    #[inline(never)]
    pub(crate) fn advance(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
        frozen: bool,
    ) -> Result<bool, Rejection> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(paper) => paper.advance(matches),
            Self::Robust(fusion) => fusion.advance(context, matches, frozen),
        }
    }

    /// Report of the solved pair.
    ///
    /// # Errors
    /// [`Rejection`]; there is no pair to fuse then.
    #[inline(never)]
    #[cfg_attr(not(feature = "paper"), allow(unused_variables, reason = "read by `Paper` only"))]
    pub(crate) fn report(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<PairReport<T>, Rejection> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(paper) => paper.report(matches),
            Self::Robust(fusion) => fusion.report(context),
        }
    }

    /// Fuses the solved pair, once.
    ///
    /// # Errors
    /// [`Rejection`]; the estimate is unchanged.
    #[inline(never)]
    pub(crate) fn fuse(&mut self, context: &Context<'_, T>) -> Result<Fused, Rejection> {
        dispatch!(self, state => state.fuse(context))
    }

    /// Whether the last pair showed the scene of the one before.
    pub(crate) fn is_repeated(&self) -> bool {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => false,
            Self::Robust(fusion) => fusion.is_repeated(),
        }
    }

    /// Correction of the cameras with which the batch is undistorted.
    pub(crate) fn correction(&self) -> LensCorrection<T> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => LensCorrection::NONE,
            Self::Robust(fusion) => *fusion.reference().correction(),
        }
    }

    /// The corrected lens to begin again with, if it makes the estimate more certain ([`crate::LensTracking::Compensate`]).
    #[inline(never)]
    pub(crate) fn next_reference(&self, context: &Context<'_, T>) -> Option<LensReference<T>> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => None,
            Self::Robust(fusion) => fusion.next_reference(context),
        }
    }

    /// Forgets all pairs and begins again with a corrected lens.
    pub(crate) fn begin_again(&mut self, reference: &LensReference<T>) {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => {}
            Self::Robust(fusion) => fusion.begin_again(reference),
        }
    }

    /// Whether a pair supports the estimate.
    pub(crate) fn has_pairs(&self) -> bool {
        dispatch!(self, state => state.has_pairs())
    }

    /// Noise of a coordinate, px; 0 before the first pair and in the paper preset.
    pub(crate) fn noise(&self) -> T {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => T::ZERO,
            Self::Robust(fusion) => fusion.noise(),
        }
    }

    /// Variances of each pair about the estimate, rad^2.
    pub(crate) fn vibration(&self) -> BlockVariances<T> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => BlockVariances::ZERO,
            Self::Robust(fusion) => fusion.vibration(),
        }
    }

    /// State of the estimate.
    pub(crate) fn state(&self) -> State {
        dispatch!(self, state => state.state())
    }

    /// The estimate that a record keeps; `None` without one and in the paper preset.
    pub(crate) fn place(&self, context: &Context<'_, T>) -> Option<Place<T>> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => None,
            Self::Robust(fusion) => fusion.place(context),
        }
    }

    /// Fills in the prior that a record keeps; nothing in the paper preset.
    pub(crate) fn learn(&self, learned: &mut Learned<T>, context: &Context<'_, T>) {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => {}
            Self::Robust(fusion) => fusion.learn(learned, context),
        }
    }

    /// The knowledge of the lens that a record keeps.
    pub(crate) fn learned_lens(&self, context: &Context<'_, T>) -> LensReference<T> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => LensReference::GIVEN,
            Self::Robust(fusion) => fusion.learned_lens(context),
        }
    }

    /// Starts from the prior of a record. `None` if its parts do not fit together.
    pub(crate) fn resume(&mut self, learned: &Learned<T>, context: &Context<'_, T>) -> Option<()> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => Some(()),
            Self::Robust(fusion) => fusion.resume(learned, context),
        }
    }

    /// Whether the lens of the estimate has a finite solution.
    pub(crate) fn has_lens(&self, context: &Context<'_, T>) -> bool {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => true,
            Self::Robust(fusion) => fusion.has_lens(context),
        }
    }

    /// The estimate; `None` before the first pair.
    ///
    /// * `in_use`: source of the baseline where the pairs do not determine it.
    #[inline(never)]
    pub(crate) fn proposal(
        &self,
        context: &Context<'_, T>,
        in_use: &CorrectedExtrinsics<T>,
    ) -> Option<Proposal<T>> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(paper) => paper.proposal(),
            Self::Robust(fusion) => fusion.proposal(context, in_use),
        }
    }
}
