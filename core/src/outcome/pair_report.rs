//! Result of one pair, and its effect on the estimate.

use core::fmt;

use crate::algebra::information::Information;
use crate::error::Rejection;
use crate::geometry::extrinsics::Extrinsics;
use crate::scalar::Scalar;
use crate::state::Stop;

/// Result of one pair.
///
/// It is the rig at the moment of the pair. A rig that bends all the time has no estimate over many pairs, and each
/// image pair is rectified with the extrinsics of its own report; [`Self::information`] says how well they are known.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct PairReport<T: Scalar> {
    /// `R`, `t` of the pair. They make its rows equal, so their yaw contains the apparent yaw of the lenses
    /// ([`crate::Proposal::lens_yaw`]).
    pub extrinsics: Extrinsics<T>,
    /// Information on `R`, `t`, 1/rad^2: inverse covariance of the M-estimate, without the prior. The information on
    /// the baseline is 0 if the disparities are only noise; the published method refuses such a pair.
    pub information: Information<T>,
    /// Why the solver stopped.
    pub stop: Stop,
    /// Number of passes taken. The published method does not count the evaluation pass.
    pub passes: u16,
    /// Number of correspondences in front of both rectified cameras.
    pub usable: u32,
    /// Number of correspondences that are left out, because they are not in front of both rectified cameras.
    pub skipped: u32,
    /// Number of usable correspondences that fit the solution and are in front of both cameras at the start. They fit
    /// within Tukey's limit, or in the published method within 3 Huber thresholds.
    pub screened: u32,
    /// Cost at the start, computed with the loss of the solution, px^2.
    pub cost_before: T,
    /// Cost at the solution, px^2.
    pub cost_after: T,
    /// RMS row offset of the screened correspondences at the start, px; 0 without any.
    pub rms_px_before: T,
    /// RMS row offset of the same correspondences at the solution, px.
    pub rms_px_after: T,
    /// Standard deviation of the noise, estimated from the residuals, px: of one coordinate, at most 5.5. In the
    /// published method: of the row offsets, each clipped at the Huber threshold.
    pub noise_px: T,
}

impl<T: Scalar> fmt::Display for PairReport<T> {
    /// Writes one line: extrinsics, row offsets before and after, noise, counts and passes. The reason of the stop
    /// follows, unless the pair took all its passes, as tracked pairs usually do.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { extrinsics, rms_px_before, rms_px_after, noise_px, .. } = self;
        let Self { screened, usable, skipped, passes, stop, .. } = self;
        write!(
            f,
            "{extrinsics}: {rms_px_before:.2} to {rms_px_after:.2} px, noise {noise_px:.2} px, "
        )?;
        write!(f, "{screened} of {usable} fit, {skipped} skipped, {passes} passes")?;
        match stop {
            Stop::PassesSpent => Ok(()),
            Stop::Converged | Stop::NoDescent => write!(f, ", {stop}"),
        }
    }
}

/// Outcome of one pair.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[must_use]
pub struct Outcome<T: Scalar> {
    /// Result of the pair alone; `None` if the pair could not be solved.
    pub pair: Option<PairReport<T>>,
    /// Effect on the estimate, or why the pair was not fused.
    pub fused: Result<Fused, Rejection>,
}

impl<T: Scalar> fmt::Display for Outcome<T> {
    /// Writes the effect, such as `added`, or `not fused: ` and the reason.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.fused {
            Ok(fused) => fused.fmt(f),
            Err(why) => write!(f, "not fused: {why}"),
        }
    }
}

/// Effect of a pair on the estimate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Fused {
    /// The pair is part of the estimate. It counts by how far the scene has moved since the last pair that was added.
    Added,
    /// The scene has hardly moved since the last pair that was added, and the pair adds nothing.
    Repeated,
    /// The pair disagrees with the estimate, and is part of the challenger. A challenger that three pairs confirm ends
    /// with this pair if its extrinsics agree with the estimate after all.
    KeptApart,
    /// The pair is part of the estimate, and the last pairs have replaced the older ones: the rig has drifted, or has
    /// moved by less than a single pair shows.
    Renewed,
    /// The challenger, with this pair, has become the estimate.
    TookOver,
    /// The pairs show other lens models than the given ones: the estimate begins again with corrected cameras
    /// ([`crate::LensTracking::Compensate`]). The batch is emptied, because its rays belong to the old cameras.
    LensCorrected,
}

codes! { Fused { Added = 0, Repeated = 1, KeptApart = 2, Renewed = 3, TookOver = 4, LensCorrected = 5 } }
texts! {
    Fused {
        Added = "added", Repeated = "repeated", KeptApart = "kept apart", Renewed = "renewed",
        TookOver = "took over", LensCorrected = "lens corrected",
    }
}
