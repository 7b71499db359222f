//! Adds correspondences to the batch, one by one or as an array.

use stereo_selfcal::batch::Pushed;
use stereo_selfcal::{Correspondence, PushError};
use zerocopy::FromBytes;

use crate::error::{selfcal_error_t, status};
use crate::instance::{exclusive, selfcal_t, shared};
use crate::pointer::{Out, read, read_array};

/// One left/right correspondence in the raw images, before undistortion.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_correspondence_t {
    /// Column u, row v in the left image, px.
    pub left_px: [f32; 2],
    /// Column u, row v in the right image, px.
    pub right_px: [f32; 2],
    /// Confidence of the matcher, 0 (none) to 1 (certain).
    pub score: f32,
    /// Step of the grid on which the matcher finds coordinates, px, 0 to 255.99: 1 for whole pixels, 0 for continuous
    /// coordinates.
    pub grid_step_px: f32,
}

impl From<&selfcal_correspondence_t> for Correspondence<f32> {
    fn from(c: &selfcal_correspondence_t) -> Self {
        Self { left: c.left_px, right: c.right_px, score: c.score, grid_step: c.grid_step_px }
    }
}

c_enum! {
    /// Effect of a valid correspondence on the batch.
    #[repr(u32)]
    pub enum selfcal_pushed_t {
        /// kept
        ///
        /// The batch had room for it.
        SELFCAL_PUSHED_KEPT = 10000,
        /// replaced another one
        ///
        /// It replaces another correspondence in the full batch.
        SELFCAL_PUSHED_REPLACED = 10001,
        /// left out
        ///
        /// The full batch keeps other correspondences instead.
        SELFCAL_PUSHED_LEFT_OUT = 10002,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_PUSHED_UNKNOWN = 10255,
    }
}

from_core!(Pushed => selfcal_pushed_t from 10000, else SELFCAL_PUSHED_UNKNOWN);

/// Effect of an array of correspondences on the batch.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct selfcal_pushed_counts_t {
    /// Number of correspondences that the batch had room for.
    pub kept: usize,
    /// Number of correspondences that replaced another one.
    pub replaced: usize,
    /// Number of valid correspondences that the full batch did not take.
    pub left_out: usize,
    /// Number of correspondences that were refused, because they are not valid.
    pub refused: usize,
    /// Why the first refused correspondence was refused; `SELFCAL_OK` without a refusal.
    pub first_refusal: selfcal_error_t,
}

/// Counts of the batch.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct selfcal_batch_t {
    /// Number of correspondences in the batch.
    pub held: u32,
    /// Number of correspondences offered to this batch: held, left out or refused.
    pub offered: u32,
    /// Number of valid correspondences that the full batch does not hold.
    pub left_out: u32,
    /// Number of refused correspondences.
    pub refused: u32,
}

/// Offers one correspondence to the batch. A full batch selects: it keeps matches spread over the left image, and
/// prefers the better score among neighbours. The first correspondence after the end of a pair begins a new batch. A
/// correspondence that is not valid is refused and counted. While a pair is being solved, the batch takes no
/// correspondence: `SELFCAL_ERROR_BUSY`.
///
/// * `pushed`: effect on the batch; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_push(
    cal: *mut selfcal_t,
    correspondence: *const selfcal_correspondence_t,
    pushed: *mut selfcal_pushed_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, correspondence, pushed) =
            unsafe { (exclusive(cal)?, read(correspondence)?, Out::optional(pushed)?) };
        pushed.set(instance.calibrator.push(&(&correspondence).into())?.into());
        Ok(())
    })
}

/// Offers an array of correspondences to the batch, in their order. Refused correspondences are counted, and are not an
/// error. While a pair is being solved, the batch takes no correspondence: `SELFCAL_ERROR_BUSY`.
///
/// * `correspondences`: array of `count`; may be null if `count` is 0.
/// * `counts`: effect on the batch; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_push_array(
    cal: *mut selfcal_t,
    correspondences: *const selfcal_correspondence_t,
    count: usize,
    counts: *mut selfcal_pushed_counts_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, correspondences, out) = unsafe {
            (exclusive(cal)?, read_array(correspondences, count)?, Out::optional(counts)?)
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
                Err(error @ PushError::Busy) => return Err(error.into()),
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

/// Reads the counts of the batch.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_batch(
    cal: *const selfcal_t,
    batch: *mut selfcal_batch_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(batch)?) };
        let batch = instance.calibrator.batch();
        out.set(selfcal_batch_t {
            held: u32::try_from(batch.matches().len()).unwrap_or(u32::MAX),
            offered: batch.offered(),
            left_out: batch.left_out(),
            refused: batch.refused(),
        });
        Ok(())
    })
}
