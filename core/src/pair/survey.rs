//! Survey: typical leverage in a sample of the batch, before the first step of a track.

use super::constraint::Constraint;
use super::leverage::{Leverage, baseline_block, share};
use super::loss::{ResidualVariance, geman_mcclure};
use super::weighting::{Weighting, tracked};
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::simd::Single;
use crate::thresholds::SURVEYED;

/// Limit from the median share of those within the loss: in far scenes that of an outlier is 20,000 times as large.
/// `None` where it is not finite, or nothing is within the loss.
///
/// * `by`: weighting at the start; `covariance`: of the pose, rad^2.
pub(super) fn survey<'a, T: Scalar>(
    by: &Weighting<T>,
    sample: impl Iterator<Item = &'a RayPair<T>>,
    covariance: &Symmetric5<T>,
) -> Option<Leverage<T>> {
    let block = baseline_block(covariance);
    let mut shares = heapless::Vec::<T, SURVEYED>::new();
    for pair in sample {
        let (constraint, in_front) = Constraint::of(Single, &by.pose, pair.rays());
        if !in_front || !constraint.has_disparity(Single, by.min_disparity) {
            continue;
        }
        let precision = by.focal_squared / constraint.variance;
        let expected = ResidualVariance::of(Single, by.noise_squared, pair.grid_step());
        let x = tracked(Single, &covariance.0, &constraint, precision, &expected);
        // Beyond the loss: outliers, which may be most. Not `>`: a NaN must fail this test.
        if !(x <= T::ONE) {
            continue;
        }
        let w = geman_mcclure(Single, x) / expected.variance;
        // The sample is no larger.
        let _ = shares.push(share(Single, &block, w * precision, &constraint.jacobian));
    }
    Leverage::first(median(&shares)?, covariance)
}

/// The median, of an even number the larger one of the two; `None` of no values and where one is not a number. By ranks:
/// small code, and as many comparisons as the square of a few values.
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
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(&[3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&[4.0, 1.0, 3.0, 2.0]), Some(3.0));
        assert_eq!(median(&[1.0, 5.0, 5.0, 5.0]), Some(5.0));
        assert_eq!(median::<f32>(&[]), None);
        assert_eq!(median(&[f64::NAN; 3]), None);
    }
}
