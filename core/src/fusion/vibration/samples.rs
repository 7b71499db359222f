//! The latest estimates of one variance, and the decision whether the rig vibrates (`ESTIMATOR.md`, section 14).

use crate::scalar::Scalar;
use crate::thresholds::{
    MAX_VIBRATION_RAD, MIN_VIBRATION_SAMPLES, VIBRATION_CLIP, VIBRATION_DEVIATIONS,
    VIBRATION_HYSTERESIS, VIBRATION_RAD, VIBRATION_RATIO,
};

/// Number of samples of the median, as a size of arrays and for comparison with counts.
pub(super) const SAMPLES: usize = 11;
pub(super) const RING: u32 = 11;

/// Standard deviation of the median of normal numbers over the standard deviation of their mean.
const MEDIAN_DEVIATION: f64 = 1.2533;

/// Largest bias of a sample for each unit by which the scatter exceeds 1, in standard deviations of a sample:
/// `sqrt(n / 2)` for `n` unknowns, here for 3. The bias is `tr S^-1 / (k tr S^-2)`, and `tr(S^-1)^2 <= n tr S^-2`.
const MOST_BIAS: f64 = 1.2247;

/// Estimates of a variance from one distance, rad^2. By chance they may be negative.
pub(super) struct Sample<T> {
    /// Estimate whose median is the variance.
    pub(super) median: T,
    /// Estimate whose mean is the variance.
    pub(super) mean: T,
    /// Standard deviation of an estimate for the current variance.
    pub(super) spread: T,
    /// Standard deviation of an estimate for a rigid rig.
    pub(super) deviation: T,
}

/// Returns the largest variance of a vibration, rad^2.
pub(super) fn most<T: Scalar>() -> T {
    T::lit(MAX_VIBRATION_RAD * MAX_VIBRATION_RAD)
}

/// The latest estimates of one variance from one kind of distance, newest first.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples<T> {
    /// Estimates, rad^2. By chance they may be negative.
    pub(super) values: [T; SAMPLES],
    /// Running mean of the standard deviation of an estimate for a rigid rig, rad^2.
    pub(super) deviation: T,
    /// Running mean of the clipped estimates, over more pairs than `values`, rad^2.
    pub(super) mean: T,
}

impl<T: Scalar> Samples<T> {
    pub(super) const NONE: Self =
        Self { values: [T::ZERO; SAMPLES], deviation: T::ZERO, mean: T::ZERO };

    /// Adds an estimate.
    ///
    /// * `count`: number of samples, including this one.
    pub(super) fn add(
        &mut self,
        Sample { median, mean, spread, deviation }: Sample<T>,
        count: u32,
    ) {
        // Moves the values one by one, because `rotate_right` would link `memmove`.
        self.values.iter_mut().fold(median, |newer, value| core::mem::replace(value, newer));
        self.deviation += (deviation - self.deviation) / T::count(count.clamp(1, RING));
        let [median, _] = self.median(newest(count));
        // The limit clips the contribution of a knock.
        let largest = (median.max(T::ZERO) + spread) * T::lit(VIBRATION_CLIP);
        self.mean += (mean.min(largest) - self.mean) / T::count(count.max(1));
        // A mean below 1/4 or above 16 times the median is stale, and restarts at the median. The upper limit is wider,
        // because medians of a few samples are more often too low than too high.
        let ratio = T::lit(VIBRATION_RATIO);
        if !(self.mean > median / ratio && self.mean < median * ratio * ratio) {
            self.mean = median.max(T::ZERO);
        }
    }

    /// Returns the median of the newest samples, and its standard deviation for a rigid rig, rad^2.
    fn median(&self, newest: usize) -> [T; 2] {
        let mut sorted = self.values;
        let Some(part) = sorted.get_mut(..newest) else { return [T::ZERO; 2] };
        sort(part);
        let at = |k: usize| part.get(k).copied().unwrap_or(T::ZERO);
        let median = (at(newest.saturating_sub(1) / 2) + at(newest / 2)) * T::HALF;
        let n = T::count(u32::try_from(newest.max(1)).unwrap_or(1));
        [median, self.deviation * T::lit(MEDIAN_DEVIATION) / n.sqrt()]
    }

    /// Returns the variance, rad^2; 0 if no vibration is detected.
    ///
    /// * `count`: number of samples; `before`: previous variance, rad^2. If it is above 0, the threshold is lower.
    /// * `scatter`: ratio of the observed variance of the pairs to their covariance, dimensionless.
    pub(super) fn variance(&self, count: u32, before: T, scatter: T) -> T {
        let count = newest(count);
        if count < MIN_VIBRATION_SAMPLES {
            return T::ZERO;
        }
        let ease = if before > T::ZERO { VIBRATION_HYSTERESIS } else { 1.0 };
        let [median, deviation] = self.median(count);
        let unbiased = median - (scatter - T::ONE) * self.deviation * T::lit(MOST_BIAS);
        let least = (T::lit(VIBRATION_DEVIATIONS) * deviation * scatter)
            .max(T::lit(VIBRATION_RAD * VIBRATION_RAD));
        if unbiased > least * T::lit(ease) { self.mean.min(most()) } else { T::ZERO }
    }
}

/// Returns the number of samples that are stored.
fn newest(count: u32) -> usize {
    usize::try_from(count).unwrap_or(SAMPLES).min(SAMPLES)
}

/// Sorts in ascending order by insertion, because the sort of the standard library can panic.
pub(super) fn sort<T: Scalar>(values: &mut [T]) {
    for end in 2..=values.len() {
        let mut rest = values.get_mut(..end).unwrap_or_default();
        while let [_, .., _] = rest {
            let Some((last, before)) = rest.split_last_mut() else { return };
            match before.last_mut() {
                Some(previous) if *last < *previous => core::mem::swap(last, previous),
                _ => break,
            }
            rest = before;
        }
    }
}
