//! Range of a lens model: sane coefficients, and where its distortion folds back.

use crate::error::CameraError;
use crate::scalar::Scalar;
use crate::thresholds::{FOLD_BISECTIONS, FOLD_SAMPLES, MAX_DISTORTION};

/// Refuses coefficients that are not finite or above 1e3 in size.
pub(super) fn check<T: Scalar>(coefficients: &[T]) -> Result<(), CameraError> {
    let sane = |k: &T| k.abs() <= T::lit(MAX_DISTORTION);
    if coefficients.iter().all(sane) { Ok(()) } else { Err(CameraError::Distortion) }
}

/// Smallest argument in `0..=limit` at which `slope` is not positive, or `limit`.
///
/// Cost: 256 samples, then 30 bisections. A dip narrower than 1/256 of the range stays undetected.
pub(super) fn first_fold<T: Scalar>(slope: impl Fn(T) -> T, limit: T) -> T {
    let at = |i: u32| limit * (T::count(i) / T::count(FOLD_SAMPLES));
    let folded = |x: T| !(slope(x) > T::ZERO);
    let Some(first) = (1..=FOLD_SAMPLES).find(|&i| folded(at(i))) else {
        return limit;
    };
    let (mut low, mut high) = (at(first.saturating_sub(1)), at(first));
    for _ in 0..FOLD_BISECTIONS {
        let middle = (low + high) * T::HALF;
        if folded(middle) { high = middle } else { low = middle }
    }
    low
}
