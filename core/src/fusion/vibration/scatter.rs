//! Scatter of the optima of pairs beyond their covariances, which errors of lens and matcher cause (`ESTIMATOR.md`,
//! section 14).

use nalgebra::Vector5;

use crate::algebra::symmetric5::Symmetric5;
use crate::scalar::Scalar;
use crate::thresholds::{AVERAGED_PAIRS, CHI_SQUARE_PAIRS, MAX_REDUCED_CHI_SQUARE};

/// Expected distance of the least of five standard normal numbers from their mean.
const LEAST_OF_FIVE: f64 = 1.163;

/// Running means, for each unknown, of the squared difference of successive optima over its variance.
///
/// Scatter raises all of them by about the same factor. Vibration raises the ratio of the worst determined unknown
/// least. So the least ratio measures the scatter.
#[derive(Debug, Clone)]
pub(super) struct Scatter<T> {
    ratios: [T; 5],
    /// Number of differences, at most [`AVERAGED_PAIRS`].
    differences: u32,
}

impl<T: Scalar> Scatter<T> {
    /// No difference yet.
    pub(super) const NONE: Self = Self { ratios: [T::ONE; 5], differences: 0 };

    /// Adds a difference of successive optima, rad, with its covariance, rad^2.
    pub(super) fn add(&mut self, d: &Vector5<T>, covariance: &Symmetric5<T>) {
        self.differences = self.differences.saturating_add(1).min(AVERAGED_PAIRS);
        let weight = self.weight();
        let each = self.ratios.iter_mut().zip(d.iter()).zip(covariance.diagonal());
        for ((mean, d), variance) in each {
            let ratio = *d * *d / variance;
            if ratio >= T::ZERO {
                *mean += (ratio.min(T::lit(MAX_REDUCED_CHI_SQUARE)) - *mean) / weight;
            }
        }
    }

    /// Returns the ratio of the observed variance of the optima to the variance that their covariances predict, at
    /// least 1, dimensionless.
    pub(super) fn ratio(&self) -> T {
        let least = self.ratios.into_iter().fold(T::lit(MAX_REDUCED_CHI_SQUARE), T::min);
        // Each mean has the relative standard deviation `sqrt(2 / weight)`.
        let low = T::ONE - T::lit(LEAST_OF_FIVE) * (T::lit(2.0) / self.weight()).sqrt();
        (least / low).max(T::ONE)
    }

    /// Returns the number of differences in the means. [`CHI_SQUARE_PAIRS`] of them are not measured and have the
    /// expected ratio 1.
    fn weight(&self) -> T {
        T::count(self.differences) + T::lit(CHI_SQUARE_PAIRS)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_means_include_pairs_of_the_expected_ratio() {
        let mut scatter = Scatter::<f64>::NONE;
        let covariance = Symmetric5::of_diagonal([1.0, 2.0, 3.0, 4.0, 5.0]);
        // Nine times the variance that the covariance predicts.
        let d = Vector5::from(covariance.diagonal().map(|variance: f64| 3.0 * variance.sqrt()));
        for count in 1..=20 {
            scatter.add(&d, &covariance);
            let pairs = f64::from(count) + CHI_SQUARE_PAIRS;
            let mean = (f64::from(count) * 9.0 + CHI_SQUARE_PAIRS) / pairs;
            assert!(scatter.ratios.iter().all(|ratio| (ratio - mean).abs() < 1e-12), "{count}");
            let low = 1.0 - LEAST_OF_FIVE * (2.0 / pairs).sqrt();
            assert!((scatter.ratio() - mean / low).abs() < 1e-12, "{count}");
        }
    }
}
