//! One pair: solve the batch, read the report, fuse, clear.

use core::ffi::c_char;

use stereo_selfcal::{Fused, PairReport, Stop};

use crate::enumeration::find;
use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::extrinsics::selfcal_extrinsics_t;
use crate::instance::{exclusive, selfcal_t, shared};
use crate::pointer::Out;

c_enum! {
    /// Why the solver stopped.
    #[repr(u32)]
    pub enum selfcal_stop_t {
        /// converged
        ///
        /// The step fell below the tolerance.
        SELFCAL_STOP_CONVERGED = 0,
        /// no descent
        ///
        /// No step lowers the cost: the optimum to the resolution of the numbers.
        SELFCAL_STOP_NO_DESCENT = 1,
        /// passes spent
        ///
        /// All configured passes are done, as for every pair of a locked estimate. The result is
        /// the best pose found.
        SELFCAL_STOP_PASSES_SPENT = 2,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_STOP_UNKNOWN = 255,
    }
}

from_core!(Stop => selfcal_stop_t, else SELFCAL_STOP_UNKNOWN);

c_enum! {
    /// Effect of a fused pair on the estimate.
    #[repr(u32)]
    pub enum selfcal_fused_t {
        /// added
        ///
        /// The pair is part of the estimate.
        SELFCAL_FUSED_ADDED = 0,
        /// same scene again
        ///
        /// The pair shows the same scene as the one before, and replaces it.
        SELFCAL_FUSED_REPEATED = 1,
        /// kept apart
        ///
        /// The pair disagrees with the estimate and supports a challenger.
        SELFCAL_FUSED_KEPT_APART = 2,
        /// added, older pairs dropped
        ///
        /// The pair is part of the estimate, and recent pairs have replaced the older ones: the rig
        /// drifts.
        SELFCAL_FUSED_RENEWED = 3,
        /// challenger promoted
        ///
        /// The pairs of the challenger agree: its estimate is the estimate now.
        SELFCAL_FUSED_TOOK_OVER = 4,
        /// lens corrected, estimate begins again
        ///
        /// The pairs show another lens model of the right camera: the estimate begins again with corrected
        /// cameras, `SELFCAL_LENS_TRACKING_COMPENSATE`. The batch is emptied; there is no proposal and no
        /// health until the next pair.
        SELFCAL_FUSED_LENS_CORRECTED = 5,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_FUSED_UNKNOWN = 255,
    }
}

from_core!(Fused => selfcal_fused_t, else SELFCAL_FUSED_UNKNOWN);

/// Result of one pair.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_report_t {
    /// `R`, `t` of the pair alone.
    pub extrinsics: selfcal_extrinsics_t,
    /// Information matrix, 1/rad^2, symmetric. Order: rotation of `R` about x, y, z, rotation of the
    /// baseline about y, z, in the rectified frame.
    pub information: [[f32; 5]; 5],
    /// Why the solver stopped.
    pub stop: selfcal_stop_t,
    /// Passes taken over the batch.
    pub passes: u16,
    /// Correspondences in front of both rectified cameras.
    pub usable: u32,
    /// Correspondences that are not.
    pub skipped: u32,
    /// Usable correspondences that fit the solution.
    pub screened: u32,
    /// Cost at the start, px^2.
    pub cost_before: f32,
    /// Cost at the solution, px^2.
    pub cost_after: f32,
    /// RMS row offset of the screened correspondences at the start, px.
    pub rms_px_before: f32,
    /// The same at the solution, px.
    pub rms_px_after: f32,
    /// Estimated noise, standard deviation, px: of a coordinate in the robust preset, of a row
    /// offset in the paper preset.
    pub noise_px: f32,
}

impl From<&PairReport<f32>> for selfcal_report_t {
    fn from(report: &PairReport<f32>) -> Self {
        Self {
            extrinsics: (&report.extrinsics).into(),
            // nalgebra stores columns.
            information: report.information.matrix().transpose().into(),
            stop: report.stop.into(),
            passes: report.passes,
            usable: report.usable,
            skipped: report.skipped,
            screened: report.screened,
            cost_before: report.cost_before,
            cost_after: report.cost_after,
            rms_px_before: report.rms_px_before,
            rms_px_after: report.rms_px_after,
            noise_px: report.noise_px,
        }
    }
}

/// Starts to solve the batch with a first pass over it. Then call `selfcal_advance_pair`. Forgets the
/// report of the last pair.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_begin_pair(cal: *mut selfcal_t) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { exclusive(cal) }?;
        instance.given()?;
        instance.advance().map(|_| ())
    })
}

/// Takes one more pass over the batch, or two to evaluate a solved pair.
///
/// * `solved`: whether the pair is solved. Then fuse it before the batch is cleared.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_advance_pair(
    cal: *mut selfcal_t,
    solved: *mut bool,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, solved) = unsafe { (exclusive(cal)?, Out::checked(solved)?) };
        instance.given()?;
        solved.set(instance.advance()?);
        Ok(())
    })
}

/// Solves the batch in one call, with all passes. Fuse the pair before the batch is cleared.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_solve_pair(cal: *mut selfcal_t) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { exclusive(cal) }?;
        instance.given()?;
        let outcome = instance.calibrator.solve_pair();
        instance.end(outcome)
    })
}

/// Result of the last solved pair, until the next pair is begun or the batch is cleared.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_report(
    cal: *const selfcal_t,
    report: *mut selfcal_report_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(report)?) };
        let report = instance.solved.as_ref().ok_or(SELFCAL_ERROR_NO_REPORT)?;
        out.set(report.into());
        Ok(())
    })
}

/// Reads, once, how the solved pair became part of the estimate, or why not. Solving a pair fuses it.
///
/// * `fused`: effect on the estimate; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_fuse(
    cal: *mut selfcal_t,
    fused: *mut selfcal_fused_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, fused) = unsafe { (exclusive(cal)?, Out::optional(fused)?) };
        instance.solved.as_ref().ok_or(SELFCAL_ERROR_NO_REPORT)?;
        let effect = instance.fused.take().ok_or(SELFCAL_ERROR_NO_REPORT)?;
        fused.set(effect?.into());
        Ok(())
    })
}

/// Clears the batch and the report, and abandons a pair that is being solved.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_clear_pair(cal: *mut selfcal_t) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { exclusive(cal) }?;
        instance.forget_pair();
        instance.calibrator.discard_pair();
        Ok(())
    })
}

/// Text of a `selfcal_stop_t`, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_stop_string(stop: u32) -> *const c_char {
    find(selfcal_stop_t::TEXTS, stop)
}

/// Text of a `selfcal_fused_t`, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_fused_string(fused: u32) -> *const c_char {
    find(selfcal_fused_t::TEXTS, fused)
}
