//! The verdict after a pair: rows, depth and coverage of the calibration in use, and whether the rig may arm
//! (`ESTIMATOR.md`, section 16).

use core::fmt;

use crate::outcome::cause::Cause;
use crate::outcome::reasons::{Reason, Reasons};
use crate::scalar::Scalar;
use crate::state::State;

/// Judgement of the calibration in use by the last pairs. It is computed once when a pair ends, and kept until the next
/// pair ends.
///
/// `rows_px` and both coverages are of the last pair that was solved; they are infinite and 0 before the first one.
/// `depth_px` is infinite without an estimate.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{Calibration, Calibrator, Correspondence};
///
/// /// Takes a pair; returns whether the vehicle may arm.
/// fn take<const N: usize>(rig: &mut Calibrator<f32, N>, matches: &[Correspondence<f32>]) -> bool {
///     let _ = rig.take_pair(matches.iter().copied());
///     if rig.verdict().should_apply {
///         let _ = rig.apply(); // then load the rectifier with `in_use`
///     }
///     rig.verdict().may_arm
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[expect(clippy::struct_excessive_bools, reason = "each answers a question of its own")]
#[non_exhaustive]
pub struct Verdict<T> {
    /// RMS row offset, px, of the calibration in use beyond that of the pair's own pose, over the matches that fit the
    /// latter. Noise of the matcher does not count; vibration does.
    pub rows_px: T,
    /// Expected RMS error of the disparities with the calibration in use, px: the distance from the estimate, and its
    /// deviation with the lens models uncertain. The error of depth `Z` is `Z^2 / (f b)` times this.
    pub depth_px: T,
    /// Share of the matches that fit the calibration in use, among those that fit the pair's own pose, 0 to 1.
    pub coverage: T,
    /// Share of the cells of an 8 x 6 grid over the left image with a match that fits the pair's own pose, 0 to 1.
    pub image_coverage: T,
    /// Whether `rows_px` is within [`crate::Config::with_rows_limit_px`].
    pub rows_ok: bool,
    /// Whether `depth_px` is within [`crate::Config::with_depth_limit_px`].
    pub depth_ok: bool,
    /// Answer to an arming check. True if the estimate has been confirmed, the calibration in use has fitted two pairs
    /// in a row and no two in a row failed since, the estimate has not rejected five in a row, depth is within its
    /// limit, and no reason forbids it.
    pub may_arm: bool,
    /// Whether [`crate::Calibrator::apply`] is worthwhile: the estimate is locked and clearly better than the
    /// calibration in use, and no mistake of the setup is named ([`Verdict::cause`]).
    pub should_apply: bool,
    /// Reliability of the estimate.
    pub state: State,
    /// Reasons not to rely on the calibration in use. There is at least one if the rig must not arm.
    pub reasons: Reasons,
    /// The likeliest mistake in rig file or matcher that the pairs, the matches or the estimate show.
    pub cause: Option<Cause>,
}

impl<T: Scalar> Verdict<T> {
    /// Before any pair.
    pub(crate) const NONE: Self = Self {
        rows_px: T::INFINITY,
        depth_px: T::INFINITY,
        coverage: T::ZERO,
        image_coverage: T::ZERO,
        rows_ok: false,
        depth_ok: false,
        may_arm: false,
        should_apply: false,
        state: State::Acquiring,
        reasons: Reasons::NONE.with(Reason::NotLocked, true),
        cause: None,
    };

    /// Forbids arming, because no pair has confirmed the calibration in use.
    pub(crate) fn disarm(&mut self) {
        self.may_arm = false;
        self.reasons = self.reasons.with(Reason::Evidence, true);
    }
}

impl<T: Scalar> fmt::Display for Verdict<T> {
    /// Writes one line: `rows 0.4 px, depth 1.0 px, coverage 0.96: may arm`. Reasons and the cause follow.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows_px, depth_px, coverage, reasons, .. } = self;
        let arming = if self.may_arm { "may arm" } else { "must not arm" };
        write!(
            f,
            "rows {rows_px:.1} px, depth {depth_px:.1} px, coverage {coverage:.2}: {arming}"
        )?;
        if self.should_apply {
            f.write_str(", should apply")?;
        }
        if !reasons.is_empty() {
            write!(f, ", against it: {reasons}")?;
        }
        self.cause.map_or(Ok(()), |cause| write!(f, ", likely cause: {cause}"))
    }
}
