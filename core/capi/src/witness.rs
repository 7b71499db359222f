//! Witnesses of the yaw of the mount, which rows alone cannot tell from the lens.

use core::ffi::c_char;

use stereo_selfcal::{Range, RangeReading, Witnessed};
use zerocopy::FromBytes;

use crate::enumeration::find;
use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t};
use crate::pointer::{Out, read};

/// A point of the left image at a known distance.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_range_t {
    /// Column u, row v in the left image, px, before undistortion.
    pub pixel_px: [f32; 2],
    /// Distance from the left camera, m.
    pub range_m: f32,
    /// Standard deviation of the distance, m.
    pub sd_m: f32,
    /// 0: along the ray of the pixel, as of a laser rangefinder. Otherwise along the optical axis, as of a wall ahead.
    pub along_axis: u32,
}

impl From<&selfcal_range_t> for RangeReading<f32> {
    fn from(range: &selfcal_range_t) -> Self {
        let of = if range.along_axis == 0 { Range::AlongRay } else { Range::AlongAxis };
        Self { pixel: range.pixel_px, range: of(range.range_m), sd_m: range.sd_m }
    }
}

c_enum! {
    /// Effect of a valid reading on the estimate.
    #[repr(u32)]
    pub enum selfcal_witnessed_t {
        /// taken
        ///
        /// It is part of the estimate.
        SELFCAL_WITNESSED_TAKEN = 0,
        /// waiting for a second one
        ///
        /// It contradicts the yaw so far: the next one decides.
        SELFCAL_WITNESSED_WAITING = 1,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_WITNESSED_UNKNOWN = 255,
    }
}

from_core!(Witnessed => selfcal_witnessed_t, else SELFCAL_WITNESSED_UNKNOWN);

/// Adds a point of known distance, after `selfcal_fuse` and before `selfcal_clear_pair`: it tells the yaw of the
/// mount from the lens. It needs the length of the baseline (`selfcal_config_set_baseline_m`) and a match within 3 px
/// that fits the estimate. Five readings of 1 %, or ten of 3 %, are enough.
///
/// * `witnessed`: effect on the estimate; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_push_range(
    cal: *mut selfcal_t,
    range: *const selfcal_range_t,
    witnessed: *mut selfcal_witnessed_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, range, out) =
            unsafe { (exclusive(cal)?, read(range)?, Out::optional(witnessed)?) };
        out.set(instance.calibrator.push_range(&(&range).into())?.into());
        Ok(())
    })
}

/// Declares that the mount still is as the factory calibration says, for example on the production line in the locked
/// state: the turn that rows show beyond it is the lens's, from now on and after changes of the rig.
///
/// * `confirmed`: false, without effect, without factory extrinsics, in the paper preset, and where the rig has changed
///   or rows refute the calibration; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_confirm_factory_yaw(
    cal: *mut selfcal_t,
    confirmed: *mut bool,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (exclusive(cal)?, Out::optional(confirmed)?) };
        out.set(instance.calibrator.confirm_factory_yaw());
        Ok(())
    })
}

/// Text of a `selfcal_witnessed_t`, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_witnessed_string(witnessed: u32) -> *const c_char {
    find(selfcal_witnessed_t::TEXTS, witnessed)
}
