//! Gate of the published method: it decides which pairs enter the mean.

use super::Settings;
use crate::error::Rejection;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::metrics::{baseline_angle, rotation_angle};
use crate::outcome::pair_report::PairReport;
use crate::scalar::Scalar;

/// Admits a pair that is certain enough and within the correction limit.
///
/// # Errors
/// [`Rejection::TooUncertain`], [`Rejection::CorrectionLimit`].
pub(super) fn admit<T: Scalar>(
    settings: &Settings,
    start: &Extrinsics<T>,
    report: &PairReport<T>,
) -> Result<(), Rejection> {
    let (sd, _) = report.information.weakest().ok_or(Rejection::TooUncertain)?;
    // The negated form refuses NaN.
    if !(sd <= T::single(settings.max_sd_rad)) {
        return Err(Rejection::TooUncertain);
    }
    limit(settings, start, &report.extrinsics)
}

/// Admits extrinsics within the correction limit of the start.
///
/// # Errors
/// [`Rejection::CorrectionLimit`].
pub(super) fn limit<T: Scalar>(
    settings: &Settings,
    start: &Extrinsics<T>,
    found: &Extrinsics<T>,
) -> Result<(), Rejection> {
    let most = T::single(settings.max_correction_rad);
    let is_within = baseline_angle(found.translation(), start.translation()) <= most
        && rotation_angle(found.rotation(), start.rotation()) <= most;
    if is_within { Ok(()) } else { Err(Rejection::CorrectionLimit) }
}
