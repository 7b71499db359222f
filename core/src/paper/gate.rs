//! Gate of the published method: it decides which pairs enter the mean.

use crate::config::Context;
use crate::error::Rejection;
use crate::outcome::pair_report::PairReport;
use crate::scalar::Scalar;

/// Admits a pair that is certain enough and within the correction limit.
///
/// # Errors
/// [`Rejection::TooUncertain`], [`Rejection::CorrectionLimit`].
pub(super) fn admit<T: Scalar>(
    context: &Context<'_, T>,
    report: &PairReport<T>,
) -> Result<(), Rejection> {
    let (sd, _) = report.information.weakest().ok_or(Rejection::TooUncertain)?;
    // The negated form refuses NaN.
    if !(sd <= T::single(context.config.paper.max_sd_rad)) {
        return Err(Rejection::TooUncertain);
    }
    if context.allows(&report.extrinsics) { Ok(()) } else { Err(Rejection::CorrectionLimit) }
}
