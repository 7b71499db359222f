//! One pair: its solution, its fusion and its outcome.

use stereo_selfcal::outcome::Stop;
use stereo_selfcal::{Fused, Outcome, PairReport};

use crate::error::{selfcal_error_t, status};
use crate::extrinsics::selfcal_extrinsics_t;
use crate::instance::{exclusive, selfcal_t};
use crate::pointer::{Out, read_array};
use crate::push::selfcal_correspondence_t;

c_enum! {
    /// Why the solver stopped.
    #[repr(u32)]
    pub enum selfcal_stop_t {
        /// converged
        ///
        /// The step fell below the tolerance, or below the resolution of `f32` at the optimum.
        SELFCAL_STOP_CONVERGED = 11000,
        /// no descent
        ///
        /// No step lowers the cost, so this is the optimum within the resolution of `f32`; or the normal equations have
        /// no solution.
        SELFCAL_STOP_NO_DESCENT = 11001,
        /// passes spent
        ///
        /// All passes were taken. This is normal for a pair that was tracked from an estimate. A search that stops this
        /// way has not converged; its result is the best pose reached.
        SELFCAL_STOP_PASSES_SPENT = 11002,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_STOP_UNKNOWN = 11255,
    }
}

from_core!(Stop => selfcal_stop_t from 11000, else SELFCAL_STOP_UNKNOWN);

c_enum! {
    /// Effect of a pair on the estimate.
    #[repr(u32)]
    pub enum selfcal_fused_t {
        /// added
        ///
        /// The pair is part of the estimate.
        SELFCAL_FUSED_ADDED = 12000,
        /// same scene again
        ///
        /// The scene has hardly moved since the last pair that was added, and the pair adds nothing.
        SELFCAL_FUSED_REPEATED = 12001,
        /// kept apart
        ///
        /// The pair disagrees with the estimate, and is part of the challenger. A challenger that three pairs confirm
        /// ends with this pair if its extrinsics agree with the estimate after all.
        SELFCAL_FUSED_KEPT_APART = 12002,
        /// added, older pairs dropped
        ///
        /// The pair is part of the estimate, and the last pairs have replaced the older ones: the rig has drifted, or
        /// has moved by less than a single pair shows.
        SELFCAL_FUSED_RENEWED = 12003,
        /// challenger promoted
        ///
        /// The challenger, with this pair, has become the estimate.
        SELFCAL_FUSED_TOOK_OVER = 12004,
        /// lens corrected, estimate begins again
        ///
        /// The pairs show another lens model of the right camera: the estimate begins again with corrected cameras
        /// (`SELFCAL_LENS_TRACKING_COMPENSATE`). The batch is emptied, and there are neither a proposal nor details until
        /// the next pair is fused.
        SELFCAL_FUSED_LENS_CORRECTED = 12005,
        /// not fused
        ///
        /// The pair is not part of the estimate; the error of the call says why.
        SELFCAL_FUSED_NOT = 12254,
        /// unknown
        ///
        /// A value that this API does not know.
        SELFCAL_FUSED_UNKNOWN = 12255,
    }
}

from_core!(Fused => selfcal_fused_t from 12000, else SELFCAL_FUSED_UNKNOWN);

/// Result of one pair: the rig at its moment. A rig that bends all the time has no estimate over many pairs, and each
/// image pair is rectified with the extrinsics of its own report.
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
    /// Passes taken over the batch. The published method does not count the evaluation pass.
    pub passes: u16,
    /// Number of correspondences in front of both rectified cameras.
    pub usable: u32,
    /// Number of correspondences that are left out, because they are not in front of both rectified cameras.
    pub skipped: u32,
    /// Number of usable correspondences that fit the solution and are in front of both cameras at the start.
    pub screened: u32,
    /// Cost at the start, computed with the loss of the solution, px^2.
    pub cost_before: f32,
    /// Cost at the solution, px^2.
    pub cost_after: f32,
    /// RMS row offset of the screened correspondences at the start, px; 0 without any.
    pub rms_px_before: f32,
    /// RMS row offset of the same correspondences at the solution, px.
    pub rms_px_after: f32,
    /// Estimated noise, standard deviation, px: of a coordinate; in the published method of a row offset.
    pub noise_px: f32,
}

impl selfcal_report_t {
    /// Report without a pair.
    const NONE: Self = Self {
        extrinsics: selfcal_extrinsics_t::ZERO,
        information: [[0.0; 5]; 5],
        stop: selfcal_stop_t::SELFCAL_STOP_UNKNOWN,
        passes: 0,
        usable: 0,
        skipped: 0,
        screened: 0,
        cost_before: 0.0,
        cost_after: 0.0,
        rms_px_before: 0.0,
        rms_px_after: 0.0,
        noise_px: 0.0,
    };
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

/// Outcome of one pair.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_outcome_t {
    /// Effect on the estimate; `SELFCAL_FUSED_NOT` with an error.
    pub fused: selfcal_fused_t,
    /// Whether the pair was solved. Then `pair` is valid, even if the pair was not fused.
    pub has_pair: bool,
    /// Result of the pair alone. If it is not valid, its numbers are 0, and `stop` is `SELFCAL_STOP_UNKNOWN`.
    pub pair: selfcal_report_t,
}

impl From<&Outcome<f32>> for selfcal_outcome_t {
    fn from(outcome: &Outcome<f32>) -> Self {
        let not = selfcal_fused_t::SELFCAL_FUSED_NOT;
        Self {
            fused: outcome.fused.map_or(not, Into::into),
            has_pair: outcome.pair.is_some(),
            pair: outcome.pair.as_ref().map_or(selfcal_report_t::NONE, Into::into),
        }
    }
}

/// Writes an outcome. Returns the error of a pair that is not fused.
pub(crate) fn end(
    outcome: &Outcome<f32>,
    place: Out<selfcal_outcome_t>,
) -> Result<(), selfcal_error_t> {
    place.set(outcome.into());
    outcome.fused.map(|_| ()).map_err(Into::into)
}

/// Takes one stereo pair in one call: replaces the batch by an array of correspondences, solves it and fuses the
/// result. A pair that was being solved is abandoned. Refused correspondences are not an error; `selfcal_batch`
/// counts them.
///
/// An error from 500 on says why the pair is not part of the estimate, which is normal: go on with the next pair.
///
/// * `correspondences`: array of `count`; may be null if `count` is 0.
/// * `outcome`: written with these errors, too; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_take_pair(
    cal: *mut selfcal_t,
    correspondences: *const selfcal_correspondence_t,
    count: usize,
    outcome: *mut selfcal_outcome_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, all, place) = unsafe {
            (exclusive(cal)?, read_array(correspondences, count)?, Out::optional(outcome)?)
        };
        end(&instance.calibrator.take_pair(all.iter().map(Into::into)), place)
    })
}

/// Solves the batch and fuses the result, in one call with all passes. The next correspondence that is pushed begins
/// a new batch; until then `selfcal_details` and `selfcal_push_range` read this one. It has the
/// same errors as `selfcal_take_pair`.
///
/// * `outcome`: written with these errors, too; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_solve_pair(
    cal: *mut selfcal_t,
    outcome: *mut selfcal_outcome_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, place) = unsafe { (exclusive(cal)?, Out::optional(outcome)?) };
        end(&instance.calibrator.solve_pair(), place)
    })
}

/// Takes one step of a pair: at most one pass over the batch. The first step begins the pair with the correspondences
/// pushed so far, and the last step fuses the result. Outcome and errors equal those of `selfcal_solve_pair`, bit for
/// bit. An error from 500 on ends the pair.
///
/// * `ended`: whether the pair has ended; written with these errors, too.
/// * `outcome`: written once the pair has ended; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_advance_pair(
    cal: *mut selfcal_t,
    ended: *mut bool,
    outcome: *mut selfcal_outcome_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, ended, place) =
            unsafe { (exclusive(cal)?, Out::checked(ended)?, Out::optional(outcome)?) };
        let found = instance.calibrator.advance_pair();
        ended.set(found.is_some());
        found.map_or(Ok(()), |outcome| end(&outcome, place))
    })
}

/// Empties the batch, and abandons a pair that is being solved. A pair that has been fused already gets its verdict first.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_discard_pair(cal: *mut selfcal_t) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        unsafe { exclusive(cal) }?.calibrator.discard_pair();
        Ok(())
    })
}
