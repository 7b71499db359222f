//! Comparison of the calibration in use with the estimate over the last pair, the arming check, and the depth error.

use core::fmt;

use nalgebra::{Vector2, Vector3};
use thiserror::Error;

use crate::batch::Batch;
use crate::batch::grid::CellSet;
use crate::batch::row_offset::row_offset;
use crate::error::{NO_ESTIMATE, NO_MATCH, Rejection};
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection, RayChange};
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::cause::Cause;
use crate::outcome::proposal::Proposal;
use crate::outcome::reasons::{Reason, Reasons};
use crate::outcome::robust_rms::SquaresBySize;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{BAD_PX, FIRST_ROW_LEVEL, IMPROVEMENT};

/// Least row offset in a corner of the image that the text names, px.
const NAMED_ROWS_PX: f64 = 0.1;

/// Distances that the depth error is predicted for, m.
pub const DEPTHS_M: [f64; 4] = [1.0, 2.0, 5.0, 10.0];

/// Quality of the calibration in use and of the proposed one, over the matches of the batch.
///
/// Both RMS values are over the same matches: the matches that fit the estimate. Read the counts with them: an estimate
/// that fits fewer matches is worse, even if its RMS is smaller.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{Band, Calibrator};
///
/// fn check<const N: usize>(calibrator: &Calibrator<f32, N>, baseline_m: f32) -> bool {
///     let Ok(health) = calibrator.health() else {
///         return false; // no fused pair, or no match that fits
///     };
///     if health.band == Band::Recalibrate {
///         // A matcher that searches along rows fails now: apply, or stop.
///     }
///     if let Some([_, _, _, at_10_m]) = health.depth_errors(baseline_m) {
///         // Expected error of depth at 10 m, m.
///         # let _ = at_10_m;
///     }
///     health.may_arm()
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Health<T: Scalar> {
    /// RMS row offset of the extrinsics in use, px; 0 is perfect. Row offsets far beyond the median are clipped,
    /// because a mismatch that fits one calibration by chance may have any row offset under the other.
    pub in_use_px: T,
    /// RMS row offset of the proposed extrinsics, px.
    pub proposed_px: T,
    /// RMS difference between the row offsets in use and proposed, px: the error of the extrinsics in use, without
    /// noise and vibration.
    pub off_px: T,
    /// Number of matches whose row offset with the extrinsics in use is within the screening threshold
    /// ([`crate::Config::with_huber_threshold_px`]).
    pub fit_in_use: u32,
    /// The same number with the proposed extrinsics. Both RMS values are over these matches.
    pub fit_proposed: u32,
    /// Share of the cells with a match that fits the estimate, 0 to 1, in an 8 x 6 grid over the left image. In the
    /// other cells nothing tests the calibration.
    pub coverage: T,
    /// Rating of the extrinsics in use.
    pub band: Band,
    /// Reliability of the estimate.
    pub state: State,
    /// Row offset, px, that the apparent yaw of the lenses ([`Proposal::lens_yaw`]) leaves in the image corner that is
    /// furthest from the principal point. Extrinsics that are right for depth leave row offsets of `a x y` for an
    /// apparent yaw `a`, so both RMS values exclude these offsets. A matcher that searches along rows meets these
    /// offsets, unless its rectification removes them.
    pub corner_px: T,
    /// Expected error of the yaw in use, rad: root of the sum of its squared distance from the estimate and the
    /// variance of the estimate.
    pub yaw: T,
    /// Why the last pair was not fused; `None` if it was, and while a pair is being solved.
    pub rejection: Option<Rejection>,
    /// The likeliest mistake in rig file or matcher that the pairs, the matches or the estimate show. If there is one,
    /// the numbers above say nothing about the calibration in use.
    pub cause: Option<Cause>,
    /// Number of range readings ([`crate::Calibrator::push_witness`]) since the last reset that contradicted the yaw:
    /// they were refused, or they had to wait for further readings that agree. Saturates.
    pub contradicting_ranges: u16,
    /// The same number for motions of tracked matches.
    pub contradicting_motions: u16,
    /// Reasons not to rely on the calibration in use; [`Health::may_arm`] answers an arming check. Vibration
    /// ([`Proposal::vibration`]) increases both RMS values, but does not count in the arming check.
    pub reasons: Reasons,
}

/// Outcome of the last pair, the mistakes that it shows, and the witnesses so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LastPair {
    /// Why the pair was not fused; `None` if it was.
    pub(crate) rejection: Option<Rejection>,
    /// Whether the pair showed the same scene as the pair before it.
    pub(crate) repeated: bool,
    /// Mistake that the matches of the pair, or the estimate, show.
    pub(crate) cause: Option<Cause>,
    /// Likeliest mistake according to the pairs since the estimate was last locked.
    pub(crate) likeliest: Option<Cause>,
    /// Numbers of range readings and of motions that contradicted the yaw.
    pub(crate) contradicting: [u16; 2],
}

/// Why there is no [`Health`], with the likeliest mistake in rig file or matcher. A mistake is named once four pairs
/// since the last lock have shown one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Error)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum NoHealth {
    /// There is no estimate: no pair has been fused, the fused pairs give no valid one, or it was dropped.
    #[error("no pair has been fused")]
    NoEstimate(Option<Cause>),
    /// The batch holds no match that fits the estimate. It is empty before the first pair after a restore.
    #[error("the batch holds no match that fits the estimate")]
    NoMatch(Option<Cause>),
}

impl NoHealth {
    /// Returns the likeliest mistake; `None` until four pairs have shown one.
    #[must_use]
    pub const fn cause(&self) -> Option<Cause> {
        match self {
            Self::NoEstimate(cause) | Self::NoMatch(cause) => *cause,
        }
    }
}

/// Rating of the extrinsics in use. The estimate is clearly better if it lowers the RMS row offset over all pairs by a
/// tenth and by more than chance, or if the row offsets in use and proposed differ by 1 px RMS or more. Where
/// [`Proposal::improves`] is `None`, it is clearly better if it lowers the RMS row offset over the batch by a tenth.
/// Noise of the matcher does not count as an error of the calibration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Band {
    /// The estimate is not clearly better. Row offsets of 1 px or more are then due to poor matches or lens models.
    Good,
    /// The RMS row offset in use is below 1 px, and the estimate is clearly better.
    Improvable,
    /// The RMS row offset in use is 1 px or more, and the estimate is clearly better: a matcher that searches along
    /// rows will miss.
    Recalibrate,
    /// The matches cannot rate the calibration, because of the mistake in [`Health::cause`].
    Unknown,
}

codes! {
    NoHealth { NoEstimate = NO_ESTIMATE, NoMatch = NO_MATCH }
    Band { Good = 0, Improvable = 1, Recalibrate = 2, Unknown = 255 }
}
texts! {
    Band {
        Good = "good", Improvable = "improvable", Recalibrate = "recalibrate", Unknown = "unknown",
    }
}

impl<T: Scalar> fmt::Display for Health<T> {
    /// Writes one line:
    /// `locked, improvable, may arm: 0.91 px in use, 0.31 px proposed, 12 and 250 fit, coverage 0.94, ...`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { state, band, in_use_px, proposed_px, .. } = self;
        let Self { fit_in_use, fit_proposed, coverage, reasons, .. } = self;
        let arming = if self.may_arm() { "may arm" } else { "must not arm" };
        write!(f, "{state}, {band}, {arming}: {in_use_px:.2} px in use, {proposed_px:.2} px ")?;
        write!(f, "proposed, {fit_in_use} and {fit_proposed} fit, coverage {coverage:.2}")?;
        if !reasons.is_empty() {
            write!(f, ", against it: {reasons}")?;
        }
        if let Some(cause) = self.cause {
            write!(f, ", likely cause: {cause}")?;
        }
        let [ranges, motions] = [self.contradicting_ranges, self.contradicting_motions];
        if ranges > 0 || motions > 0 {
            write!(f, ", contradicted by {ranges} ranges and {motions} motions")?;
        }
        if self.corner_px >= T::lit(NAMED_ROWS_PX) {
            write!(f, ", lens: rows off by {:.1} px at the corners", self.corner_px)?;
        }
        self.rejection.map_or(Ok(()), |why| write!(f, ", last pair {why}"))
    }
}

impl<T: Scalar> Health<T> {
    /// Returns the answer to an arming check: true if no reason forbids arming.
    #[must_use]
    pub const fn may_arm(&self) -> bool {
        !self.reasons.forbid_arming()
    }

    /// Returns the expected errors of depth with the extrinsics in use, m, at [`DEPTHS_M`] in the middle of the image;
    /// `None` unless the estimate is locked. The error is `Z^2 / b` times the error of yaw, which shifts all
    /// disparities. The focal length cancels.
    ///
    /// * `baseline_m`: length of the baseline, m; above 0.
    ///
    /// The noise of the matcher and the error of the baseline length are not included.
    #[must_use]
    pub fn depth_errors(&self, baseline_m: T) -> Option<[T; 4]> {
        let of = |z: f64| T::lit(z * z) * self.yaw / baseline_m;
        (self.state == State::Locked).then(|| DEPTHS_M.map(of))
    }

    /// Compares the calibration in use with the proposed one over a batch, in one pass. Returns `None` if no match fits
    /// the proposed one, or if a calibration cannot be turned by the yaw of the lens.
    ///
    /// * `rays`: correction of the cameras that the rays of the batch belong to.
    /// * `focal`: mean focal length, px.
    /// * `corner`: largest product `x y` of a ray of the right image, at unit depth, dimensionless.
    /// * `screen_px`: largest row offset of a match that fits, px.
    // Out of line, so that its stack is separate from the stack of the proposal.
    #[inline(never)]
    pub(crate) fn over<const N: usize>(
        batch: &Batch<T, N>,
        rays: &LensCorrection<T>,
        in_use: &CorrectedExtrinsics<T>,
        proposal: &Proposal<T>,
        last: LastPair,
        [focal, corner]: [T; 2],
        screen_px: T,
    ) -> Option<Self> {
        let changes = [in_use.correction, proposal.correction]
            .map(|correction| (correction != *rays).then(|| rays.change_to(&correction)));
        let in_use = RectifyingRotations::from(&in_use.extrinsics);
        let proposed = RectifyingRotations::from(&proposal.extrinsics);
        // Both calibrations are turned by the apparent yaw of the lens, so that its row offsets count against neither
        // of them.
        let of_rows = [with_lens(&in_use, proposal)?, with_lens(&proposed, proposal)?];
        let fit = Fit::of(batch, &of_rows, &changes, screen_px / focal)?;
        let [in_use_px, proposed_px, off_px] = fit.rms.map(|rms| rms * focal);
        let [fit_in_use, fit_proposed] = fit.matches;
        let misaligned = off_px >= T::lit(BAD_PX);
        let over_batch = proposed_px < in_use_px * T::lit(IMPROVEMENT);
        let improves = misaligned || proposal.improves.unwrap_or(over_batch);
        let off = proposed.unknowns_to(&in_use);
        let [contradicting_ranges, contradicting_motions] = last.contradicting;
        let yaw_sd = proposal.covariance_lens.map_or(proposal.sd.rotation, |c| c.m22.sqrt());
        Some(Self {
            in_use_px,
            proposed_px,
            off_px,
            fit_in_use,
            fit_proposed,
            coverage: fit.seen.share(),
            band: if last.cause.is_some() { Band::Unknown } else { Band::of(in_use_px, improves) },
            state: proposal.state,
            corner_px: proposal.lens_yaw.value.abs() * focal * corner,
            yaw: (off.y * off.y + yaw_sd * yaw_sd).sqrt(),
            rejection: last.rejection,
            cause: last.likeliest.or(last.cause),
            contradicting_ranges,
            contradicting_motions,
            reasons: proposal
                .reasons()
                .with(Reason::Misaligned, misaligned)
                .with(Reason::Repeated, last.repeated)
                .with(Reason::Unfit, last.cause.is_some()),
        })
    }
}

/// Returns rectifying rotations after a turn by the apparent yaw of the lens. With the yaw of the mount alone, the rows
/// of the images differ by `a x y`. `None` if the turn is too large.
fn with_lens<T: Scalar>(
    mount: &RectifyingRotations<T>,
    proposal: &Proposal<T>,
) -> Option<RectifyingRotations<T>> {
    let turn = proposal.lens_yaw.value;
    if turn == T::ZERO {
        return Some(*mount);
    }
    mount.stepped(&(Vector3::y() * turn), &Vector2::zeros())
}

/// Fit of the calibration in use and of the proposed one to the same matches.
struct Fit<T> {
    /// Numbers of matches within the screening threshold, in use and proposed.
    matches: [u32; 2],
    /// RMS of the row offsets in use, of the proposed ones, and of their difference, over the matches that fit the
    /// proposed calibration; at unit focal length.
    rms: [T; 3],
    /// Image cells with a match that fits the proposed calibration.
    seen: CellSet,
}

impl<T: Scalar> Fit<T> {
    /// Returns the fit over a batch; `None` if no match fits the proposed calibration.
    ///
    /// * `changes`: changes of the right rays from the cameras of the batch to the cameras of each calibration.
    /// * `screen`: largest row offset of a match that fits, at unit focal length.
    fn of<const N: usize>(
        batch: &Batch<T, N>,
        calibrations: &[RectifyingRotations<T>; 2],
        changes: &[Option<RayChange<T>>; 2],
        screen: T,
    ) -> Option<Self> {
        let ([mut in_use, mut proposed], mut seen) = ([0_u32; 2], CellSet::NONE);
        let mut squares = [SquaresBySize::none(screen * T::lit(FIRST_ROW_LEVEL)); 3];
        let [of_used, of_new] = calibrations;
        for pair in batch.pairs() {
            let [used, new] =
                changes.map(|change| change.map_or(*pair, |change| pair.changed(&change)));
            let (used, new) = (row_offset(of_used, &used), row_offset(of_new, &new));
            let Some((used, new)) = used.zip(new) else { continue };
            in_use = in_use.saturating_add(u32::from(used.abs() <= screen));
            if new.abs() <= screen {
                proposed = proposed.saturating_add(1);
                for (squares, offset) in squares.iter_mut().zip([used, new, used - new]) {
                    squares.add(offset);
                }
                seen.insert(pair.cell());
            }
        }
        let rms = squares.map(|squares| squares.rms());
        (proposed > 0).then_some(Self { matches: [in_use, proposed], rms, seen })
    }
}

impl Band {
    /// Returns the rating.
    ///
    /// * `in_use_px`: RMS row offset in use, px.
    /// * `improves`: whether the estimate is clearly better.
    fn of<T: Scalar>(in_use_px: T, improves: bool) -> Self {
        match (improves, in_use_px >= T::lit(BAD_PX)) {
            (false, _) => Self::Good,
            (true, false) => Self::Improvable,
            (true, true) => Self::Recalibrate,
        }
    }
}
