//! Evaluation: the last pass of a pair, at the pose reached (`ESTIMATOR.md`, section 7).
//!
//! The pass sums the moments, the gradient including the derivative of `V`, the normal equations of the image halves,
//! and residual statistics. The statistics distinguish an optimum from a pose that only outliers fit.

use nalgebra::Vector5;

use super::constraint::{Constraint, PoseTerms};
use super::iterate::Iterate;
use super::regions::{EvaluatedRow, QuadrantSums};
use super::residual_stats::{Compared, ResidualStats};
use super::weighting::{Loss, WeightedRow, Weighting};
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::moments::Moments;
use crate::algebra::normal_equations::NormalEquations;
use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::DIFFERENCE_VARIANCE;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{
    FOUND_NEAR, FOUND_NEAR_MOST, MAX_NOISE_PX, MIN_WEIGHTED, PEAK_OVER_BESIDE, TRACK_MIN_NEAR,
    TRACK_PEAK,
};

/// Measurement of the extrinsics by one batch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PairMeasurement<T: Scalar> {
    /// Pose of the evaluation; its rectified frame is the frame of the moments.
    pub(crate) pose: RectifyingRotations<T>,
    /// Moments of the weighted rays, 1/rad^2.
    pub(crate) moments: Moments<T>,
    /// Normal equations of the left half and of the upper half of the image, about the pose.
    pub(crate) halves: [NormalEquations<T>; 2],
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Share of the usable correspondences with residuals within 3 units of the loss; 0 if the near correspondences
    /// have almost no weight.
    pub(crate) inlier_share: T,
    /// Share of the usable correspondences in a second crowd, that is, in a group of matches that fit another pose: the
    /// number of positive minus the number of negative residuals from 2 to [`crate::thresholds::CROWD`] units of the
    /// loss, over the number of usable correspondences.
    pub(crate) crowd: T,
    /// Numbers of weighted correspondences in the separate class of high leverage
    /// ([`super::leverage::Leverage::is_separate`]), with residuals below 2 units of the loss, and from 2 to 4 units.
    pub(crate) high_leverage: [T; 2],
}

/// An evaluated pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EvaluatedPose<T: Scalar> {
    pub(crate) measurement: PairMeasurement<T>,
    /// Residual statistics at the start and at the pose.
    pub(crate) stats: ResidualStats<T>,
}

/// Number of correspondences that are weighted before their terms are added together. The registers cannot hold all
/// sums, so each sum is loaded and stored once for this number of correspondences.
const GATHERED: usize = 8;

impl<T: Scalar> Iterate<T> {
    /// Evaluates the pose in one pass.
    ///
    /// * `evaluated`: receives the result; [`EvaluatedPose::NONE`] before the call, unspecified after an error.
    ///
    /// # Errors
    /// [`Rejection::TooFew`]: too few correspondences in front of both cameras. [`Rejection::Unobservable`]: the sums
    /// are not finite.
    #[inline(never)]
    pub(crate) fn evaluate(
        &self,
        matches: &[RayPair<T>],
        evaluated: &mut EvaluatedPose<T>,
    ) -> Result<(), Rejection> {
        let (gradient, weights) = self.sum(matches, evaluated);
        let EvaluatedPose { measurement, stats } = evaluated;
        let PairMeasurement { pose, moments, noise, inlier_share, crowd, high_leverage, .. } =
            measurement;
        *pose = self.pose;
        moments.set_gradient(&gradient);
        let [sum, variances] = weights;
        let variance = variances / (sum.max(T::EPSILON) * self.focal * self.focal);
        moments.set_noise(pose, variance);
        *noise = self.noise_of(stats.near_squares, stats.near());
        // A pose whose near matches have almost no weight rests on a few matches, and would agree with any hypothesis.
        let are_weighted = variances >= T::lit(MIN_WEIGHTED) * stats.near();
        *inlier_share = if are_weighted { stats.inlier_share() } else { T::ZERO };
        *crowd = stats.crowd();
        *high_leverage = stats.high_leverage;
        stats.skipped = T::count(u32::try_from(matches.len()).unwrap_or(u32::MAX)) - stats.usable;
        self.check(stats.usable)?;
        if moments.is_finite() && noise.is_finite() { Ok(()) } else { Err(Rejection::Unobservable) }
    }

    /// Fills moments, halves and statistics. Returns the gradient including the derivative of `V`, 1/rad, and two sums:
    /// of the weights over the squared local scales, 1/px^2, and of the weights times the variance of a coordinate,
    /// dimensionless.
    fn sum(
        &self,
        matches: &[RayPair<T>],
        evaluated: &mut EvaluatedPose<T>,
    ) -> (Vector5<T>, [T; 2]) {
        let EvaluatedPose { measurement, stats } = evaluated;
        let mut pass = Evaluation::at(self);
        let mut sums = QuadrantSums {
            moments: &mut measurement.moments,
            quadrants: [[NormalEquations::ZERO; 2]; 2],
        };
        let mut rows = heapless::Vec::<_, GATHERED>::new();
        for pair in matches {
            let Some(row) = pass.row(pair) else { continue };
            if rows.is_full() {
                sums.add(&rows);
                rows.clear();
            }
            // The vector has room.
            let _ = rows.push(row);
        }
        sums.add(&rows);
        *stats = pass.stats;
        let [[upper_left, upper_right], [lower_left, _]] = &sums.quadrants;
        let [left_half, upper_half] = &mut measurement.halves;
        *left_half = upper_left.plus(lower_left);
        *upper_half = upper_left.plus(upper_right);
        let gradients = sums.quadrants.as_flattened().iter().map(|quadrant| quadrant.gradient);
        (gradients.sum(), pass.weights)
    }
}

/// Parameters of the pass of an evaluation, and its sums over all rows.
struct Evaluation<T> {
    by: Weighting<T>,
    start: PoseTerms<T>,
    stats: ResidualStats<T>,
    /// Sum of the weights over the squared local scales, 1/px^2, and sum of the weights times the variance of a
    /// coordinate, dimensionless.
    weights: [T; 2],
}

impl<T: Scalar> Evaluation<T> {
    #[inline(always)]
    fn at(iterate: &Iterate<T>) -> Self {
        Self {
            by: iterate.weighting(Loss::Polish),
            start: PoseTerms::at(&iterate.start),
            stats: ResidualStats::NONE,
            weights: [T::ZERO; 2],
        }
    }

    /// Counts a correspondence, and compares its row offsets at start and pose. Returns its terms if it has weight.
    ///
    #[inline(always)]
    fn row(&mut self, pair: &RayPair<T>) -> Option<EvaluatedRow<T>> {
        let Self { by, start, stats, weights } = self;
        let constraint = Constraint::of(&by.pose, pair)?;
        let (value, offset) = (constraint.value, constraint.row_offset());
        let expected = by.expected(pair.grid_step());
        let precision = by.precision(&constraint);
        let squared = value * value * precision;
        stats.count([value, squared], constraint.disparity_over(by.min_disparity), &expected);
        let limit = expected.limit_squared(by.tukey_squared);
        stats.compare(&Compared {
            before: Constraint::of(start, pair).map(|before| before.row_offset()).map(|e| e * e),
            after: offset * offset,
            most: T::lit(DIFFERENCE_VARIANCE) * limit * by.unit_squared,
            fits: squared <= limit,
        });
        if !constraint.has_disparity(by.min_disparity) {
            return None;
        }
        let (mut w, _) = expected.tukey(by.tukey_squared, squared);
        if !(w > T::ZERO) {
            return None;
        }
        let ratio = value * precision * by.unit_squared;
        let jacobian = constraint.whitened_jacobian(&by.pose, ratio);
        if let Some(leverage) = &by.leverage {
            let limited = leverage.factor(w * precision, &jacobian);
            if leverage.is_separate(limited.share) {
                expected.count_bands(squared, &mut stats.high_leverage);
            }
            w *= limited.factor;
        }
        let [sum, variances] = weights;
        *sum += w / constraint.scale_squared;
        *variances += w * expected.variance;
        let row = WeightedRow { weight: w * precision, value, jacobian };
        let rays @ [x, y, ..] = pair.rays();
        let coordinates = constraint.coordinates(&by.pose, rays);
        Some(EvaluatedRow { row, coordinates, at: [x, y] })
    }
}

impl<T: Scalar> EvaluatedPose<T> {
    /// Value before an evaluation.
    pub(crate) const NONE: Self = Self {
        measurement: PairMeasurement {
            pose: RectifyingRotations::SIDE_BY_SIDE,
            moments: Moments::ZERO,
            halves: [NormalEquations::ZERO; 2],
            noise: T::ZERO,
            inlier_share: T::ZERO,
            crowd: T::ZERO,
            high_leverage: [T::ZERO; 2],
        },
        stats: ResidualStats::NONE,
    };

    /// Returns whether a pose found by a search is an optimum, that is, whether the residuals form a peak at zero.
    /// Outliers alone fill the bands from 0 to 2 and from 2 to 4 units equally, and raise the noise estimate. So at
    /// higher noise the peak must hold more matches. The noise must be below [`MAX_NOISE_PX`], and the inliers must be
    /// the largest group of matches that fit one pose.
    ///
    /// * `needed`: least number of near residuals, from the configuration.
    pub(crate) fn is_found(&self, needed: u16) -> bool {
        let (near, beside) = (self.stats.near(), self.stats.beside());
        near >= T::count(needed.into())
            && near >= T::lit(PEAK_OVER_BESIDE) * beside
            && near >= self.share_of_found() * self.stats.usable
            && self.stats.exceed_background()
            && self.measurement.noise < T::lit(MAX_NOISE_PX)
            && self.is_largest_crowd()
    }

    /// Returns the share of near residuals among the usable ones that a pose found by a search needs.
    fn share_of_found(&self) -> T {
        let [share, per_px] = FOUND_NEAR.map(T::lit);
        (share + per_px * self.measurement.noise).min(T::lit(FOUND_NEAR_MOST))
    }

    /// Returns the reason if residuals form a peak but do not come from a valid scene: [`Rejection::Behind`] or
    /// [`Rejection::NoDepth`].
    ///
    /// * `needed`: least number of near residuals, from the configuration.
    pub(crate) fn no_scene(&self, needed: u16) -> Option<Rejection> {
        let forms_peak =
            self.stats.near() >= T::count(needed.into()) && self.stats.exceed_background();
        let why = if self.stats.is_behind() {
            Some(Rejection::Behind)
        } else {
            self.measurement.moments.are_disparities_alike().then_some(Rejection::NoDepth)
        };
        why.filter(|_| forms_peak)
    }

    /// Returns whether most of the points that fit are clearly in front of the cameras. A scene at infinity fits any
    /// baseline, but fails this test, because its disparities are only noise.
    pub(crate) fn is_clearly_in_front(&self) -> bool {
        let [ahead, _] = self.stats.sides;
        ahead > self.stats.near() * T::HALF
    }

    /// Tests a pose that is already known from other pairs. Returns whether the residuals form a peak at zero, and come
    /// from a valid scene. The peak must hold half of the share of matches that a pose found by a search needs, and its
    /// matches must be the largest group. A scene is not valid if too many points are behind the cameras, or if the
    /// disparities show no depth.
    pub(crate) fn has_peak(&self) -> bool {
        let (near, beside) = (self.stats.near(), self.stats.beside());
        near >= T::count(TRACK_MIN_NEAR)
            && near >= T::lit(TRACK_PEAK) * beside
            && near >= T::HALF * self.share_of_found() * self.stats.usable
            && self.is_largest_crowd()
            && !self.stats.is_behind()
            && !self.measurement.moments.are_disparities_alike()
    }

    /// Returns whether the inliers are the largest group of matches that fit one pose. False if a second crowd
    /// ([`PairMeasurement::crowd`]) is larger, or if the pose lies between two groups: the pose may then follow a
    /// repeated structure, such as a fence. Also false if no match fits, or if the near matches have almost no weight.
    fn is_largest_crowd(&self) -> bool {
        let PairMeasurement { crowd, inlier_share, .. } = self.measurement;
        inlier_share > T::ZERO && crowd.abs() <= inlier_share && !self.stats.is_hollow()
    }

    /// Returns whether the peak of residuals exceeds chance.
    pub(crate) fn has_clear_peak(&self) -> bool {
        self.stats.exceed_background()
    }
}

impl<T: Scalar> PairMeasurement<T> {
    /// Returns the normal equations at any pose from the moments, exact for frozen weights. They include the noise of
    /// disparities.
    pub(crate) fn biased_at(&self, pose: &RectifyingRotations<T>) -> BiasedEquations<T> {
        self.moments.in_frame_of(&self.pose).biased_at(pose)
    }

    /// Returns a share of the equations of [`Self::biased_at`], without the noise of disparities.
    pub(crate) fn debiased_at(
        &self,
        pose: &RectifyingRotations<T>,
        share: T,
    ) -> NormalEquations<T> {
        self.biased_at(pose).scaled(share).debiased()
    }
}

#[cfg(test)]
mod tests;
