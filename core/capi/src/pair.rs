//! One pair: solved from the batch, reported, fused, cleared.

use core::ffi::c_char;

use stereo_selfcal::{Fused, PairReport, Stop};

use crate::code::code;
use crate::code::selfcal_error_t::{self, *};
use crate::extrinsics::selfcal_extrinsics_t;
use crate::instance::{Solved, instance, shared};
use crate::pointer::Out;
use crate::storage::selfcal_t;
use crate::text::{Text, find};

/// Why the solver stopped.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_stop_t {
    /// The step fell below the tolerance.
    SELFCAL_STOP_CONVERGED = 0,
    /// No step lowers the cost any more: the optimum to the resolution of the numbers.
    SELFCAL_STOP_NO_DESCENT = 1,
    /// The allowed passes are used up; the result is the best seen.
    SELFCAL_STOP_PASS_LIMIT = 2,
    /// The core gave a reason that this API does not know yet.
    SELFCAL_STOP_UNKNOWN = 255,
}

use selfcal_stop_t::*;

const STOPS: &[Text<u32>] = &[
    (SELFCAL_STOP_CONVERGED as u32, c"converged"),
    (SELFCAL_STOP_NO_DESCENT as u32, c"no descent"),
    (SELFCAL_STOP_PASS_LIMIT as u32, c"pass limit"),
];

impl From<Stop> for selfcal_stop_t {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::Converged => SELFCAL_STOP_CONVERGED,
            Stop::NoDescent => SELFCAL_STOP_NO_DESCENT,
            Stop::PassesSpent => SELFCAL_STOP_PASS_LIMIT,
            _ => SELFCAL_STOP_UNKNOWN,
        }
    }
}

/// What became of a fused pair.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_fused_t {
    /// It is part of the estimate.
    SELFCAL_FUSED_ADDED = 0,
    /// It shows the scene of the pair before it, in whose place it counts.
    SELFCAL_FUSED_REPEATED = 1,
    /// It disagrees with the estimate and is kept apart, for another one.
    SELFCAL_FUSED_KEPT_APART = 2,
    /// It is part of the estimate, and the pairs of late have replaced the older ones.
    SELFCAL_FUSED_RENEWED = 3,
    /// The pairs kept apart agree with each other: theirs is the estimate now.
    SELFCAL_FUSED_TOOK_OVER = 4,
    /// The core gave an outcome that this API does not know yet.
    SELFCAL_FUSED_UNKNOWN = 255,
}

use selfcal_fused_t::*;

const FUSED: &[Text<u32>] = &[
    (SELFCAL_FUSED_ADDED as u32, c"added"),
    (SELFCAL_FUSED_REPEATED as u32, c"same scene again"),
    (SELFCAL_FUSED_KEPT_APART as u32, c"kept apart"),
    (SELFCAL_FUSED_RENEWED as u32, c"added, older pairs dropped"),
    (SELFCAL_FUSED_TOOK_OVER as u32, c"the pairs kept apart took over"),
];

impl From<Fused> for selfcal_fused_t {
    fn from(fused: Fused) -> Self {
        match fused {
            Fused::Added => SELFCAL_FUSED_ADDED,
            Fused::Repeated => SELFCAL_FUSED_REPEATED,
            Fused::KeptApart => SELFCAL_FUSED_KEPT_APART,
            Fused::Renewed => SELFCAL_FUSED_RENEWED,
            Fused::TookOver => SELFCAL_FUSED_TOOK_OVER,
            _ => SELFCAL_FUSED_UNKNOWN,
        }
    }
}

/// What one pair says.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_report_t {
    /// `R`, `t` of the pair alone.
    pub extrinsics: selfcal_extrinsics_t,
    /// Information about them, 1/rad^2, symmetric. Order: turn of `R` about x, y, z, turn of the
    /// baseline about y, z, in the rectified frame.
    pub information: [[f32; 5]; 5],
    /// Why the solver stopped.
    pub stop: selfcal_stop_t,
    /// Passes taken over the batch.
    pub passes: u16,
    /// Correspondences in front of both rectified cameras.
    pub usable: u32,
    /// Correspondences left out because they are not.
    pub skipped: u32,
    /// Usable ones that fit the solution.
    pub screened: u32,
    /// Cost at the start, px^2.
    pub cost_before: f32,
    /// Cost at the solution, px^2.
    pub cost_after: f32,
    /// RMS row offset of the screened correspondences at the start, px.
    pub rms_px_before: f32,
    /// The same at the solution, px.
    pub rms_px_after: f32,
    /// Estimated standard deviation, px: robust preset, of a coordinate; paper preset, of a row offset.
    pub noise_px: f32,
}

impl From<&PairReport<f32>> for selfcal_report_t {
    fn from(report: &PairReport<f32>) -> Self {
        Self {
            extrinsics: (&report.extrinsics).into(),
            // Arrays of columns, otherwise.
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

/// Starts to solve the batch: the first pass over it. Then call `selfcal_advance_pair`. The report of
/// the pair before is forgotten.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_begin_pair(cal: *mut selfcal_t) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { instance(cal) }?;
        instance.solved = None;
        Ok(instance.calibrator.begin_pair()?)
    })
}

/// Takes one more pass over the batch, or two to judge a pair that is solved.
///
/// * `solved`: whether the pair is solved: then fuse it before the batch is cleared.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_advance_pair(
    cal: *mut selfcal_t,
    solved: *mut bool,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, solved) = unsafe { (instance(cal)?, Out::checked(solved)?) };
        let report = instance.calibrator.advance_pair()?;
        solved.set(report.is_some());
        instance.solved = report.map(Solved::from);
        Ok(())
    })
}

/// Solves the batch in one call: all passes. Fuse the pair before the batch is cleared.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_solve_pair(cal: *mut selfcal_t) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { instance(cal) }?;
        instance.solved = None;
        instance.solved = Some(instance.calibrator.solve_pair()?.into());
        Ok(())
    })
}

/// What the last pair says, once it is solved and until the batch is begun anew or cleared.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_report(
    cal: *const selfcal_t,
    report: *mut selfcal_report_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(report)?) };
        let solved = instance.solved.as_ref().ok_or(SELFCAL_ERROR_NO_REPORT)?;
        out.set((&solved.report).into());
        Ok(())
    })
}

/// Takes the solved pair into the estimate, once. What is in use does not change, unless
/// `selfcal_config_set_automatic_apply` lets it.
///
/// * `fused`: what became of it; may be null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_fuse(
    cal: *mut selfcal_t,
    fused: *mut selfcal_fused_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, fused) = unsafe { (instance(cal)?, Out::optional(fused)?) };
        let solved = instance.solved.as_mut().ok_or(SELFCAL_ERROR_NO_REPORT)?;
        if solved.fused {
            return Err(SELFCAL_ERROR_FUSE_STALE);
        }
        fused.set(instance.calibrator.fuse()?.into());
        solved.fused = true;
        Ok(())
    })
}

/// Empties the batch, forgets the report and abandons a pair being solved.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_clear_pair(cal: *mut selfcal_t) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let instance = unsafe { instance(cal) }?;
        instance.solved = None;
        instance.calibrator.clear_pair();
        Ok(())
    })
}

/// A `selfcal_stop_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_stop_string(stop: u32) -> *const c_char {
    find(STOPS, stop)
}

/// A `selfcal_fused_t` in words, English; never null.
#[unsafe(no_mangle)]
pub extern "C" fn selfcal_fused_string(fused: u32) -> *const c_char {
    find(FUSED, fused)
}
