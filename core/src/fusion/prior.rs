//! An estimate as the prior of a new hypothesis, in the form of a record (`ESTIMATOR.md`, section 21).
//!
//! The moments of a hypothesis are replaced by those of five virtual correspondences, which have its information on the
//! extrinsics and its response to the lens (`Moments::set_prior`). So a restored estimate is fused, fades and is
//! reported like any other.

use super::Fusion;
use super::lens::HypothesisLens;
use super::lens_reference::LensReference;
use super::vibration::KnownVibration;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::prior_moments::Response;
use crate::config::Context;
use crate::depth::mount::MountYaw;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// An estimate without its pairs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prior<T: Scalar> {
    pub(crate) pose: RectifyingRotations<T>,
    /// Equations of the pairs about the pose, and the noise of disparities in them, divided by the widening of the
    /// image halves.
    pub(crate) equations: BiasedEquations<T>,
    pub(crate) response: Response<T>,
    /// Reduced chi-square of the pairs.
    pub(crate) chi_square: T,
    /// Number of pairs in it, at least 1.
    pub(crate) pairs: u32,
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Usual share of inliers, and of a second crowd.
    pub(crate) shares: [T; 2],
    /// Fading sums of matches of high leverage.
    pub(crate) high_leverage: [T; 2],
}

/// The part of the robust method that a record keeps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Learned<T: Scalar> {
    /// The champion; `None` before the first.
    pub(crate) prior: Option<Prior<T>>,
    pub(crate) reference: LensReference<T>,
    pub(crate) vibration: KnownVibration<T>,
    pub(crate) mount: MountYaw<T>,
}

impl<T: Scalar> Learned<T> {
    pub(crate) const NOTHING: Self = Self {
        prior: None,
        reference: LensReference::GIVEN,
        vibration: KnownVibration::NONE,
        mount: MountYaw::UNKNOWN,
    };
}

impl<T: Scalar> Fusion<T> {
    /// Returns the part that a record keeps.
    #[inline(never)]
    pub(crate) fn learned(&self, context: &Context<'_, T>) -> Learned<T> {
        let champion = self.hypotheses.champion();
        Learned {
            prior: champion.and_then(|champion| champion.as_prior(context)),
            reference: champion
                .map_or(self.reference, |c| self.reference.with_knowledge_of(c, context)),
            vibration: self.vibration.known(),
            mount: self.mount,
        }
    }

    /// Takes up the content of a record, without pairs; the estimate is suspect until a pair supports it. False if its
    /// lens has no finite solution: then the state is unspecified.
    #[inline(never)]
    pub(crate) fn resume(&mut self, learned: &Learned<T>, context: &Context<'_, T>) -> bool {
        let Learned { prior, reference, vibration, mount } = learned;
        (self.reference, self.mount) = (*reference, self.mount.resumed(mount));
        self.vibration.resume(vibration);
        if let Some(prior) = prior {
            self.hypotheses.resume(prior, &context.vibrating(self.vibration.variances()));
        }
        self.has_lens(context)
    }

    /// Whether the lens of the estimate has a finite solution.
    #[inline(never)]
    fn has_lens(&self, context: &Context<'_, T>) -> bool {
        let estimate = self.hypotheses.champion().filter(|_| context.has_lens_prior());
        estimate.is_none_or(|champion| {
            let mut lens = HypothesisLens::EXACT;
            lens.estimate(champion, &self.reference, context).is_some()
        })
    }
}
