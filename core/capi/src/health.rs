//! Health: quality of the calibration in use and of the estimate, for an arming check.

use stereo_selfcal::{Band, Cause, Health, NoHealth, Reasons};

use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::estimate::selfcal_state_t;
use crate::instance::{selfcal_t, shared};
use crate::pointer::Out;

c_enum! {
    /// Rating of the extrinsics in use. The estimate is clearly better if it lowers the RMS row offset over all pairs
    /// by a tenth and by more than chance, or if the row offsets in use and proposed differ by 1 px RMS or more. In the
    /// paper preset, and while one of them belongs to other cameras than the rays of the pairs, a tenth over the
    /// matches of the last pair is enough.
    #[repr(u32)]
    pub enum selfcal_band_t {
        /// good
        ///
        /// The estimate is not clearly better.
        SELFCAL_BAND_GOOD = 16000,
        /// improvable
        ///
        /// The RMS row offset in use is below 1 px, and the estimate is clearly better.
        SELFCAL_BAND_IMPROVABLE = 16001,
        /// recalibrate
        ///
        /// The RMS row offset in use is 1 px or more, and the estimate is clearly better: a matcher that searches along
        /// rows will miss.
        SELFCAL_BAND_RECALIBRATE = 16002,
        /// unknown
        ///
        /// The matches cannot rate the calibration, because of the mistake in `cause`. Also a value that this API does
        /// not know.
        SELFCAL_BAND_UNKNOWN = 16255,
    }
}

from_core!(Band => selfcal_band_t from 16000, else SELFCAL_BAND_UNKNOWN);

c_enum! {
    /// One reason not to rely on a calibration: a bit of `reasons`.
    #[repr(u32)]
    pub enum selfcal_reason_t {
        /// estimate not locked
        ///
        /// The state is not locked: the estimate is not confirmed, the last pair disagrees with it, or a challenger
        /// gathers pairs. Forbids arming.
        SELFCAL_REASON_NOT_LOCKED = 0x1_0000,
        /// second crowd of matches
        ///
        /// Matches with residuals on one side of the inliers are nearly as many as the inliers, and may agree with a
        /// second calibration, for instance because of a fence or a reflection. Forbids arming, and nothing is applied
        /// until the view has changed.
        SELFCAL_REASON_SECOND_MODE = 0x4_0000,
        /// matches biased
        ///
        /// Image halves disagree by more than 5 standard deviations, and the lens models are taken as exact: the
        /// matches of an image region share a bias. Forbids arming, and nothing is applied.
        SELFCAL_REASON_BIASED = 0x200_0000,
        /// matches do not support it
        ///
        /// The matches or the estimate show a mistake in rig file or matcher, which `cause` names. Forbids arming.
        SELFCAL_REASON_UNFIT = 0x100_0000,
        /// in use off by 1 px or more
        ///
        /// The row offsets in use and of the estimate differ by 1 px RMS or more. Forbids arming.
        SELFCAL_REASON_MISALIGNED = 0x2_0000,
        /// image halves disagree
        ///
        /// Image halves disagree by more than 3 standard deviations; the reported deviations include this disagreement.
        SELFCAL_REASON_IMAGE_HALVES = 0x8_0000,
        /// lens models off
        ///
        /// The pairs show an error of the lens models or an apparent yaw of the lenses; `sd_lens` of the proposal
        /// includes it.
        SELFCAL_REASON_LENS = 0x10_0000,
        /// baseline not observed
        ///
        /// The pairs have not determined the baseline direction: as a rule the baseline in use is kept; see
        /// `applicable` of the proposal.
        SELFCAL_REASON_BASELINE = 0x20_0000,
        /// repeated scene
        ///
        /// The last pair showed the same scene as the pair fused before it, and adds no evidence.
        SELFCAL_REASON_REPEATED = 0x40_0000,
        /// axis of the rotation is noise
        ///
        /// Paper preset: the rotation is so close to the identity or to a half turn that its axis is noise, or the
        /// pairs do not agree on an axis.
        SELFCAL_REASON_AXIS = 0x80_0000,
        /// yaw not confirmed
        ///
        /// The standard deviation of the apparent yaw of the lens is above 0.1 degrees: neither the factory calibration
        /// nor witnesses separate it well enough from the yaw of the mount. The deviations of yaw and depth include
        /// both.
        SELFCAL_REASON_YAW = 0x1000_0000,
    }
}

/// Returns the sum of the `selfcal_reason_t` of a set.
pub(crate) fn bits(reasons: Reasons) -> u32 {
    u32::from(reasons.bits()) << 16
}

c_enum! {
    /// A mistake that keeps pairs from agreeing, or their matches from supporting a calibration.
    #[repr(u32)]
    pub enum selfcal_cause_t {
        /// none
        ///
        /// No mistake is known.
        SELFCAL_CAUSE_NONE = 18000,
        /// left and right exchanged, t of the other sign, one image mirrored, or both upside down
        ///
        /// The points are behind the cameras.
        SELFCAL_CAUSE_REVERSED = 18001,
        /// cameras one above the other, or t of the factory extrinsics turned
        ///
        /// Disparities run along the columns, and nothing shows that u and v are exchanged.
        SELFCAL_CAUSE_UPRIGHT = 18002,
        /// u and v exchanged
        ///
        /// Disparities run along the columns, some pixels were refused, and all accepted matches are within the square
        /// that an image and its transpose have in common.
        SELFCAL_CAUSE_TRANSPOSED = 18003,
        /// the same image on both sides
        ///
        /// Most matches have the same motion between the images, and nothing shows depth.
        SELFCAL_CAUSE_SAME_IMAGE = 18004,
        /// cameras of smaller images, or pixels from another origin than the upper left
        ///
        /// Most matches are refused, usually because a pixel is outside the images of the cameras.
        SELFCAL_CAUSE_SMALLER_IMAGES = 18005,
        /// cameras of larger images
        ///
        /// All matches of all pairs are in the upper left quarter of the left image.
        SELFCAL_CAUSE_LARGER_IMAGES = 18006,
        /// focal length or lens of another unit or image, such as mm
        ///
        /// Most matches are refused, usually because a pixel has no ray.
        SELFCAL_CAUSE_FOCAL_LENGTH = 18007,
        /// another lens, or points that are undistorted already
        ///
        /// Pairs show an error of the lens models that is too large for any calibration.
        SELFCAL_CAUSE_LENS = 18008,
        /// matches that agree on nothing
        ///
        /// No other cause explains the pairs without agreement.
        SELFCAL_CAUSE_MISMATCHES = 18009,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_CAUSE_UNKNOWN = 18255,
    }
}

from_core!(Cause => selfcal_cause_t from 18000, else SELFCAL_CAUSE_UNKNOWN);

impl From<Option<Cause>> for selfcal_cause_t {
    fn from(cause: Option<Cause>) -> Self {
        cause.map_or(Self::SELFCAL_CAUSE_NONE, Into::into)
    }
}

/// Quality of the calibration in use and of the estimate, over the matches of the last pair. Both RMS values are over
/// the matches that fit the estimate.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_health_t {
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
    /// Share of the cells with a match that fits the estimate, 0 to 1, in an 8 x 6 grid over the left image.
    pub coverage: f32,
    /// Rating of the extrinsics in use.
    pub band: selfcal_band_t,
    /// State of the estimate.
    pub state: selfcal_state_t,
    /// Expected error of the yaw in use, rad.
    pub yaw_rad: f32,
    /// Row offset, px, that the apparent yaw of the lenses leaves in the image corner that is furthest from the
    /// principal point. Both RMS values exclude these row offsets.
    pub corner_px: f32,
    /// Why the last pair was not fused; `SELFCAL_OK` if it was, and while a pair is being solved.
    pub rejection: selfcal_error_t,
    /// Answer to an arming check; `reasons` says why it is false. Vibration increases both RMS values, but does not
    /// count in this check.
    pub may_arm: bool,
    /// Reasons not to rely on the calibration in use: sum of `selfcal_reason_t`.
    pub reasons: u32,
    /// The likeliest mistake in rig file or matcher that the pairs, the matches or the estimate show.
    pub cause: selfcal_cause_t,
    /// Number of readings of `selfcal_push_range` since the last reset that contradicted the yaw: they were refused, or
    /// had to wait for further readings that agree. Saturates.
    pub contradicting_ranges: u16,
    /// The same number for motions of `selfcal_push_motion` and `selfcal_push_tracks`.
    pub contradicting_motions: u16,
}

impl From<&Health<f32>> for selfcal_health_t {
    fn from(health: &Health<f32>) -> Self {
        Self {
            in_use_px: health.in_use_px,
            proposed_px: health.proposed_px,
            off_px: health.off_px,
            fit_in_use: health.fit_in_use,
            fit_proposed: health.fit_proposed,
            coverage: health.coverage,
            band: health.band.into(),
            state: health.state.into(),
            yaw_rad: health.yaw,
            corner_px: health.corner_px,
            rejection: health.rejection.map_or(SELFCAL_OK, Into::into),
            may_arm: health.may_arm(),
            reasons: bits(health.reasons),
            cause: health.cause.into(),
            contradicting_ranges: health.contradicting_ranges,
            contradicting_motions: health.contradicting_motions,
        }
    }
}

/// Compares the calibration in use with the estimate over the matches of the last pair, in one pass over the batch.
/// Call it before the next correspondence is pushed.
///
/// Without an estimate it returns `SELFCAL_ERROR_NO_ESTIMATE`, and without a match that fits the estimate
/// `SELFCAL_ERROR_NO_MATCH`.
///
/// * `cause`: the likeliest mistake in rig file or matcher, also written with these two errors; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_health(
    cal: *const selfcal_t,
    health: *mut selfcal_health_t,
    cause: *mut selfcal_cause_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, place, cause) =
            unsafe { (shared(cal)?, Out::checked(health)?, Out::optional(cause)?) };
        let health = instance.calibrator.health();
        cause.set(health.as_ref().map_or_else(NoHealth::cause, |health| health.cause).into());
        place.set((&health?).into());
        Ok(())
    })
}

/// Writes the expected depth errors of the extrinsics in use at 1, 2, 5 and 10 m, in the middle of the image. Takes one
/// pass over the batch. The noise of the matcher and the error of the baseline length are not included. Returns
/// `SELFCAL_ERROR_NOT_LOCKED` if the estimate is not locked. It also has the errors of `selfcal_health`.
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
        let found = instance.calibrator.health()?.depth_errors(baseline_m);
        out.set(found.ok_or(SELFCAL_ERROR_NOT_LOCKED)?);
        Ok(())
    })
}
