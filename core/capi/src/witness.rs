//! Witnesses of the yaw of the mount, which rows alone do not separate from the apparent yaw of the lens.

use stereo_selfcal::batch::RayPair;
use stereo_selfcal::depth::{Range, RangeReading, Witnessed};
use zerocopy::FromBytes;

use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t, shared};
use crate::pointer::{Out, read, read_array};
use crate::push::selfcal_correspondence_t;

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
    /// 0: the distance is along the ray of the pixel, as a laser rangefinder measures it. Otherwise it is along the
    /// optical axis, such as the distance of a wall ahead.
    pub along_axis: u32,
    /// 0: the nearest match of the last pair within 3 px of `pixel_px` gives the disparity. Otherwise `right_px` gives
    /// it.
    pub has_right: u32,
    /// Column u, row v of the same point in the right image, px, before undistortion, if the matcher has looked for it.
    pub right_px: [f32; 2],
}

impl From<&selfcal_range_t> for RangeReading<f32> {
    fn from(range: &selfcal_range_t) -> Self {
        let of = if range.along_axis == 0 { Range::AlongRay } else { Range::AlongAxis };
        Self {
            pixel: range.pixel_px,
            right: (range.has_right != 0).then_some(range.right_px),
            range: of(range.range_m),
            sd_m: range.sd_m,
        }
    }
}

c_enum! {
    /// Effect of a valid reading on the estimate.
    #[repr(u32)]
    pub enum selfcal_witnessed_t {
        /// taken
        ///
        /// The reading is part of the estimate.
        SELFCAL_WITNESSED_TAKEN = 19000,
        /// waiting for others that agree
        ///
        /// The reading contradicts the present yaw, and waits for further readings that agree with it.
        SELFCAL_WITNESSED_WAITING = 19001,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_WITNESSED_UNKNOWN = 19255,
    }
}

from_core!(Witnessed => selfcal_witnessed_t from 19000, else SELFCAL_WITNESSED_UNKNOWN);

/// Adds a point of known distance, which separates the yaw of the mount from the apparent yaw of the lens. Call it
/// after the end of the pair that shows the point, and before the next pair. It needs the length of the baseline
/// (`selfcal_factory_t.baseline_m`) and a match that fits the estimate: `right_px`, or a match of the pair within 3 px.
/// Five readings with an error of 1 %, or ten with an error of 3 %, are enough.
///
/// A reading that contradicts the present yaw waits. The present yaw is replaced once more contradicting readings in a
/// row agree with each other than support the present yaw. This takes two to four readings.
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
        out.set(instance.calibrator.push_range(&RangeReading::from(&range))?.into());
        Ok(())
    })
}

/// A match that was tracked from one pair to a later pair: its rays in both pairs, written by `selfcal_track`.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_tracked_t {
    /// Private.
    pub words: [u32; 10],
}

/// The rays of a tracked match.
type Tracked = [RayPair<f32>; 2];

const _: () = assert!(size_of::<selfcal_tracked_t>() == size_of::<Tracked>());
const _: () = assert!(align_of::<selfcal_tracked_t>() >= align_of::<Tracked>());

/// Computes the rays of a tracked match, with the cameras of the factory calibration, and writes them to `tracked`.
///
/// * `before`, `after`: the match in the first and in the second pair.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_track(
    cal: *const selfcal_t,
    before: *const selfcal_correspondence_t,
    after: *const selfcal_correspondence_t,
    tracked: *mut selfcal_tracked_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, pair, out) =
            unsafe { (shared(cal)?, [read(before)?, read(after)?], Out::checked(tracked.cast())?) };
        let cameras = &instance.cameras;
        let [before, after] = pair.each_ref().map(|c| cameras.rays(&c.into()));
        let tracked: Tracked = [before?, after?];
        out.set(tracked);
        Ok(())
    })
}

/// Adds matches that were tracked from one pair to a later pair while the rig moved by several lengths of its baseline.
/// They separate the yaw of the mount from the apparent yaw of the lens. Call it after the end of the later pair. Up to
/// 256 matches are read, at most 16 times each; on a controller, `selfcal_advance_tracks` divides this into calls. A
/// motion that contradicts the present yaw waits, as a reading of `selfcal_push_range` does.
///
/// * `tracked`: array of `count` matches, written by `selfcal_track`.
/// * `witnessed`: effect on the estimate; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_push_motion(
    cal: *mut selfcal_t,
    tracked: *const selfcal_tracked_t,
    count: usize,
    witnessed: *mut selfcal_witnessed_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, tracked, out) =
            unsafe { (exclusive(cal)?, read_array(tracked, count)?, Out::optional(witnessed)?) };
        // SAFETY: `Tracked` has the same size and no larger alignment, and any bits are rays.
        let tracked: &[Tracked] =
            unsafe { core::slice::from_raw_parts(tracked.as_ptr().cast(), tracked.len()) };
        out.set(instance.calibrator.push_motion(tracked)?.into());
        Ok(())
    })
}
