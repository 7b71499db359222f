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
    /// State of the published method.
    #[cfg(feature = "paper")]
    Paper(Paper<T>),
    /// State of the robust method.
    Robust(Fusion<T>),
}

/// Evaluates the same expression on the state of either method.
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
    /// Returns a state without pairs.
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

    /// Returns the context of a call: configuration, rig and vibration.
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

    /// Returns the pose of the reported estimate, as the row offsets show it, and the yaw of this pose. `None` without
    /// an estimate, without a valid covariance, and in the paper preset.
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

    /// Returns the mount yaw, which a witness updates; `None` in the paper preset.
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

    /// Forgets all pairs and witness measurements.
    pub(crate) fn reset(&mut self) {
        dispatch!(self, state => state.reset());
    }

    /// Returns whether the lengths are within their capacities.
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

    /// Ends the solved pair.
    pub(crate) fn close(&mut self) {
        dispatch!(self, state => state.close());
    }

    /// Begins to solve a batch, and takes its first pass.
    ///
    /// # Errors
    /// [`Rejection`]; no pair is being solved then.
    #[inline(never)]
    pub(crate) fn begin(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        dispatch!(self, state => state.begin(context, matches))
    }

    /// Takes one more pass; returns whether the pair is solved.
    ///
    /// * `frozen`: if true, a pair that fails does not count against the estimate.
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

    /// Returns the report of the solved pair.
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

    /// Fuses the solved pair, whose batch is `matches`. A pair is fused at most once.
    ///
    /// # Errors
    /// [`Rejection`]; the extrinsics of a confirmed estimate are unchanged.
    #[inline(never)]
    pub(crate) fn fuse(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<Fused, Rejection> {
        dispatch!(self, state => state.fuse(context, matches))
    }

    /// Returns whether the last pair showed the same scene as the pair fused before it.
    pub(crate) fn is_repeated(&self) -> bool {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => false,
            Self::Robust(fusion) => fusion.is_repeated(),
        }
    }

    /// Returns the correction of the cameras that undistort the batch.
    pub(crate) fn correction(&self) -> LensCorrection<T> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => LensCorrection::NONE,
            Self::Robust(fusion) => *fusion.reference().correction(),
        }
    }

    /// Returns the corrected lens to begin again with, if it makes the estimate more certain
    /// ([`crate::LensTracking::Compensate`]).
    #[inline(never)]
    pub(crate) fn next_reference(&self, context: &Context<'_, T>) -> Option<LensReference<T>> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => None,
            Self::Robust(fusion) => fusion.next_reference(context),
        }
    }

    /// Forgets all pairs and begins again with a corrected lens. Mount yaw and vibration stay known.
    pub(crate) fn begin_again(&mut self, reference: &LensReference<T>, context: &Context<'_, T>) {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => {}
            Self::Robust(fusion) => fusion.begin_again(reference, context),
        }
    }

    /// Returns whether there is an estimate, from fused pairs or from a record.
    pub(crate) fn has_pairs(&self) -> bool {
        dispatch!(self, state => state.has_pairs())
    }

    /// Returns the noise of a coordinate (standard deviation), px; 0 before the first pair and in the paper preset.
    pub(crate) fn noise(&self) -> T {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => T::ZERO,
            Self::Robust(fusion) => fusion.noise(),
        }
    }

    /// Returns the variances of the vibration of single pairs about the estimate, rad^2. They are zero for a rigid rig
    /// and in the paper preset.
    pub(crate) fn vibration(&self) -> BlockVariances<T> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => BlockVariances::ZERO,
            Self::Robust(fusion) => fusion.vibration(),
        }
    }

    /// Returns the state of the estimate.
    pub(crate) fn state(&self) -> State {
        dispatch!(self, state => state.state())
    }

    /// Returns the position of the estimate, which decides whether a record is due. `None` without a confirmed estimate
    /// and in the paper preset.
    pub(crate) fn place(&self, context: &Context<'_, T>) -> Option<Place<T>> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => None,
            Self::Robust(fusion) => fusion.place(context),
        }
    }

    /// Fills the content of a record, apart from the lens; does nothing in the paper preset.
    pub(crate) fn learn(&self, learned: &mut Learned<T>, context: &Context<'_, T>) {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => {}
            Self::Robust(fusion) => fusion.learn(learned, context),
        }
    }

    /// Returns the knowledge of the lens that a record keeps.
    pub(crate) fn learned_lens(&self, context: &Context<'_, T>) -> LensReference<T> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => LensReference::GIVEN,
            Self::Robust(fusion) => fusion.learned_lens(context),
        }
    }

    /// Starts from the content of a record. `None` if its parts do not fit together.
    pub(crate) fn resume(&mut self, learned: &Learned<T>, context: &Context<'_, T>) -> Option<()> {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => Some(()),
            Self::Robust(fusion) => fusion.resume(learned, context),
        }
    }

    /// Returns whether the lens of the estimate has a plausible finite solution; true without a confirmed estimate.
    pub(crate) fn has_lens(&self, context: &Context<'_, T>) -> bool {
        match self {
            #[cfg(feature = "paper")]
            Self::Paper(_) => true,
            Self::Robust(fusion) => fusion.has_lens(context),
        }
    }

    /// Returns the estimate; `None` without one, or if it is not valid.
    ///
    /// * `in_use`: calibration in use, the source of the baseline if the pairs do not determine it.
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
