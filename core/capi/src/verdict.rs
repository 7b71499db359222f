//! The verdict after a pair: rows, depth and coverage in use, and the answer to an arming check.

use stereo_selfcal::{Cause, Reasons, Verdict};

use crate::error::{selfcal_error_t, status};
use crate::estimate::selfcal_state_t;
use crate::instance::{selfcal_t, shared};
use crate::pointer::Out;

c_enum! {
    /// One reason not to rely on a calibration: a bit of `reasons`.
    #[repr(u32)]
    pub enum selfcal_reason_t {
        /// estimate not locked
        ///
        /// The state is not locked: the estimate is not confirmed, the last pair disagrees with it, or a challenger
        /// gathers pairs. Forbids arming, except in the state suspect.
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
        /// in use not confirmed by the last pairs
        ///
        /// The calibration in use has not fitted two pairs in a row, or two pairs in a row have missed it since, or no
        /// pair could be solved for ten pairs. Forbids arming.
        SELFCAL_REASON_EVIDENCE = 0x80_0000,
        /// depth in use uncertain
        ///
        /// `depth_px` is above its limit. Forbids arming.
        SELFCAL_REASON_DEPTH = 0x800_0000,
        /// rows in use off
        ///
        /// `rows_px` is above its limit. One such pair alone does not disarm.
        SELFCAL_REASON_ROWS = 0x2_0000,
        /// matches do not cover image or calibration in use
        ///
        /// `coverage` is below its limit, or the matches cover less than a seventh of the image. One such pair alone does
        /// not disarm.
        SELFCAL_REASON_COVERAGE = 0x400_0000,
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
        /// The scene has hardly moved since the last pair that was added, and the pair adds no evidence.
        SELFCAL_REASON_REPEATED = 0x40_0000,
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
        /// cameras of larger images, or matches in one quarter of the image only
        ///
        /// The matches of all pairs fill the upper left quarter of the left image and nothing else.
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
        /// rows not measured: the matcher searches along rows
        ///
        /// Nearly all rows of left and right are equal.
        SELFCAL_CAUSE_ROWS_NOT_MEASURED = 18010,
        /// left and right of different moments, a moving mount, or a rolling shutter
        ///
        /// Pairs fit well alone, and not each other.
        SELFCAL_CAUSE_MOMENTS = 18011,
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

/// Judgement of the calibration in use by the last pairs. A struct of zeros is no verdict: 0 is no state, and it permits
/// nothing.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_verdict_t {
    /// RMS row offset of the calibration in use beyond that of the pair's own pose, px; infinite before the first pair.
    /// Noise of the matcher does not count; vibration does.
    pub rows_px: f32,
    /// Expected RMS error of the disparities with the calibration in use, px; infinite without an estimate. The error of
    /// depth `Z` is `Z^2 / (f b)` times this.
    pub depth_px: f32,
    /// Share of the matches that fit the calibration in use, among those that fit the pair's own pose, 0 to 1.
    pub coverage: f32,
    /// Share of the cells of an 8 x 6 grid over the left image with a match that fits the pair's own pose, 0 to 1.
    pub image_coverage: f32,
    /// Whether `rows_px` is within `rows_limit_px` of the configuration.
    pub rows_ok: bool,
    /// Whether `depth_px` is within `depth_limit_px` of the configuration.
    pub depth_ok: bool,
    /// Answer to an arming check; `reasons` says why it is false.
    pub may_arm: bool,
    /// Whether `selfcal_apply` is worthwhile: the estimate is locked and clearly better than the calibration in use, and
    /// no mistake of the setup is named (`cause`).
    pub should_apply: bool,
    /// State of the estimate.
    pub state: selfcal_state_t,
    /// Reasons not to rely on the calibration in use: sum of `selfcal_reason_t`.
    pub reasons: u32,
    /// The likeliest mistake in rig file or matcher that the pairs, the matches or the estimate show.
    pub cause: selfcal_cause_t,
}

impl From<&Verdict<f32>> for selfcal_verdict_t {
    fn from(verdict: &Verdict<f32>) -> Self {
        Self {
            rows_px: verdict.rows_px,
            depth_px: verdict.depth_px,
            coverage: verdict.coverage,
            image_coverage: verdict.image_coverage,
            rows_ok: verdict.rows_ok,
            depth_ok: verdict.depth_ok,
            may_arm: verdict.may_arm,
            should_apply: verdict.should_apply,
            state: verdict.state.into(),
            reasons: bits(verdict.reasons),
            cause: verdict.cause.into(),
        }
    }
}

/// Writes the verdict after the last pair. It stays the same until the next pair has ended, and costs nothing. If the
/// call fails, nothing is written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_verdict(
    cal: *const selfcal_t,
    verdict: *mut selfcal_verdict_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, place) = unsafe { (shared(cal)?, Out::checked(verdict)?) };
        place.set(instance.calibrator.verdict().into());
        Ok(())
    })
}
