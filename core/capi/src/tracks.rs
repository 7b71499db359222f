//! Tracks of a matcher that follows its points over frames: matches of two frames, joined by their track numbers.

use core::mem::MaybeUninit;

use stereo_selfcal::depth::Tracks;
use stereo_selfcal::link::Tracking;

use crate::capacity::SELFCAL_CAPACITY;
use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t};
use crate::link::{feed, selfcal_frame_t, selfcal_link_t};
use crate::marked::{self, Marked};
use crate::pointer::Out;
use crate::witness::selfcal_witnessed_t;

/// Size of `selfcal_tracks_t` in words of 8 bytes, sufficient on every target.
pub const SELFCAL_TRACKS_STORAGE_WORDS: usize = 11 + 66 * SELFCAL_CAPACITY / 8;

/// Size of `selfcal_tracks_t`, bytes.
pub const SELFCAL_TRACKS_STORAGE_SIZE: usize = 8 * SELFCAL_TRACKS_STORAGE_WORDS;

/// Matches of an earlier frame and of the last frame, joined by the track numbers that a matcher sends with them; up to
/// `SELFCAL_CAPACITY`. The caller owns the storage, as with `selfcal_t`. Each link needs its own.
#[repr(C)]
pub struct selfcal_tracks_t {
    /// Private.
    opaque: [MaybeUninit<u64>; SELFCAL_TRACKS_STORAGE_WORDS],
}

/// Content of an initialised `selfcal_tracks_t`.
#[repr(C)]
struct Joined {
    magic: [u32; 3],
    tracks: Tracks<f32, SELFCAL_CAPACITY>,
}

// SAFETY: `repr(C)`, and the magic is the first field.
unsafe impl Marked for Joined {
    /// "SELFTRCK".
    const NAME: [u32; 2] = [0x5345_4C46, 0x5452_434B];
}

const _: () = marked::assert_fits::<Joined, selfcal_tracks_t>(SELFCAL_TRACKS_STORAGE_SIZE);

/// Initialises tracks. Call it before all other functions of the tracks. For tracks in use, it forgets their frames.
///
/// * `size`: size of the storage, bytes: `sizeof(selfcal_tracks_t)`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_tracks_init(
    tracks: *mut selfcal_tracks_t,
    size: usize,
) -> selfcal_error_t {
    status(|| {
        let place = tracks.cast::<Joined>();
        marked::check_place(place, size)?;
        // SAFETY: not null, aligned and large enough. Written field by field, so that the whole is not on the stack.
        unsafe {
            (&raw mut (*place).tracks).write(Tracks::new());
            (&raw mut (*place).magic).write(Joined::MAGIC);
        }
        Ok(())
    })
}

/// Does the same as `selfcal_link_feed`, for a matcher that sends tracks: `tracks` also receive each frame.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_link_feed_tracked(
    link: *mut selfcal_link_t,
    cal: *mut selfcal_t,
    tracks: *mut selfcal_tracks_t,
    bytes: *const u8,
    length: usize,
    used: *mut usize,
    frame: *mut selfcal_frame_t,
) -> selfcal_error_t {
    // SAFETY: the caller keeps the contract of the crate; storage is as large as `Joined`.
    unsafe {
        feed(link, cal, bytes, length, used, frame, |decoder, bytes, calibrator| {
            let tracks = &mut marked::exclusive(tracks.cast::<Joined>())?.tracks;
            Ok(decoder.feed(bytes, &mut Tracking { calibrator, tracks: Some(tracks) })?)
        })
    }
}

/// Does the same as `selfcal_push_motion`, with the tracked matches that the earlier frame and the frame of the last
/// pair share. Call it after the end of the pair. Each frame is joined to the same earlier frame until the rig has
/// moved far enough for a measurement. Before that, `SELFCAL_ERROR_NO_MOTION` and `SELFCAL_ERROR_TOO_FEW` are normal.
/// After a measurement, and after `SELFCAL_ERROR_CONTRADICTS`, the last frame becomes the earlier frame. A frame that
/// shares fewer than half of the tracks of the earlier frame also replaces it.
///
/// * `witnessed`: effect on the estimate; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_push_tracks(
    cal: *mut selfcal_t,
    tracks: *mut selfcal_tracks_t,
    witnessed: *mut selfcal_witnessed_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate; storage is as large as `Joined`.
        let (instance, joined, out) = unsafe {
            let instance = exclusive(cal)?;
            (instance, marked::exclusive(tracks.cast::<Joined>())?, Out::optional(witnessed)?)
        };
        out.set(instance.calibrator.push_tracks(&mut joined.tracks)?.into());
        Ok(())
    })
}

/// Takes one step of `selfcal_push_tracks`: one pass over at most 256 matches. After at most 16 steps, effect and errors
/// equal those of `selfcal_push_tracks`, bit for bit. The next frame abandons the steps taken.
///
/// * `ended`: whether no further step is needed; an error ends the steps, too.
/// * `witnessed`: effect on the estimate, written after the last step; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_advance_tracks(
    cal: *mut selfcal_t,
    tracks: *mut selfcal_tracks_t,
    ended: *mut bool,
    witnessed: *mut selfcal_witnessed_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate; storage is as large as `Joined`.
        let (instance, joined, ended, out) = unsafe {
            let instance = exclusive(cal)?;
            let joined = marked::exclusive(tracks.cast::<Joined>())?;
            (instance, joined, Out::checked(ended)?, Out::optional(witnessed)?)
        };
        let found = instance.calibrator.advance_tracks(&mut joined.tracks);
        ended.set(found.is_some());
        if let Some(found) = found {
            out.set(found?.into());
        }
        Ok(())
    })
}
