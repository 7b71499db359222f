//! The calibration in use and the estimate over the last pair, in detail, and the expected depth error.

use stereo_selfcal::State;
use stereo_selfcal::outcome::Details;

use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::instance::{Instance, selfcal_t, shared};
use crate::pointer::Out;

/// The calibration in use and the estimate over the matches of the last pair, for logs. Both RMS values are over the
/// matches that fit the estimate.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_details_t {
    /// RMS row offset of the extrinsics in use, px; 0 is perfect.
    pub in_use_px: f32,
    /// RMS row offset of the proposed extrinsics, px.
    pub proposed_px: f32,
    /// RMS difference between the row offsets in use and proposed, px: the error of the extrinsics in use, without
    /// noise and vibration.
    pub off_px: f32,
    /// Matches that fit the extrinsics in use.
    pub fit_in_use: u32,
    /// Matches that fit the proposed extrinsics.
    pub fit_proposed: u32,
    /// Expected error of the yaw in use, rad.
    pub yaw_rad: f32,
    /// Row offset, px, that the apparent yaw of the lenses leaves in the image corner that is furthest from the
    /// principal point. Both RMS values exclude these row offsets.
    pub corner_px: f32,
    /// Number of readings of `selfcal_push_range` since the last reset that contradicted the yaw: they were refused, or
    /// had to wait for further readings that agree. Saturates.
    pub contradicting_ranges: u16,
    /// The same number for motions of `selfcal_push_motion` and `selfcal_push_tracks`.
    pub contradicting_motions: u16,
}

impl From<&Details<f32>> for selfcal_details_t {
    fn from(details: &Details<f32>) -> Self {
        Self {
            in_use_px: details.in_use_px,
            proposed_px: details.proposed_px,
            off_px: details.off_px,
            fit_in_use: details.fit_in_use,
            fit_proposed: details.fit_proposed,
            yaw_rad: details.yaw,
            corner_px: details.corner_px,
            contradicting_ranges: details.contradicting_ranges,
            contradicting_motions: details.contradicting_motions,
        }
    }
}

/// Compares the calibration in use with the estimate over the matches of the last pair, in one pass over the batch.
/// Call it before the next correspondence is pushed.
///
/// Without an estimate it returns `SELFCAL_ERROR_NO_ESTIMATE`, and without a match that fits the estimate
/// `SELFCAL_ERROR_NO_MATCH`; nothing is written then.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_details(
    cal: *const selfcal_t,
    details: *mut selfcal_details_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, place) = unsafe { (shared(cal)?, Out::checked(details)?) };
        place.set((&details_of(instance)?).into());
        Ok(())
    })
}

/// Writes the expected depth errors of the extrinsics in use at 1, 2, 5 and 10 m, in the middle of the image. Takes one
/// pass over the batch. The noise of the matcher and the error of the baseline length are not included. Returns
/// `SELFCAL_ERROR_NOT_LOCKED` if the estimate is not locked. It also has the errors of `selfcal_details`.
///
/// * `baseline_m`: length of the baseline, m; finite and above 0.
/// * `errors`: expected depth errors, m.
///
/// cbindgen:ptrs-as-arrays=[[errors; 4]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_depth_errors(
    cal: *const selfcal_t,
    baseline_m: f32,
    errors: *mut f32,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::<[f32; 4]>::checked(errors.cast())?) };
        if !(baseline_m > 0.0 && baseline_m.is_finite()) {
            return Err(SELFCAL_ERROR_VALUE);
        }
        let found = details_of(instance)?.depth_errors(baseline_m);
        if instance.calibrator.state() != State::Locked {
            return Err(SELFCAL_ERROR_NOT_LOCKED);
        }
        out.set(found);
        Ok(())
    })
}

fn details_of(instance: &Instance) -> Result<Details<f32>, selfcal_error_t> {
    let found = instance.calibrator.details();
    found.ok_or_else(|| match instance.calibrator.proposal() {
        Some(_) => SELFCAL_ERROR_NO_MATCH,
        None => SELFCAL_ERROR_NO_ESTIMATE,
    })
}
