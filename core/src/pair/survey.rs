//! Survey of a sample of the batch before the first step: typical leverage for a track, typical residual for a search.

use super::constraint::Constraint;
use super::leverage::{Leverage, baseline_block, share};
use super::loss::geman_mcclure;
use super::weighting::{Weighting, tracked};
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::thresholds::{FIRST_SCALE_MEDIANS, SURVEYED, WIDE_SCALE_PX};

/// Multiplier of a pseudo-random generator modulo 2^32 (Steele and Vigna, arXiv 2001.05304).
const MULTIPLIER: u32 = 0xE817_FB2D;

/// Pseudo-random number generator with a fixed seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Random(u32);

impl Random {
    pub(super) const NEW: Self = Self(1);

    /// Returns a number below `n`; `None` if `n` is 0.
    ///
    /// * `n`: at most 2^16.
    pub(super) fn below(&mut self, n: usize) -> Option<usize> {
        self.0 = self.0.wrapping_mul(MULTIPLIER);
        // Scales the high 16 bits from `0..2^16` to `0..n`. The low bits are not used, because their periods are short.
        let place = (self.0 >> 16).checked_mul(u32::try_from(n).ok()?)? >> 16;
        usize::try_from(place).ok().filter(|place| *place < n)
    }
}

/// Returns the sample of a survey: one value from each of at most [`SURVEYED`] equal parts.
pub(super) fn scattered<T>(all: &[T]) -> impl Iterator<Item = &T> {
    scattered_over(all, SURVEYED)
}

/// Returns one value from each of at most `most` parts of equal length; the last part may be shorter. The place within
/// a part is pseudo-random, but the same for all slices of one length. With a fixed place, the sample could consist of
/// outliers that recur at regular places.
pub(super) fn scattered_over<T>(all: &[T], most: usize) -> impl Iterator<Item = &T> {
    let stride = all.len().div_ceil(most).max(1);
    let mut random = Random::NEW;
    all.chunks(stride).filter_map(move |part| part.get(random.below(part.len())?))
}

/// Returns the limit on leverage from the median share of the sampled correspondences within Tukey's limit. A mean
/// would follow outliers: in far scenes, the share of an outlier can be 20,000 times the median. `None` if the limit is
/// not finite, or if no sampled correspondence has both enough disparity and a residual within Tukey's limit.
///
/// * `by`: weighting at the start; `covariance`: covariance of the pose, rad^2.
pub(super) fn survey<'a, T: Scalar>(
    by: &Weighting<T>,
    sample: impl Iterator<Item = &'a RayPair<T>>,
    covariance: &Symmetric5<T>,
) -> Option<Leverage<T>> {
    let block = baseline_block(covariance);
    let mut shares = heapless::Vec::<T, SURVEYED>::new();
    for pair in sample {
        let constraint = Constraint::of(&by.pose, pair);
        let Some(constraint) = constraint.filter(|c| c.has_disparity(by.min_disparity)) else {
            continue;
        };
        let precision = by.precision(&constraint);
        let expected = by.expected(pair.grid_step());
        let x = tracked(covariance, by.tukey_squared, &constraint, precision, &expected);
        // Skips residuals beyond Tukey's limit: outliers, possibly the majority. The test is written so that a NaN
        // fails it.
        if !(x <= T::ONE) {
            continue;
        }
        let w = geman_mcclure(x) / expected.variance;
        // The vector has room for the whole sample.
        let _ = shares.push(share(&block, w * precision, &constraint.jacobian));
    }
    Leverage::first(median(&shares)?, covariance)
}

/// Returns the first scale of a search, px: twice the median residual of the sample at the start, but at least
/// [`WIDE_SCALE_PX`]. The median residual is mostly caused by the error of the start.
///
/// * `by`: weighting at the start.
pub(super) fn first_scale<'a, T: Scalar>(
    by: &Weighting<T>,
    sample: impl Iterator<Item = &'a RayPair<T>>,
) -> T {
    let mut squares = heapless::Vec::<T, SURVEYED>::new();
    for pair in sample {
        if let Some(constraint) = Constraint::of(&by.pose, pair) {
            // The vector has room for the whole sample.
            let _ = squares.push(constraint.value * constraint.value * by.precision(&constraint));
        }
    }
    let typical = median(&squares).unwrap_or(T::ZERO).sqrt();
    (T::lit(FIRST_SCALE_MEDIANS) * typical).max(T::lit(WIDE_SCALE_PX))
}

/// Returns the median; for an even number of values, the larger of the two middle ones. `NaN` ranks above all numbers.
/// `None` if the slice is empty or the median is NaN. The search by ranks needs little code, and its quadratic cost is
/// low for a few values.
#[inline(never)]
fn median<T: Scalar>(values: &[T]) -> Option<T> {
    let is_median = |value: &&T| {
        let below = values.iter().filter(|other| *other < *value).count();
        let up_to = values.iter().filter(|other| *other <= *value).count();
        (below..up_to).contains(&(values.len() / 2))
    };
    values.iter().find(is_median).copied()
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec::Vec;

    #[test]
    fn a_random_number_is_below_its_limit_and_none_is_below_zero() {
        let mut random = Random::NEW;
        assert_eq!(random.below(0), None);
        let mut counts = [0; 3];
        (0..3000).for_each(|_| counts[random.below(3).unwrap()] += 1);
        assert!(counts.iter().all(|n| (900..1100).contains(n)), "{counts:?}");
    }

    #[test]
    fn a_sample_has_one_value_of_each_part() {
        for length in 0..3000_usize {
            let all: Vec<usize> = (0..length).collect();
            let stride = length.div_ceil(SURVEYED).max(1);
            let parts = scattered(&all).map(|place| place / stride);
            assert!(parts.eq(0..length.div_ceil(stride)), "{length}");
        }
    }

    /// The limits on `percent` are so wide that a truly random sample passes, too.
    #[test]
    fn a_sample_follows_no_period() {
        for length in 33..1025_usize {
            let all: Vec<usize> = (0..length).collect();
            for period in 2..=16 {
                let mut counts = [0_usize; 16];
                scattered(&all).for_each(|place| counts[place % period] += 1);
                counts.sort_unstable_by(|a, b| b.cmp(a));
                // Outliers are at half of the residues modulo the period, at those that are most frequent in the
                // sample.
                let outliers: usize = counts[..period / 2].iter().sum();
                let percent = 100 * outliers / scattered(&all).count();
                assert!(percent < if period > 8 { 90 } else { 80 }, "{length} {period} {percent}");
            }
        }
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), Some(3.0));
        assert_eq!(median(&[1.0, 5.0, 5.0, 5.0]), Some(5.0));
        assert_eq!(median::<f32>(&[]), None);
        assert_eq!(median(&[f64::NAN; 3]), None);
    }
}
