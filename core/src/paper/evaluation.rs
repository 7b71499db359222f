//! Last pass over a pair in the published method: the sums that give noise and information at the solution, and the RMS
//! row offsets at start and solution.

use super::residual::linearised;
use crate::algebra::information::Information;
use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::row_offset;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::SCREEN;

/// Sums of the evaluation; row offsets at unit depth.
#[derive(Debug)]
pub(super) struct Evaluation<T> {
    /// Information of the inliers, for row offsets of variance 1.
    pub(super) information: Information<T>,
    /// Number of row offsets within the Huber threshold.
    pub(super) inliers: u32,
    /// Sum of the squared row offsets, each clipped to the threshold.
    pub(super) clipped_squares: T,
    /// Numbers of points clearly in front of the cameras and clearly behind them. Outliers count too, because Huber's
    /// loss depends on all correspondences.
    pub(super) sides: [u32; 2],
    /// Number of correspondences that have a row offset at the start, and one within [`SCREEN`] thresholds at the
    /// solution; and sums of their squared row offsets at start and solution.
    pub(super) screened: u32,
    pub(super) squares_before: T,
    pub(super) squares_after: T,
}

impl<T: Scalar> Evaluation<T> {
    /// Returns the sums over a batch.
    ///
    /// * `threshold`: threshold of Huber's loss, at unit depth.
    /// * `least`: least disparity, at unit depth, of a point clearly in front of the cameras. A point with a disparity
    ///   of at most `-least` is clearly behind them.
    pub(super) fn over(
        pairs: &[RayPair<T>],
        start: &RectifyingRotations<T>,
        pose: &RectifyingRotations<T>,
        threshold: T,
        least: T,
    ) -> Self {
        let gauge_slope = pose.gauge_slope();
        let mut sums = Self {
            information: Information::ZERO,
            inliers: 0,
            sides: [0; 2],
            clipped_squares: T::ZERO,
            screened: 0,
            squares_before: T::ZERO,
            squares_after: T::ZERO,
        };
        for pair in pairs {
            let Some(row) = linearised(pose, gauge_slope, pair) else {
                continue;
            };
            let [.., disparity] = row.jacobian;
            let [ahead, behind] = &mut sums.sides;
            *ahead = ahead.saturating_add(u32::from(disparity >= least));
            *behind = behind.saturating_add(u32::from(-disparity >= least));
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
