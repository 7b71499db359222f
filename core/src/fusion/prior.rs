//! An estimate as the start of a new hypothesis, in the form that a record stores (`ESTIMATOR.md`, section 21).
//!
//! The moments of a hypothesis are replaced by the moments of five virtual correspondences with the same information on
//! the extrinsics and the same response to the lens (`Moments::set_prior`). So further pairs can be added to a restored
//! estimate, and it fades and is reported like any other estimate.

use core::slice::from_mut;

use super::Fusion;
use super::lens::{HypothesisLens, Knowledge};
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

/// Largest element of the equations in a record, 1/rad^2. A match adds about `(f / sigma)^2 / 2` to the information on
/// a rotation, with the focal length and the noise of a coordinate in px. The memory holds 1000 pairs, and 256 matches
/// of each reach the limit at `f / sigma` = 8.8e4: 13,000 px at the noise floor of 0.15 px. With 1024 matches it is
/// 6,600 px, and at 8000 px the scaled equations have deviations 1.2 times as large. Beyond the limit `f32` loses digits
/// of the determinant of a covariance, which is a product of two variances.
pub(crate) const MAX_INFORMATION: f32 = 1e15;

/// Slack of the limits of numbers that a record has rounded to `f32`.
pub(crate) const ROUNDED: f64 = 1.001;

/// An estimate without its pairs.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Prior<T: Scalar> {
    pub(crate) pose: RectifyingRotations<T>,
    /// Equations of the pairs about the pose. For a rigid rig they include the noise of disparities. For a vibrating
    /// rig they have the information on the mean rig, without that noise; so they do for a rigid rig whose noise is not
    /// plausible as a part of the equations. A record stores only the baseline part of the gradient.
    pub(crate) equations: BiasedEquations<T>,
    pub(crate) response: Response<T>,
    /// Reduced chi-square of the pairs.
    pub(crate) chi_square: T,
    /// Number of pairs in the estimate; 0 if there is no estimate.
    pub(crate) pairs: u32,
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Running means of the share of inliers and of [`crate::pair::evaluate::PairMeasurement::crowd`].
    pub(crate) shares: [T; 2],
    /// Fading numbers of matches of high leverage: with residuals within 2 units of the loss, and from 2 to 4 units.
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

    /// Returns whether the noise of disparities is plausible as a part of the equations, and whether the moments of the
    /// prior keep the digits of the information ([`Response::keeps_digits_of`]).
    ///
    /// * `slack`: factor of the limits, for the rounding of a record.
    pub(super) fn is_consistent(&self, slack: T) -> bool {
        let Self { equations: BiasedEquations { normal, noise }, response, .. } = self;
        let [forward, mixed, down] = noise.0;
        let [_, _, _, all_forward, all_down] = normal.information.0.diagonal();
        let is_part =
            |noise: T, all: T| noise >= T::ZERO && noise <= all.max(T::ZERO) * T::lit(4.0) * slack;
        is_part(forward, all_forward)
            && is_part(down, all_down)
            && mixed * mixed <= forward * down * T::lit(1.01) * slack
            && response.keeps_digits_of(&normal.information, slack)
    }

    /// Scales the equations so that no element exceeds [`MAX_INFORMATION`]. They then count as equations of fewer
    /// pairs, with the same optimum.
    pub(super) fn limit(&mut self) {
        let BiasedEquations { normal, noise } = &self.equations;
        let elements = normal.information.0.diagonal().into_iter().chain(noise.0);
        let (largest, most) = (elements.fold(T::ZERO, T::max), T::single(MAX_INFORMATION));
        if largest > most {
            self.equations = self.equations.scaled(most / largest);
        }
    }
}

/// The part of the state of the robust method that a record stores.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Learned<T: Scalar> {
    /// The champion.
    pub(crate) prior: Prior<T>,
    /// Numbers of [`LensReference::numbers`]; `changes` is the number of changes of the lens correction.
    lens: [T; 6],
    pub(crate) changes: u8,
    vibration: KnownVibration<T>,
    /// Numbers of [`crate::depth::mount::MountYaw::parts`].
    mount: [T; 6],
    /// Whether these numbers are known.
    pub(crate) knows_mount: bool,
}

impl<T: Scalar> Learned<T> {
    /// Returns content without anything learnt: no estimate, the given lens, no vibration, and no knowledge of the
    /// mount yaw beyond the factory calibration.
    // Not a constant, because a constant would take its full size in flash.
    pub(crate) fn nothing() -> Self {
        Self::of_lens(&LensReference::GIVEN)
    }

    /// Returns content with only the knowledge of the lens.
    pub(crate) fn of_lens(lens: &LensReference<T>) -> Self {
        let zero = T::ZERO;
        Self {
            prior: Prior::NONE,
            lens: lens.numbers(),
            changes: lens.changes(),
            vibration: KnownVibration::NONE,
            mount: [T::ONE, zero, zero, zero, zero, zero],
            knows_mount: false,
        }
    }

    /// Returns the numbers that follow the pose in a record, in the order of the record.
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

    /// Returns the lens correction of the rays.
    pub(crate) fn correction(&self) -> LensCorrection<T> {
        let [focal, k1, ..] = self.lens;
        LensCorrection { focal, k1 }
    }
}

/// Pose and yaw of an estimate with their uncertainty. The policy compares the present place with the place at the last
/// save.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place<T: Scalar> {
    pose: RectifyingRotations<T>,
    sd: StandardDeviations<T>,
    /// Yaw of the mount as known apart from the present sums, rad, relative to the factory extrinsics; 0 if nothing is
    /// known of it.
    yaw: T,
    pub(crate) pairs: u32,
}

impl<T: Scalar> Place<T> {
    /// Returns whether `R`, `t` or the yaw has moved by more than [`FREEDOM_RAD`] since `old`. `R` and `t` must also
    /// have moved by more than the standard deviations of this place, because a far scene moves `t` by chance.
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
    /// Returns the place of the champion; `None` without a champion or without its covariance.
    pub(crate) fn place(&self, context: &Context<'_, T>) -> Option<Place<T>> {
        let champion = self.hypotheses.champion()?;
        Some(Place {
            pose: *champion.pose(),
            sd: champion.deviations(context)?,
            yaw: self.mount.known_yaw(),
            pairs: champion.pairs(),
        })
    }

    /// Returns the knowledge of the lens for a record.
    pub(crate) fn learned_lens(&self, context: &Context<'_, T>) -> LensReference<T> {
        let champion = self.hypotheses.champion();
        champion
            .map_or(self.reference, |champion| self.reference.with_knowledge_of(champion, context))
    }

    /// Fills the content of a record, apart from the lens. An estimate whose sums have no solution is left out.
    #[inline(never)]
    pub(crate) fn learn(&self, learned: &mut Learned<T>, context: &Context<'_, T>) {
        if let Some(champion) = self.hypotheses.champion() {
            let prior = &mut learned.prior;
            if champion.fill_prior(prior, context).is_none() {
                learned.prior = Prior::NONE;
            }
        }
        learned.vibration = self.vibration.known();
        (learned.mount, learned.knows_mount) = self.mount.parts();
    }

    /// Restores the content of a record. The estimate is suspect until a pair supports it. `None` if the parts of the
    /// record do not fit together; this value is then unspecified.
    #[inline(never)]
    pub(crate) fn resume(&mut self, learned: &Learned<T>, context: &Context<'_, T>) -> Option<()> {
        let Learned { prior, lens, changes, vibration, mount, knows_mount } = learned;
        self.reference = LensReference::of(*lens, *changes)?;
        self.mount.resume(*mount, *knows_mount)?;
        self.vibration.resume(vibration);
        if prior.pairs == 0 {
            return Some(());
        }
        let vibrating = context.vibrating(self.vibration.variances());
        let is_at_optimum = self.hypotheses.resume(prior, &vibrating);
        let covariance = self.hypotheses.champion()?.covariance_of_noise(context)?;
        let is_finite = StandardDeviations::of(&covariance).is_finite();
        (prior.is_consistent(T::lit(ROUNDED)) && is_finite && is_at_optimum).then_some(())
    }

    /// Returns whether the lens of the estimate has a plausible finite solution; true without a champion or without a
    /// lens prior.
    #[inline(never)]
    pub(crate) fn has_lens(&self, context: &Context<'_, T>) -> bool {
        let estimate = self.hypotheses.champion().filter(|_| context.has_lens_prior());
        estimate.is_none_or(|champion| {
            let mut lens = HypothesisLens::EXACT;
            lens.estimate(champion, &self.reference, Knowledge::Included, context).is_some()
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::hypothesis::tests::truth;
    use super::*;
    use crate::algebra::disparity_noise::BaselineNoise;
    use crate::algebra::information::Information;
    use crate::algebra::symmetric5::Symmetric5;
    use nalgebra::Vector5;

    #[test]
    fn noise_whose_mixed_element_exceeds_the_others_is_inconsistent() {
        let is_consistent = |noise: [f64; 3]| {
            let information = Information(Symmetric5::of_diagonal([1e6; 5]));
            let normal = NormalEquations { information, ..NormalEquations::ZERO };
            let equations = BiasedEquations { normal, noise: BaselineNoise(noise) };
            Prior { equations, ..Prior::NONE }.is_consistent(1.0)
        };
        assert_eq!([9e5, 1.1e6].map(|mixed| is_consistent([1e6, mixed, 1e6])), [true, false]);
        assert_eq!([3.9e6, 4.1e6].map(|all| is_consistent([all, 0.0, 0.0])), [true, false]);
        assert!(!is_consistent([-1.0, 0.0, 0.0]) && !is_consistent([0.0, 0.0, f64::NAN]));
    }

    #[test]
    fn equations_beyond_the_range_of_a_record_are_scaled_as_a_whole() {
        let most = f64::from(MAX_INFORMATION);
        let mut information = Symmetric5::of_diagonal([0.5, 0.2, 0.1, 0.05, 0.02]);
        information.0[1] = 0.1;
        let normal = NormalEquations {
            information: Information(information.scaled(most)),
            gradient: Vector5::repeat(0.01 * most),
        };
        let within = BiasedEquations { normal, noise: BaselineNoise([0.04, 0.01, 0.02]) };
        for (factor, kept) in [(1.9, 1.9), (10.0, 2.0)] {
            let mut prior = Prior { equations: within.scaled(factor), ..Prior::NONE };
            prior.limit();
            let off = prior.equations.minus(&within.scaled(kept));
            let left = off.normal.information.0.0.iter().chain(&off.noise.0);
            assert!(left.chain(&off.normal.gradient).all(|x| x.abs() < 1e-6 * most), "{off:?}");
        }
    }

    #[test]
    fn an_estimate_has_moved_by_each_unknown_beyond_its_freedom_and_not_within() {
        let zero = Symmetric5::of_diagonal([0.0; 5]);
        let at = |pose| Place { pose, sd: StandardDeviations::of(&zero), yaw: 0.1, pairs: 10 };
        for unknown in 0..5 {
            for (share, has_moved) in [(0.9, false), (1.1, true)] {
                let mut d = Vector5::zeros();
                d[unknown] = share * FREEDOM_RAD;
                let place = at(truth().stepped_by(&d).unwrap());
                assert_eq!(place.has_moved_from(&at(truth())), has_moved, "{unknown} {share}");
            }
        }
    }

    #[test]
    fn an_estimate_has_moved_by_its_yaw_only_if_the_yaw_has_changed() {
        let at = |yaw: f64| {
            let zero = Symmetric5::of_diagonal([0.0; 5]);
            Place { pose: truth(), sd: StandardDeviations::of(&zero), yaw, pairs: 10 }
        };
        assert!(!at(0.1).has_moved_from(&at(0.1)));
        assert!(at(0.1).has_moved_from(&at(0.102)) && at(0.102).has_moved_from(&at(0.1)));
    }
}
