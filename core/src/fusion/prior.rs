//! An estimate as the prior of a new hypothesis, in the form of a record (`ESTIMATOR.md`, section 21).
//!
//! The moments of a hypothesis are replaced by those of five virtual correspondences, which have its information on the
//! extrinsics and its response to the lens (`Moments::set_prior`). So a restored estimate is fused, fades and is
//! reported like any other.

use core::slice::from_mut;

use super::Fusion;
use super::lens::HypothesisLens;
use super::lens_reference::LensReference;
use super::vibration::KnownVibration;
use crate::algebra::block_variances::BlockVariances;
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::information::StandardDeviations;
use crate::algebra::normal_equations::NormalEquations;
use crate::algebra::prior_moments::Response;
use crate::config::Context;
use crate::geometry::lens_correction::LensCorrection;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::FREEDOM_RAD;

/// An estimate without its pairs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prior<T: Scalar> {
    pub(crate) pose: RectifyingRotations<T>,
    /// Equations of the pairs about the pose, and the noise of disparities in them, divided by the widening of the
    /// image halves. A record keeps the baseline's part of the gradient alone.
    pub(crate) equations: BiasedEquations<T>,
    pub(crate) response: Response<T>,
    /// Reduced chi-square of the pairs.
    pub(crate) chi_square: T,
    /// Number of pairs in it; 0: there is no estimate.
    pub(crate) pairs: u32,
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Usual share of inliers, and of a second crowd.
    pub(crate) shares: [T; 2],
    /// Fading sums of matches of high leverage.
    pub(crate) high_leverage: [T; 2],
}

impl<T: Scalar> Prior<T> {
    /// No estimate.
    pub(crate) const NONE: Self = Self {
        pose: RectifyingRotations::UNSET,
        equations: BiasedEquations::ZERO,
        response: Response::ZERO,
        chi_square: T::ZERO,
        pairs: 0,
        noise: T::ZERO,
        shares: [T::ZERO; 2],
        high_leverage: [T::ZERO; 2],
    };

    /// Whether the noise is a part of the equations, and the response keeps their digits.
    #[inline(never)]
    fn is_consistent(&self) -> bool {
        let Self { equations: BiasedEquations { normal, noise }, response, .. } = self;
        let [forward, mixed, down] = noise.0;
        let [_, _, _, all_forward, all_down] = normal.information.0.diagonal();
        let is_part =
            |noise: T, all: T| noise >= T::ZERO && noise <= all.max(T::ZERO) * T::lit(4.0);
        is_part(forward, all_forward)
            && is_part(down, all_down)
            && mixed * mixed <= forward * down * T::lit(1.01)
            && response.keeps_digits_of(&normal.information)
    }
}

/// The part of the robust method that a record keeps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Learned<T: Scalar> {
    /// The champion.
    pub(crate) prior: Prior<T>,
    /// [`LensReference::numbers`], and changes of the lens.
    lens: [T; 6],
    pub(crate) changes: u8,
    vibration: KnownVibration<T>,
    /// [`crate::depth::mount::MountYaw::parts`].
    mount: [T; 6],
    pub(crate) mount_flags: [bool; 3],
}

impl<T: Scalar> Learned<T> {
    /// Nothing: the mount yaw rests on the factory calibration.
    // No constant: it would take its size in flash.
    pub(crate) fn nothing() -> Self {
        Self::of_lens(&LensReference::GIVEN)
    }

    /// Nothing but the knowledge of the lens.
    pub(crate) fn of_lens(lens: &LensReference<T>) -> Self {
        let zero = T::ZERO;
        Self {
            prior: Prior::NONE,
            lens: lens.numbers(),
            changes: lens.changes(),
            vibration: KnownVibration::NONE,
            mount: [T::ONE, zero, zero, zero, zero, zero],
            mount_flags: [false; 3],
        }
    }

    /// Its numbers in the order of a record, apart from the pose.
    pub(crate) fn numbers(&mut self) -> [&mut [T]; 13] {
        let Self { prior, lens, vibration, mount, .. } = self;
        let Prior { equations, response, chi_square, noise, shares, high_leverage, .. } = prior;
        let BiasedEquations { normal, noise: of_disparities } = equations;
        let NormalEquations { information, gradient } = normal;
        let [[_, _, _, of_baseline @ ..]] = &mut gradient.data.0;
        let KnownVibration { variances: BlockVariances { rotation, baseline }, deviations } =
            vibration;
        [
            &mut information.0.0,
            of_baseline,
            &mut of_disparities.0,
            response.0.as_flattened_mut(),
            from_mut(chi_square),
            from_mut(noise),
            shares,
            high_leverage,
            lens,
            from_mut(rotation),
            from_mut(baseline),
            deviations,
            mount,
        ]
    }

    /// Correction of the rays.
    pub(crate) fn correction(&self) -> LensCorrection<T> {
        let [focal, k1, ..] = self.lens;
        LensCorrection { focal, k1 }
    }
}

/// The estimate that a record keeps, as far as a later one differs from it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place<T: Scalar> {
    pose: RectifyingRotations<T>,
    sd: StandardDeviations<T>,
    /// Yaw of the mount that witnesses have measured, rad.
    yaw: T,
    pub(crate) pairs: u32,
}

impl<T: Scalar> Place<T> {
    /// Whether `R`, `t` or the yaw has moved by more than the freedom of a pair about an estimate, and `R` and `t` by more
    /// than their deviations: a far scene moves `t` by chance.
    pub(crate) fn has_moved_from(&self, old: &Self) -> bool {
        let freedom = T::lit(FREEDOM_RAD);
        let [[x, y, z, b_y, b_z]] = old.pose.unknowns_to(&self.pose).data.0;
        let beyond = |square: T, sd: T| square.sqrt() > sd.max(freedom);
        beyond(x * x + y * y + z * z, self.sd.rotation)
            || beyond(b_y * b_y + b_z * b_z, self.sd.translation)
            || (self.yaw - old.yaw).abs() > freedom
    }
}

impl<T: Scalar> Fusion<T> {
    /// The champion's; `None` without one.
    #[inline(never)]
    pub(crate) fn place(&self, context: &Context<'_, T>) -> Option<Place<T>> {
        let champion = self.hypotheses.champion()?;
        Some(Place {
            pose: *champion.pose(),
            sd: champion.deviations(context)?,
            yaw: self.mount.known_yaw(),
            pairs: champion.pairs(),
        })
    }

    /// The knowledge of the lens that a record keeps.
    #[inline(never)]
    pub(crate) fn learned_lens(&self, context: &Context<'_, T>) -> LensReference<T> {
        let champion = self.hypotheses.champion();
        champion
            .map_or(self.reference, |champion| self.reference.with_knowledge_of(champion, context))
    }

    /// Fills in the part that a record keeps, apart from the lens.
    #[inline(never)]
    pub(crate) fn learn(&self, learned: &mut Learned<T>, context: &Context<'_, T>) {
        if let Some(champion) = self.hypotheses.champion() {
            let prior = &mut learned.prior;
            if champion.fill_prior(prior, context).is_none() || !prior.is_consistent() {
                learned.prior = Prior::NONE;
            }
        }
        learned.vibration = self.vibration.known();
        (learned.mount, learned.mount_flags) = self.mount.parts();
    }

    /// Takes up the content of a record, without pairs; the estimate is suspect until a pair supports it. `None` if its
    /// parts do not fit together: then the state is unspecified.
    #[inline(never)]
    pub(crate) fn resume(&mut self, learned: &Learned<T>, context: &Context<'_, T>) -> Option<()> {
        let Learned { prior, lens, changes, vibration, mount, mount_flags } = learned;
        self.reference = LensReference::of(*lens, *changes)?;
        self.mount.resume(*mount, *mount_flags)?;
        self.vibration.resume(vibration);
        if prior.pairs == 0 {
            return Some(());
        }
        self.hypotheses.resume(prior, &context.vibrating(self.vibration.variances()));
        let covariance = self.hypotheses.champion()?.covariance_of_noise(context)?;
        let is_finite = StandardDeviations::of(&covariance).is_finite();
        (prior.is_consistent() && is_finite).then_some(())
    }

    /// Whether the lens of the estimate has a finite solution.
    #[inline(never)]
    pub(crate) fn has_lens(&self, context: &Context<'_, T>) -> bool {
        let estimate = self.hypotheses.champion().filter(|_| context.has_lens_prior());
        estimate.is_none_or(|champion| {
            let mut lens = HypothesisLens::EXACT;
            lens.estimate(champion, &self.reference, context).is_some()
        })
    }
}
