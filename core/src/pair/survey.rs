//! Survey: typical leverage in a sample of the batch, before the first step of a track.

use super::constraint::Constraint;
use super::leverage::{Leverage, baseline_block, share};
use super::loss::{ResidualVariance, geman_mcclure};
use super::weighting::{Weighting, tracked};
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::simd::Single;

/// Limit from the mean root of the shares, which outliers hardly move; `None` where it is not finite.
///
/// * `by`: weighting at the start; `covariance`: of the pose, rad^2.
pub(super) fn survey<'a, T: Scalar>(
    by: &Weighting<T>,
    sample: impl Iterator<Item = &'a RayPair<T>>,
    covariance: &Symmetric5<T>,
) -> Option<Leverage<T>> {
    let block = baseline_block(covariance);
    let [mut roots, mut weighted] = [T::ZERO; 2];
    for pair in sample {
        let (constraint, in_front) = Constraint::of(Single, &by.pose, pair.rays());
        if !in_front || !constraint.has_disparity(Single, by.min_disparity) {
            continue;
        }
        let precision = by.focal_squared / constraint.variance;
        let expected = ResidualVariance::of(Single, by.noise_squared, pair.grid_step());
        let x = tracked(Single, &covariance.0, &constraint, precision, &expected);
        let w = geman_mcclure(Single, x) / expected.variance;
        roots += share(Single, &block, w * precision, &constraint.jacobian).sqrt();
        weighted += T::ONE;
    }
    Leverage::first(roots / weighted.max(T::ONE), covariance)
}
