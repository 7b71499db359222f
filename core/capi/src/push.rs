//! Correspondences into the batch: one, or an array.

use core::ffi::c_char;

use stereo_selfcal::{Correspondence, PushError, Pushed};
use zerocopy::FromBytes;

use crate::code::{code, selfcal_error_t};
use crate::instance::{instance, shared};
use crate::pointer::{Out, read, read_array};
use crate::storage::selfcal_t;
use crate::text::{Text, find};

/// One left/right correspondence, in the images as they are, before undistortion.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_correspondence_t {
    /// Column u, row v in the left image, px.
    pub left_px: [f32; 2],
    /// Column u, row v in the right image, px.
    pub right_px: [f32; 2],
    /// The matcher's confidence, 0 (none) to 1 (certain).
    pub score: f32,
    /// Step of the grid that the coordinates were found on, px, 0 to 255.99: 1 for whole pixels, 0
    /// where they are continuous.
    pub grid_step_px: f32,
}

impl From<&selfcal_correspondence_t> for Correspondence<f32> {
    fn from(c: &selfcal_correspondence_t) -> Self {
        Self { left: c.left_px, right: c.right_px, score: c.score, grid_step: c.grid_step_px }
    }
}

/// What became of a valid correspondence.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_pushed_t {
    /// There was room for it.
    SELFCAL_PUSHED_KEPT = 0,
    /// It is in the batch, and another one left.
    SELFCAL_PUSHED_REPLACED = 1,
    /// The full batch is worth more without it.
    SELFCAL_PUSHED_LEFT_OUT = 2,
}

use selfcal_pushed_t::*;

const TEXTS: &[Text<u32>] = &[
    (SELFCAL_PUSHED_KEPT as u32, c"kept"),
    (SELFCAL_PUSHED_REPLACED as u32, c"replaced another one"),
    (SELFCAL_PUSHED_LEFT_OUT as u32, c"left out"),
];

impl From<Pushed> for selfcal_pushed_t {
    fn from(pushed: Pushed) -> Self {
        match pushed {
            Pushed::Kept => SELFCAL_PUSHED_KEPT,
            Pushed::Replaced => SELFCAL_PUSHED_REPLACED,
            Pushed::LeftOut => SELFCAL_PUSHED_LEFT_OUT,
        }
    }
}

/// What became of an array of correspondences.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct selfcal_pushed_counts_t {
    /// There was room for.
    pub kept: usize,
    /// In the batch, each in place of another one.
    pub replaced: usize,
    /// Valid, but the full batch is worth more without them.
    pub left_out: usize,
    /// Not valid.
    pub refused: usize,
    /// Why the first of these was refused; `SELFCAL_OK` if none was.
    pub first_refusal: selfcal_error_t,
}

/// What the batch holds.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct selfcal_batch_t {
    /// Correspondences at hand.
    pub held: u32,
    /// Offered since the batch was last cleared: at hand, left out or refused.
    pub offered: u32,
    /// Valid ones that had to leave a full batch, or did not get in.
    pub left_out: u32,
    /// Refused ones.
    pub refused: u32,
}

/// Offers one correspondence to the batch, which selects once it is full: matches spread over the left
/// image stay, of neighbours those with the better score.
///
/// * `pushed`: what became of it; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_push(
    cal: *mut selfcal_t,
    correspondence: *const selfcal_correspondence_t,
    pushed: *mut selfcal_pushed_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, correspondence, pushed) =
            unsafe { (instance(cal)?, read(correspondence)?, Out::optional(pushed)?) };
        pushed.set(instance.calibrator.push(&(&correspondence).into())?.into());
        Ok(())
    })
}

/// Offers an array of correspondences, one after the other. Some of them being refused is no error:
/// it is counted. Without cameras, or while a pair is being solved, none is offered.
///
/// * `correspondences`: `count` of them; may be null where that is 0.
/// * `counts`: what became of them; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_push_array(
    cal: *mut selfcal_t,
    correspondences: *const selfcal_correspondence_t,
    count: usize,
    counts: *mut selfcal_pushed_counts_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, correspondences, out) = unsafe {
            (instance(cal)?, read_array(correspondences, count)?, Out::optional(counts)?)
        };
        let mut counts = selfcal_pushed_counts_t {
            kept: 0,
            replaced: 0,
            left_out: 0,
            refused: 0,
            first_refusal: selfcal_error_t::SELFCAL_OK,
        };
        for correspondence in correspondences {
            let count = match instance.calibrator.push(&correspondence.into()) {
                Ok(Pushed::Kept) => &mut counts.kept,
                Ok(Pushed::Replaced) => &mut counts.replaced,
                Ok(Pushed::LeftOut) => &mut counts.left_out,
                Err(error @ (PushError::NoCameras | PushError::Busy)) => return Err(error.into()),
                Err(error) => {
                    if counts.refused == 0 {
                        counts.first_refusal = error.into();
                    }
                    &mut counts.refused
                }
            };
            *count = count.saturating_add(1);
        }
        out.set(counts);
        Ok(())
    })
}

/// What the batch holds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_batch(
    cal: *const selfcal_t,
    batch: *mut selfcal_batch_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(batch)?) };
        let batch = instance.calibrator.batch();
        out.set(selfcal_batch_t {
            held: u32::try_from(batch.pairs().len()).unwrap_or(u32::MAX),
            offered: batch.offered(),
            left_out: batch.left_out(),
            refused: batch.refused(),
        });
        Ok(())
    })
}

/// A `selfcal_pushed_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_pushed_string(pushed: u32) -> *const c_char {
    find(TEXTS, pushed)
}
