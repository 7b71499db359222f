//! The pass that judges a pose: what the batch says there, and whether it says anything at all.

use nalgebra::Vector5;

use super::NOISE_PX;
use super::hearing::{Bench, Hearing};
use super::outlook::Outlook;
use super::tally::Tally;
use super::weighing::Weighed;
use crate::batch::Matches;
use crate::correspondence::RayPair;
use crate::error::PairError;
use crate::lanes::Single;
use crate::moments::Moments;
use crate::quadratic::Quadratic;
use crate::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Share of the correspondences that must fit a pose found from afar.
const MIN_INLIERS: f64 = 0.15;

/// What one batch says of the extrinsics.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Evidence<T: Scalar> {
    /// Where the batch was judged: the frame of the moments.
    pub(crate) pose: RectifyingRotations<T>,
    pub(crate) moments: Moments<T>,
    /// Of the left and of the upper half of the image, about the pose.
    pub(crate) halves: [Quadratic<T>; 2],
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Share of the usable correspondences within 3 standard deviations.
    pub(crate) share: T,
}

/// A judged pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Judged<T: Scalar> {
    pub(crate) evidence: Evidence<T>,
    /// Whether disparities are more than noise.
    pub(crate) speaks_of_baseline: bool,
    pub(crate) tally: Tally<T>,
}

/// What a judgement sums beside the evidence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Heard<T> {
    pub(super) tally: Tally<T>,
    pub(super) gradient: Vector5<T>,
    /// Of the weights, 1/px^2, and of the weights times the variance of a coordinate.
    pub(super) weights: [T; 2],
}

impl<T: Scalar> Outlook<T> {
    /// Judges the pose, in one pass.
    ///
    /// * `judged`: of nothing yet; of no use after an error.
    ///
    /// # Errors
    /// [`PairError::TooFew`] in front of both cameras, [`PairError::Unobservable`] where the sums are
    /// not finite.
    #[inline(never)]
    pub(crate) fn judge(
        &self,
        matches: Matches<'_, T>,
        judged: &mut Judged<T>,
    ) -> Result<(), PairError> {
        let Judged { evidence, tally: counted, speaks_of_baseline } = judged;
        #[cfg(feature = "simd")]
        let Heard { tally, gradient, weights } = self.hear_side_by_side(matches, evidence);
        #[cfg(not(feature = "simd"))]
        let Heard { tally, gradient, weights } = self.hear_one_by_one(matches.pairs, evidence);
        let Evidence { pose, moments, noise, share, .. } = evidence;
        *pose = self.pose;
        moments.set_gradient(&gradient);
        let [sum, variances] = weights;
        let variance = variances / (sum.max(T::EPSILON) * self.focal * self.focal);
        *speaks_of_baseline = moments.speaks_of_baseline(variance);
        *noise = self.noise_of(tally.near_squares(), tally.near());
        *share = tally.inliers();
        *counted = tally;
        self.check(tally.usable)?;
        if moments.is_finite() && noise.is_finite() { Ok(()) } else { Err(PairError::Unobservable) }
    }

    /// Adds correspondences to the moments and the halves, and sums what else they say.
    #[inline(always)]
    pub(super) fn hear_one_by_one(
        &self,
        pairs: &[RayPair<T>],
        evidence: &mut Evidence<T>,
    ) -> Heard<T> {
        let (bench, mut hearing) = (Bench::of(Single, self), Hearing::nothing(Single));
        let Evidence { moments, halves: [left_half, upper_half], .. } = evidence;
        // A row is in one quadrant of the image: the halves and the whole are made of those.
        let mut quadrants = [[Quadratic::ZERO; 2]; 2];
        for pair in pairs {
            let rays = pair.rays();
            let judged = hearing.judge(Single, &bench, rays, pair.grid_step());
            let Some((Weighed { weight, value, jacobian }, seen)) = judged else {
                continue;
            };
            let [x, y, ..] = rays;
            let [upper, lower] = &mut quadrants;
            let [left, right] = if y < T::ZERO { upper } else { lower };
            let quadrant = if x < T::ZERO { left } else { right };
            quadrant.add_row(weight, value, &jacobian);
            moments.add_seen(&seen);
        }
        let [[upper_left, upper_right], [lower_left, _]] = &quadrants;
        left_half.add(&upper_left.plus(lower_left));
        upper_half.add(&upper_left.plus(upper_right));
        let gradient = quadrants.as_flattened().iter().map(|quadrant| quadrant.gradient).sum();
        let Hearing { tallies, weights } = hearing;
        let seen = u32::try_from(pairs.len()).unwrap_or(u32::MAX);
        Heard { tally: Tally::of(Single, seen, &tallies), gradient, weights }
    }
}

#[cfg(feature = "simd")]
impl<T: Scalar> Heard<T> {
    /// The sums of two parts of a batch.
    pub(super) fn plus(&self, other: &Self) -> Self {
        let ([a, b], [c, d]) = (self.weights, other.weights);
        Self {
            tally: self.tally.plus(&other.tally),
            gradient: self.gradient + other.gradient,
            weights: [a + c, b + d],
        }
    }
}

impl<T: Scalar> Judged<T> {
    pub(crate) const NOTHING: Self = Self {
        evidence: Evidence {
            pose: RectifyingRotations::SIDE_BY_SIDE,
            moments: Moments::ZERO,
            halves: [Quadratic::ZERO; 2],
            noise: T::ZERO,
            share: T::ZERO,
        },
        speaks_of_baseline: false,
        tally: Tally::NONE,
    };

    /// Whether a pose found from afar is one: the residuals gather at zero. Mismatches have about as
    /// many within two standard deviations as from two to four, and let the scale grow.
    ///
    /// * `needed`: correspondences, by configuration.
    pub(crate) fn is_found(&self, needed: u32) -> bool {
        let near = T::count(self.tally.near());
        self.tally.near() >= needed
            && near >= T::lit(2.0) * T::count(self.tally.beside())
            && near >= T::lit(MIN_INLIERS) * T::count(self.tally.usable)
            && self.stands_out(T::lit(3.0))
            && self.evidence.noise < T::lit(NOISE_PX[0])
    }

    /// Whether the residuals at a pose that is known already gather at zero.
    pub(crate) fn has_peak(&self) -> bool {
        let [near, beside] = [self.tally.near(), self.tally.beside()];
        near >= 8 && T::count(near) >= T::lit(1.5) * T::count(beside)
    }

    /// Whether they do so by more than chance: what a pose must show that is not yet known.
    pub(crate) fn has_clear_peak(&self) -> bool {
        self.stands_out(T::lit(2.0))
    }

    /// Whether more residuals are near zero than beside by so many deviations of chance, which counts
    /// both alike.
    fn stands_out(&self, deviations: T) -> bool {
        let [near, beside] = [self.tally.near(), self.tally.beside()].map(T::count);
        near - beside >= deviations * (near + beside).sqrt()
    }
}

impl<T: Scalar> Evidence<T> {
    /// Information and slope at a pose.
    pub(crate) fn seen_at(&self, pose: &RectifyingRotations<T>) -> Quadratic<T> {
        self.moments.seen_at(&self.pose, pose)
    }
}
