//! Evaluation: the last pass of a pair, at the pose reached (`ESTIMATOR.md`, section 7).
//!
//! Sums moments, the gradient with the derivative of `V`, normal equations of the image halves, and residual
//! statistics; the statistics tell an optimum from a pose among outliers.

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
    /// Pose of the evaluation: frame of the moments.
    pub(crate) pose: RectifyingRotations<T>,
    /// Moments of the weighted rays, 1/rad^2.
    pub(crate) moments: Moments<T>,
    /// Normal equations of the left and of the upper half of the image, about the pose.
    pub(crate) halves: [NormalEquations<T>; 2],
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Share of the usable correspondences within 3 standard deviations; 0 where next to none of them has weight.
    pub(crate) inlier_share: T,
    /// Share of the usable correspondences that are in a second crowd, with the sign of its side.
    pub(crate) crowd: T,
    /// Residuals within 2 units of the loss and from 2 to 4, of correspondences of high leverage.
    pub(crate) high_leverage: [T; 2],
}

/// An evaluated pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EvaluatedPose<T: Scalar> {
    pub(crate) measurement: PairMeasurement<T>,
    /// Residuals at start and pose.
    pub(crate) stats: ResidualStats<T>,
}

/// Correspondences that are weighted before they are added. The registers do not hold all sums: each is loaded and
/// stored once for all of these correspondences.
const GATHERED: usize = 8;

impl<T: Scalar> Iterate<T> {
    /// Evaluates the pose, in one pass.
    ///
    /// * `evaluated`: [`EvaluatedPose::NONE`]; unspecified after an error.
    ///
    /// # Errors
    /// [`Rejection::TooFew`] in front of both cameras, [`Rejection::Unobservable`] where the sums are not finite.
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
        // Such a pose is of a few matches, and agrees with any hypothesis.
        let are_weighted = variances >= T::lit(MIN_WEIGHTED) * stats.near();
        *inlier_share = if are_weighted { stats.inlier_share() } else { T::ZERO };
        *crowd = stats.crowd();
        *high_leverage = stats.high_leverage;
        stats.skipped = T::count(u32::try_from(matches.len()).unwrap_or(u32::MAX)) - stats.usable;
        self.check(stats.usable)?;
        if moments.is_finite() && noise.is_finite() { Ok(()) } else { Err(Rejection::Unobservable) }
    }

    /// Fills moments, halves and statistics. Returns the gradient with the derivative of `V`, 1/rad, and the sums of the
    /// weights, 1/px^2, and of the weights times the variance of a coordinate.
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
            let Some(row) = pass.row(pair.rays(), pair.grid_step()) else { continue };
            if rows.is_full() {
                sums.add(&rows);
                rows.clear();
            }
            // There is room.
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

/// The pass of an evaluation: its parameters, and the sums over all rows.
struct Evaluation<T> {
    by: Weighting<T>,
    start: PoseTerms<T>,
    stats: ResidualStats<T>,
    /// Sums of the weights, 1/px^2, and of the weights times the variance of a coordinate.
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

    /// Counts and compares a correspondence; its terms, if it has weight.
    ///
    /// * `rays`: `x_l`, `y_l`, `x_r`, `y_r` at unit depth; `grid_step`: px.
    #[inline(always)]
    fn row(&mut self, rays: [T; 4], grid_step: T) -> Option<EvaluatedRow<T>> {
        let Self { by, start, stats, weights } = self;
        let constraint = Constraint::of(&by.pose, rays)?;
        let (value, offset) = (constraint.value, constraint.row_offset());
        let expected = by.expected(grid_step);
        let precision = by.precision(&constraint);
        let squared = value * value * precision;
        stats.count([value, squared], constraint.disparity_over(by.min_disparity), &expected);
        let limit = expected.limit_squared(by.tukey_squared);
        stats.compare(&Compared {
            before: Constraint::of(start, rays).map(|before| before.row_offset()).map(|e| e * e),
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
        *sum += w;
        *variances += w * expected.variance;
        let row = WeightedRow { weight: w * precision, value, jacobian };
        let ([x, y, ..], coordinates) = (rays, constraint.coordinates(&by.pose, rays));
        Some(EvaluatedRow { row, coordinates, at: [x, y] })
    }
}

impl<T: Scalar> EvaluatedPose<T> {
    /// Before an evaluation.
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

    /// Whether a pose found by a search is an optimum: residuals form a peak at zero. Outliers alone fill
    /// 0 to 2 and 2 to 4 units alike and raise the noise, so a wider peak must hold more matches.
    ///
    /// * `needed`: near residuals, by configuration.
    pub(crate) fn is_found(&self, needed: u16) -> bool {
        let (near, beside) = (self.stats.near(), self.stats.beside());
        let noise = self.measurement.noise;
        let [share, per_px] = FOUND_NEAR.map(T::lit);
        let share = (share + per_px * noise).min(T::lit(FOUND_NEAR_MOST));
        near >= T::count(needed.into())
            && near >= T::lit(PEAK_OVER_BESIDE) * beside
            && near >= share * self.stats.usable
            && self.stats.exceed_background()
            && noise < T::lit(MAX_NOISE_PX)
            && self.is_largest_crowd()
    }

    /// Why residuals that form a peak do not come from a scene.
    ///
    /// * `needed`: near residuals, by configuration.
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

    /// Whether most of the points that fit are clearly in front of the cameras: a scene at infinity fits any baseline.
    pub(crate) fn is_clearly_in_front(&self) -> bool {
        let [ahead, _] = self.stats.sides;
        ahead > self.stats.near() * T::HALF
    }

    /// Whether residuals form a peak at zero, at a pose that is known from other pairs.
    pub(crate) fn has_peak(&self) -> bool {
        let (near, beside) = (self.stats.near(), self.stats.beside());
        near >= T::count(TRACK_MIN_NEAR)
            && near >= T::lit(TRACK_PEAK) * beside
            && self.is_largest_crowd()
            && !self.stats.is_behind()
            && !self.measurement.moments.are_disparities_alike()
    }

    /// False if more matches lean to one side than fit, if none fit, or between two crowds: the pose may then follow a
    /// fence.
    fn is_largest_crowd(&self) -> bool {
        let PairMeasurement { crowd, inlier_share, .. } = self.measurement;
        inlier_share > T::ZERO && crowd.abs() <= inlier_share && !self.stats.is_hollow()
    }

    /// Whether that peak exceeds chance, at a pose that is not yet confirmed.
    pub(crate) fn has_clear_peak(&self) -> bool {
        self.stats.exceed_background()
    }
}

impl<T: Scalar> PairMeasurement<T> {
    /// Normal equations at any pose, by the moments; exact for the frozen weights. With the noise of disparities.
    pub(crate) fn biased_at(&self, pose: &RectifyingRotations<T>) -> BiasedEquations<T> {
        self.moments.biased_at_pose(&self.pose, pose)
    }

    /// [`Self::biased_at`] without the noise of disparities.
    pub(crate) fn debiased_at(&self, pose: &RectifyingRotations<T>) -> NormalEquations<T> {
        self.biased_at(pose).debiased()
    }
}

#[cfg(test)]
mod tests;
