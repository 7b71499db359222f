//! Evaluation: the last pass of a pair, at the pose reached (`ESTIMATOR.md`, section 7).
//!
//! Sums moments, the gradient with the derivative of `V`, normal equations of the image halves, and residual
//! statistics; the statistics tell an optimum from a pose among outliers.

use core::slice;

use nalgebra::Vector5;

use super::constraint::{Constraint, PoseTerms};
use super::iterate::Iterate;
use super::loss::ResidualVariance;
use super::regions::{EvaluatedRow, EvaluatedSums, HalfSums, QuadrantSums};
use super::residual_stats::{Compared, ResidualStats};
use super::sweep::{self, Part, Pass, Sample, Sink};
use super::weighting::{Loss, WeightedRow, Weighting};
use crate::algebra::disparity_noise::BiasedEquations;
use crate::algebra::moments::{COORDINATES, Moments};
use crate::algebra::normal_equations::NormalEquations;
use crate::batch::Matches;
use crate::batch::row_offset::DIFFERENCE_VARIANCE;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Single, Value};
use crate::thresholds::{
    CLEAR_PEAK_DEVIATIONS, FOUND_NEAR, FOUND_NEAR_MOST, FOUND_NOISE_PX, MIN_WEIGHTED,
    PEAK_DEVIATIONS, PEAK_OVER_BESIDE, TRACK_MIN_NEAR, TRACK_PEAK,
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

/// Parameters of an evaluation: weighting at the pose, and the start.
#[derive(Debug, Clone, Copy)]
struct EvaluationContext<V> {
    by: Weighting<V>,
    start: PoseTerms<V>,
}

/// Sums of an evaluation other than moments, halves and statistics.
#[derive(Debug, Clone, Copy)]
struct EvaluationSums<T> {
    /// Gradient with the derivative of `V`, 1/rad.
    gradient: Vector5<T>,
    /// Sums of the weights, 1/px^2, and of the weights times the variance of a coordinate.
    weights: [T; 2],
}

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
        matches: Matches<'_, T>,
        evaluated: &mut EvaluatedPose<T>,
    ) -> Result<(), Rejection> {
        let EvaluationSums { gradient, weights } = self.sum(matches, evaluated);
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
        stats.skipped =
            T::count(u32::try_from(matches.pairs.len()).unwrap_or(u32::MAX)) - stats.usable;
        self.check(stats.usable)?;
        if moments.is_finite() && noise.is_finite() { Ok(()) } else { Err(Rejection::Unobservable) }
    }

    fn sum(&self, matches: Matches<'_, T>, evaluated: &mut EvaluatedPose<T>) -> EvaluationSums<T> {
        let sums = EvaluationSums { gradient: Vector5::zeros(), weights: [T::ZERO; 2] };
        let mut pass = EvaluationPass { iterate: self, evaluated, sums };
        sweep::run(&mut pass, matches, Part::All);
        pass.sums
    }
}

/// The pass of an evaluation.
struct EvaluationPass<'a, T: Scalar> {
    iterate: &'a Iterate<T>,
    evaluated: &'a mut EvaluatedPose<T>,
    sums: EvaluationSums<T>,
}

impl<T: Scalar> Pass<T> for EvaluationPass<'_, T> {
    /// 45 moments a correspondence exceed the baseline vector registers.
    const QUADS: bool = false;

    #[inline(always)]
    fn sweep<L: Lanes<T>>(&mut self, lanes: L, source: impl Iterator<Item = Sample<L::Value>>) {
        let zero = lanes.splat(T::ZERO);
        let context = sweep::in_memory(lanes, EvaluationContext::of(lanes, self.iterate));
        let PairMeasurement { moments, halves, .. } = &mut self.evaluated.measurement;
        let mut stats = ResidualStats::none(zero);
        let mut weights = [zero; 2];
        let mut sums = HalfSums::resume(lanes, moments, halves, &self.sums.gradient);
        let mut sink = EvaluationSink {
            context: &context,
            stats: &mut stats,
            weights: &mut weights,
            sums: &mut sums,
        };
        sweep::sweep(lanes, source, &mut sink);
        sums.store(lanes, moments, halves, &mut self.sums.gradient);
        stats.reduce_onto(lanes, &mut self.evaluated.stats);
        for (to, sum) in self.sums.weights.iter_mut().zip(weights) {
            *to += lanes.reduce(sum);
        }
    }

    /// Adds to the moments in place: saves 200 bytes of stack.
    #[inline(always)]
    fn sweep_single(&mut self, source: impl Iterator<Item = Sample<T>>) {
        let context = EvaluationContext::of(Single, self.iterate);
        let EvaluatedPose { measurement, stats, .. } = &mut *self.evaluated;
        // As locals: in place each would be stored twice, here and beside the registers.
        let (mut own_stats, mut weights) = (*stats, self.sums.weights);
        let mut sums = QuadrantSums {
            products: measurement.moments.products_mut(),
            quadrants: [[NormalEquations::ZERO; 2]; 2],
        };
        let mut sink = EvaluationSink {
            context: &context,
            stats: &mut own_stats,
            weights: &mut weights,
            sums: &mut sums,
        };
        sweep::sweep_gathered(source, &mut sink);
        let quadrants = sums.quadrants;
        (*stats, self.sums.weights) = (own_stats, weights);
        let [[upper_left, upper_right], [lower_left, _]] = &quadrants;
        let [left_half, upper_half] = &mut measurement.halves;
        left_half.add(&upper_left.plus(lower_left));
        upper_half.add(&upper_left.plus(upper_right));
        let gradients = quadrants.as_flattened().iter().map(|quadrant| quadrant.gradient);
        self.sums.gradient += gradients.sum::<Vector5<T>>();
    }
}

impl<V: Value> EvaluationContext<V> {
    /// Parameters at an iterate, the same in every lane.
    #[inline(always)]
    fn of<T: Scalar, L: Lanes<T, Value = V>>(lanes: L, iterate: &Iterate<T>) -> Self {
        let by = iterate.weighting(lanes, Loss::Polish);
        Self { by, start: PoseTerms::at(lanes, &iterate.start) }
    }
}

/// Sums of an evaluation in lanes.
struct EvaluationSink<'a, T: Scalar, L: Lanes<T>, S> {
    context: &'a EvaluationContext<L::Value>,
    stats: &'a mut ResidualStats<L::Value>,
    weights: &'a mut [L::Value; 2],
    sums: &'a mut S,
}

impl<T: Scalar, L: Lanes<T>, S: EvaluatedSums<T, L>> Sink<T, L> for EvaluationSink<'_, T, L, S> {
    type Row = EvaluatedRow<L::Value>;

    #[inline(always)]
    fn row(&mut self, lanes: L, (rays, grid_step): Sample<L::Value>) -> Option<Self::Row> {
        let EvaluationContext { by, start } = self.context;
        let (constraint, in_front) = Constraint::of(lanes, &by.pose, rays);
        if !lanes.any(in_front) {
            return None;
        }
        let (at_start, in_front_before) = Constraint::of(lanes, start, rays);
        let expected = ResidualVariance::of(lanes, by.noise_squared, grid_step);
        let (value, offset) = (constraint.value, constraint.row_offset());
        let precision = by.precision(lanes, &constraint, in_front);
        let squared = value * value * precision;
        let disparity = constraint.disparity_over(by.min_disparity);
        self.stats.count(lanes, in_front, [value, squared], disparity, &expected);
        let limit = expected.limit_squared(by.tukey_squared);
        let compared = Compared {
            before: at_start.row_offset() * at_start.row_offset(),
            after: offset * offset,
            in_front_before,
            most: lanes.splat(T::lit(DIFFERENCE_VARIANCE)) * limit * by.unit_squared,
            fit: lanes.ge(limit, squared),
        };
        self.stats.compare(lanes, in_front, &compared);
        let ahead = lanes.and(in_front, constraint.has_disparity(lanes, by.min_disparity));
        let w = lanes.keep(ahead, expected.tukey(lanes, by.tukey_squared, squared).0);
        if !lanes.any(lanes.lt(lanes.splat(T::ZERO), w)) {
            return None;
        }
        let ratio = value * precision * by.unit_squared;
        let jacobian = constraint.whitened_jacobian(lanes, &by.pose, ratio);
        let w = match &by.leverage {
            Some(leverage) => {
                let limited = leverage.factor(lanes, w * precision, &jacobian);
                let is_separate = leverage.is_separate(lanes, limited.share);
                if lanes.any(is_separate) {
                    let bands = &mut self.stats.high_leverage;
                    expected.count_bands(lanes, is_separate, squared, bands);
                }
                w * limited.factor
            }
            None => w,
        };
        let [sum, variances] = &mut *self.weights;
        *sum = *sum + w;
        *variances = lanes.mul_add(w, expected.variance, *variances);
        let row = WeightedRow { weight: w * precision, value, jacobian };
        let [x, y, ..] = rays;
        Some(EvaluatedRow {
            row,
            products: constraint.coordinates(lanes, &by.pose, rays),
            at: [x, y],
        })
    }

    #[inline(always)]
    fn none(lanes: L) -> Self::Row {
        let zero = lanes.splat(T::ZERO);
        EvaluatedRow { row: WeightedRow::none(lanes), products: [zero; COORDINATES], at: [zero; 2] }
    }

    #[inline(always)]
    fn add(&mut self, lanes: L, rows: &[Self::Row]) {
        self.sums.add(lanes, rows);
    }

    #[inline(always)]
    fn add_one(&mut self, lanes: L, row: Self::Row) {
        self.sums.add(lanes, slice::from_ref(&row));
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
        stats: ResidualStats::none(T::ZERO),
    };

    /// Whether a pose found by a search is an optimum: residuals form a peak at zero. Outliers alone have as many
    /// within 2 units as from 2 to 4, and let the noise grow: the wider the peak, the more of them it must hold.
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
            && self.stats.exceeds_background(PEAK_DEVIATIONS)
            && noise < T::lit(FOUND_NOISE_PX)
            && self.is_largest_crowd()
    }

    /// Why residuals that form a peak are not those of a scene.
    ///
    /// * `needed`: near residuals, by configuration.
    pub(crate) fn no_scene(&self, needed: u16) -> Option<Rejection> {
        let forms_peak = self.stats.near() >= T::count(needed.into())
            && self.stats.exceeds_background(PEAK_DEVIATIONS);
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

    /// Whether no more matches agree on a pose rows away: a pose of few is that of a fence. Of none it is no pose.
    fn is_largest_crowd(&self) -> bool {
        let PairMeasurement { crowd, inlier_share, .. } = self.measurement;
        inlier_share > T::ZERO && crowd.abs() <= inlier_share
    }

    /// Whether that peak exceeds chance, at a pose that is not yet confirmed.
    pub(crate) fn has_clear_peak(&self) -> bool {
        self.stats.exceeds_background(CLEAR_PEAK_DEVIATIONS)
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
#[cfg(feature = "simd")]
mod simd_tests;
#[cfg(test)]
mod tests;
