//! Whether a pair's result may enter the fusion: the limits of what is believed at all.

use crate::config::Config;
use crate::error::Refusal;
use crate::extrinsics::Extrinsics;
use crate::metrics::{baseline_angle, rotation_angle};
use crate::report::PairReport;
use crate::scalar::Scalar;

/// Admits a report that is finite, certain enough, and within the correction limit.
///
/// * `factory`: the extrinsics that corrections are measured from.
///
/// # Errors
/// [`Refusal`].
pub(crate) fn admit<T: Scalar>(
    config: &Config,
    factory: &Extrinsics<T>,
    report: &PairReport<T>,
) -> Result<(), Refusal> {
    if !report.information.is_finite() {
        return Err(Refusal::NotFinite);
    }
    let (sd, _) = report.information.weakest().ok_or(Refusal::TooUncertain)?;
    // Not `>`: a NaN must not pass.
    if !(sd <= T::single(config.max_sd_rad)) {
        return Err(Refusal::TooUncertain);
    }
    within_correction_limit(config, factory, &report.extrinsics)
}

/// Whether extrinsics are within the correction limit of the factory's.
///
/// # Errors
/// [`Refusal::CorrectionLimit`].
#[inline(never)]
pub(crate) fn within_correction_limit<T: Scalar>(
    config: &Config,
    factory: &Extrinsics<T>,
    found: &Extrinsics<T>,
) -> Result<(), Refusal> {
    let limit = T::single(config.max_correction_rad);
    if baseline_angle(found.translation(), factory.translation()) <= limit
        && rotation_angle(found.rotation(), factory.rotation()) <= limit
    {
        Ok(())
    } else {
        Err(Refusal::CorrectionLimit)
    }
}
