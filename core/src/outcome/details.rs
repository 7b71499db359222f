//! Comparison of the calibration in use with the estimate over the last pair, in detail, and the depth error.

use core::fmt;

use crate::batch::correspondence::RayPair;
use crate::depth::pose::MountPose;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::outcome::proposal::Proposal;
use crate::outcome::robust_rms::SquaresBySize;
use crate::outcome::rows_of::RowsOf;
use crate::scalar::Scalar;
use crate::thresholds::{FIRST_ROW_LEVEL, NAMED_ROWS_PX};

/// Distances that the depth error is predicted for, m.
pub const DEPTHS_M: [f64; 4] = [1.0, 2.0, 5.0, 10.0];

/// The calibration in use and the estimate over the matches of the batch, for logs and plots.
/// [`Verdict`](crate::Verdict) has what a vehicle needs.
///
/// Both RMS values are over the same matches: the matches that fit the estimate. Read the counts with them: an estimate
/// that fits fewer matches is worse, even if its RMS is smaller.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct Details<T> {
    /// RMS row offset of the extrinsics in use, px; 0 is perfect. Row offsets far beyond the median are clipped,
    /// because a mismatch that fits one calibration by chance may have any row offset under the other.
    pub in_use_px: T,
    /// RMS row offset of the proposed extrinsics, px.
    pub proposed_px: T,
    /// RMS difference between the row offsets in use and proposed, px: the error of the extrinsics in use, without
    /// noise and vibration.
    pub off_px: T,
    /// Number of matches whose row offset with the extrinsics in use is within the limit of a fit
    /// ([`crate::Config::with_fit_limit_px`]).
    pub fit_in_use: u32,
    /// The same number with the proposed extrinsics. Both RMS values are over these matches.
    pub fit_proposed: u32,
    /// Row offset, px, that the apparent yaw of the lenses ([`Proposal::lens_yaw`]) leaves in the image corner that is
    /// furthest from the principal point. Extrinsics that are right for depth leave row offsets of `a x y` for an
    /// apparent yaw `a`, so both RMS values exclude these offsets. A matcher that searches along rows meets these
    /// offsets, unless its rectification removes them.
    pub corner_px: T,
    /// Expected error of the yaw in use, rad: root of the sum of its squared distance from the estimate and the
    /// variance of the estimate.
    pub yaw: T,
    /// Number of range readings ([`crate::Calibrator::push_range`]) since the last reset that contradicted the yaw:
    /// they were refused, or they had to wait for further readings that agree. Saturates.
    pub contradicting_ranges: u16,
    /// The same number for motions of tracked matches.
    pub contradicting_motions: u16,
}

impl<T: Scalar> fmt::Display for Details<T> {
    /// Writes one line: `0.91 px in use, 0.31 px proposed, 12 and 250 fit`. Contradictions and row offsets of the lens
    /// follow, if there are any.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { in_use_px, proposed_px, fit_in_use, fit_proposed, .. } = self;
        write!(f, "{in_use_px:.2} px in use, {proposed_px:.2} px proposed, ")?;
        write!(f, "{fit_in_use} and {fit_proposed} fit")?;
        let [ranges, motions] = [self.contradicting_ranges, self.contradicting_motions];
        if ranges > 0 || motions > 0 {
            write!(f, ", contradicted by {ranges} ranges and {motions} motions")?;
        }
        if self.corner_px >= T::lit(NAMED_ROWS_PX) {
            write!(f, ", lens: rows off by {:.1} px at the corners", self.corner_px)?;
        }
        Ok(())
    }
}

impl<T: Scalar> Details<T> {
    /// Returns the expected errors of depth with the extrinsics in use, m, at [`DEPTHS_M`] in the middle of the image.
    /// The error is `Z^2 / b` times the error of yaw, which shifts all disparities. The focal length cancels.
    ///
    /// * `baseline_m`: length of the baseline, m; above 0.
    ///
    /// The noise of the matcher and the error of the baseline length are not included.
    #[must_use]
    pub fn depth_errors(&self, baseline_m: T) -> [T; 4] {
        DEPTHS_M.map(|z| T::lit(z * z) * self.yaw / baseline_m)
    }

    /// Compares the calibration in use with the proposed one over a batch, in one pass. Returns `None` if no match fits
    /// the proposed one, or if a calibration cannot be turned by the yaw of the lens.
    ///
    /// * `rays`: correction of the cameras that the rays of the batch belong to.
    /// * `contradicting`: numbers of range readings and of motions that contradicted the yaw.
    /// * `focal`: mean focal length, px.
    /// * `corner`: largest product `x y` of a ray of the right image, at unit depth, dimensionless.
    /// * `screen_px`: largest row offset of a match that fits, px.
    // Out of line, so that its stack is separate from the stack of the proposal.
    #[inline(never)]
    pub(crate) fn over(
        matches: &[RayPair<T>],
        rays: &LensCorrection<T>,
        in_use: &CorrectedExtrinsics<T>,
        proposal: &Proposal<T>,
        [contradicting_ranges, contradicting_motions]: [u16; 2],
        [focal, corner]: [T; 2],
        screen_px: T,
    ) -> Option<Self> {
        let lens_yaw = proposal.lens_yaw.value;
        let [used, proposed] = [&in_use.extrinsics, &proposal.extrinsics].map(MountPose::from);
        let rows = [
            RowsOf::new(&used, &in_use.correction, rays, lens_yaw)?,
            RowsOf::new(&proposed, &proposal.correction, rays, lens_yaw)?,
        ];
        let fit = Fit::of(matches, &rows, screen_px / focal)?;
        let [in_use_px, proposed_px, off_px] = fit.rms.map(|rms| rms * focal);
        let [fit_in_use, fit_proposed] = fit.matches;
        let off = proposed.rotations().unknowns_to(used.rotations());
        let yaw_sd = proposal.covariance_lens.m22.sqrt();
        Some(Self {
            in_use_px,
            proposed_px,
            off_px,
            fit_in_use,
            fit_proposed,
            corner_px: lens_yaw.abs() * focal * corner,
            yaw: (off.y * off.y + yaw_sd * yaw_sd).sqrt(),
            contradicting_ranges,
            contradicting_motions,
        })
    }
}

/// Fit of the calibration in use and of the proposed one to the same matches.
struct Fit<T> {
    /// Numbers of matches within the screening threshold, in use and proposed.
    matches: [u32; 2],
    /// RMS of the row offsets in use, of the proposed ones, and of their difference, over the matches that fit the
    /// proposed calibration; at unit focal length.
    rms: [T; 3],
}

impl<T: Scalar> Fit<T> {
    /// Returns the fit over matches; `None` if no match fits the proposed calibration.
    ///
    /// * `calibrations`: in use, and proposed.
    /// * `screen`: largest row offset of a match that fits, at unit focal length.
    fn of(matches: &[RayPair<T>], calibrations: &[RowsOf<T>; 2], screen: T) -> Option<Self> {
        let [mut in_use, mut proposed] = [0_u32; 2];
        let mut squares = [SquaresBySize::none(screen * T::lit(FIRST_ROW_LEVEL)); 3];
        for pair in matches {
            let [used, new] = calibrations.each_ref().map(|rows| rows.offset(pair));
            let Some((used, new)) = used.zip(new) else { continue };
            in_use = in_use.saturating_add(u32::from(used.abs() <= screen));
            if new.abs() <= screen {
                proposed = proposed.saturating_add(1);
                for (squares, offset) in squares.iter_mut().zip([used, new, used - new]) {
                    squares.add(offset);
                }
            }
        }
        let rms = squares.map(|squares| squares.rms());
        (proposed > 0).then_some(Self { matches: [in_use, proposed], rms })
    }
}
