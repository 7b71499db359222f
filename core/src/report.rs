//! What one pair says, and the pass over its batch that judges the solution.

use crate::correspondence::RayPair;
use crate::extrinsics::Extrinsics;
use crate::information::Information;
use crate::rectification::RectifyingRotations;
use crate::residual::{linearised, row_offset};
use crate::scalar::Scalar;
use crate::supervision::{Finding, Lineage};

/// Correspondences within this many Huber thresholds count as screened.
pub(crate) const SCREEN: f64 = 3.0;

/// Why the solver stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum Stop {
    /// The step fell below the tolerance, or below what the scalar resolves of the optimum.
    Converged,
    /// No step lowers the cost any more: the optimum to the resolution of the scalar.
    NoDescent,
    /// The allowed passes are used up; the estimate is the best pose seen.
    PassLimit,
}

codes! { Stop { Converged = 0, NoDescent = 1, PassLimit = 2 } }

/// What one pair says.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct PairReport<T: Scalar> {
    /// `R`, `t` of the pair.
    pub extrinsics: Extrinsics<T>,
    /// Information about them, 1/rad^2: inverse covariance of the M-estimate, without the prior.
    /// Nothing about the baseline where disparities are mostly noise.
    pub information: Information<T>,
    /// Why the solver stopped.
    pub stop: Stop,
    /// Passes taken. Paper: the judging one not counted. Robust: all of them.
    pub passes: u16,
    /// Correspondences in front of both rectified cameras.
    pub usable: u32,
    /// Correspondences left out because they are not.
    pub skipped: u32,
    /// Usable correspondences within 3 Huber thresholds of the solution, or within Tukey's limit.
    pub screened: u32,
    /// Cost at the start under the loss of the solution, px^2.
    pub cost_before: T,
    /// Cost at the solution, px^2.
    pub cost_after: T,
    /// RMS row offset of the screened correspondences at the start, px; 0 if there are none.
    pub rms_px_before: T,
    /// RMS row offset of the same correspondences at the solution, px.
    pub rms_px_after: T,
    /// Standard deviation of the row offsets, estimated from the residuals, px. Paper: of
    /// the row offsets, each clipped at the Huber threshold. Robust: of one coordinate, at most 3.
    pub noise_px: T,
    /// Robust: which of the calibrator's findings this is about.
    pub(crate) round: Option<u32>,
}

impl<T: Scalar> PairReport<T> {
    /// Of the robust preset; `None` if the pair alone has no optimum.
    ///
    /// * `focal`: px.
    #[inline(never)]
    pub(crate) fn of_finding(
        finding: &Finding<'_, T>,
        lineage: &Lineage<T>,
        focal: T,
    ) -> Option<Self> {
        let judged = finding.judged;
        let evidence = &judged.evidence;
        let seen = evidence.moments.at_frame();
        let pose = evidence.pose.stepped_by(&seen.pulled(lineage.prior).step()?)?;
        let tally = &judged.tally;
        let count = T::count(tally.screened.max(1));
        let [squares_before, squares_after] = tally.squares.map(|sum| sum * focal * focal);
        let [cost_before, cost_after] = tally.cost.map(|sum| sum * focal * focal);
        Some(Self {
            extrinsics: pose.extrinsics().ok()?,
            information: seen.information,
            stop: finding.stop,
            passes: finding.passes,
            usable: tally.usable,
            skipped: tally.skipped,
            screened: tally.screened,
            cost_before: cost_before * T::HALF,
            cost_after: cost_after * T::HALF,
            rms_px_before: (squares_before / count).sqrt(),
            rms_px_after: (squares_after / count).sqrt(),
            noise_px: evidence.noise,
            round: Some(finding.round),
        })
    }
}

/// Sums of the judging pass.
#[derive(Debug)]
pub(crate) struct Judgement<T> {
    pub(crate) information: Information<T>,
    pub(crate) inliers: u32,
    pub(crate) clipped_squares: T,
    pub(crate) screened: u32,
    pub(crate) squares_before: T,
    pub(crate) squares_after: T,
}

impl<T: Scalar> Judgement<T> {
    pub(crate) fn over(
        pairs: &[RayPair<T>],
        start: &RectifyingRotations<T>,
        pose: &RectifyingRotations<T>,
        threshold: T,
    ) -> Self {
        let gauge_slope = pose.gauge_slope();
        let mut sums = Self {
            information: Information::ZERO,
            inliers: 0,
            clipped_squares: T::ZERO,
            screened: 0,
            squares_before: T::ZERO,
            squares_after: T::ZERO,
        };
        for pair in pairs {
            let Some(row) = linearised(pose, gauge_slope, pair) else {
                continue;
            };
            let size = row.offset.abs();
            let clipped = size.min(threshold);
            sums.clipped_squares += clipped * clipped;
            if size <= threshold {
                sums.information.add_outer(T::ONE, &row.jacobian);
                sums.inliers = sums.inliers.saturating_add(1);
            }
            if size <= T::lit(SCREEN) * threshold
                && let Some(before) = row_offset(start, pair)
            {
                sums.screened = sums.screened.saturating_add(1);
                sums.squares_before += before * before;
                sums.squares_after += size * size;
            }
        }
        sums
    }
}
