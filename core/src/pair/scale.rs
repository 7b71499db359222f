//! Scale selection: the smallest level that the residuals of many correspondences stay below (`ESTIMATOR.md`, section
//! 5).
//!
//! The residuals of inliers form a peak at zero at any noise level, while those of outliers are flat around zero.
//! Counts below a ladder of levels show the peak before the noise is known.

use core::f64::consts::SQRT_2;

use super::leverage::form_peak;
use crate::scalar::Scalar;
use crate::thresholds::{
    CERTAIN_SHARE, FIRST_LEVEL_PX, LEVELS, NARROW_PX, PEAK_OVER_BESIDE, PEAK_SHARE,
};

/// Histogram of whitened residuals: each correspondence counts at the lowest level above its residual. The first level
/// is [`FIRST_LEVEL_PX`]; each further level is `sqrt 2` times the previous one.
#[derive(Debug, Clone, Copy)]
pub(super) struct LevelCounts<T>([T; LEVELS]);

/// A peak of residuals at zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Peak<T> {
    /// Width of the peak, px: about one standard deviation of the inliers.
    pub(super) level: T,
    /// Share of the usable correspondences with residuals below twice the width.
    share: T,
}

impl<T: Scalar> Peak<T> {
    /// Returns whether the peak may consist of only a few matches, or lie between two crowds of matches that fit
    /// different poses.
    ///
    /// * `is_small`: whether the batch is small. In small batches, wrong poses fit by chance more often.
    pub(super) fn is_doubtful(&self, is_small: bool) -> bool {
        let [certain, of_small] = CERTAIN_SHARE.map(T::lit);
        // A wide peak is caused by noise, or by two crowds within the peak.
        self.share < if is_small { of_small } else { certain } || self.level > T::lit(NARROW_PX)
    }
}

impl<T: Scalar> LevelCounts<T> {
    pub(super) const NONE: Self = Self([T::ZERO; LEVELS]);

    /// Counts a residual.
    ///
    /// * `squared`: squared whitened residual, px^2.
    pub(super) fn add(&mut self, squared: T) {
        let level = squared.doublings_of(T::lit(FIRST_LEVEL_PX * FIRST_LEVEL_PX));
        if let Some(count) = self.0.get_mut(level) {
            *count += T::ONE;
        }
    }

    /// Returns the number of correspondences below each level.
    fn below(mut self) -> [T; LEVELS] {
        let mut below = T::ZERO;
        for count in &mut self.0 {
            below += *count;
            *count = below;
        }
        self.0
    }

    /// Returns the peak at the smallest level with enough residuals below it: at least `needed`, and at least the part
    /// [`PEAK_SHARE`] of the usable correspondences. Their number must also be at least [`PEAK_OVER_BESIDE`] times the
    /// number from this level to twice this level, and must exceed it by more than chance ([`form_peak`]). `None` if no
    /// level up to half of the last one meets these conditions.
    ///
    /// * `needed`: least number of residuals below the level; `usable`: number of usable correspondences.
    pub(super) fn peak(&self, needed: u16, usable: T) -> Option<Peak<T>> {
        let least = T::count(needed.into()).max(T::lit(PEAK_SHARE) * usable);
        let mut level = T::lit(FIRST_LEVEL_PX);
        let below = self.below();
        for (near, around) in below.iter().zip(below.iter().skip(2)) {
            let beside = *around - *near;
            if *near >= least
                && *near >= T::lit(PEAK_OVER_BESIDE) * beside
                && form_peak([*near, beside])
            {
                return Some(Peak { level, share: *around / usable.max(T::ONE) });
            }
            level *= T::lit(SQRT_2);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts residuals, px.
    fn counts(residuals: impl Iterator<Item = f64>) -> LevelCounts<f64> {
        let mut counts = LevelCounts::NONE;
        residuals.for_each(|r| counts.add(r * r));
        counts
    }

    /// Returns `n` residuals at the quantiles of a normal distribution (logistic approximation).
    fn normal(n: u32, sd: f64) -> impl Iterator<Item = f64> {
        (0..n).map(move |i| {
            let p = (f64::from(i) + 0.5) / f64::from(n);
            sd * (p / (1.0 - p)).ln() / 1.702
        })
    }

    /// Returns `n` residuals, px, evenly spaced from 0 to `limit`.
    fn flat(n: u32, limit: f64) -> impl Iterator<Item = f64> {
        (0..n).map(move |i| limit * (f64::from(i) + 0.5) / f64::from(n))
    }

    #[test]
    fn a_residual_counts_below_each_level_above_it_and_nan_below_no_level() {
        let squares: [f32; 11] =
            [0.0, 0.06, 0.0625, 0.0624, 0.1, 256.0, 255.9, 300.0, 1e30, f32::NAN, -0.0];
        let mut counts = LevelCounts::NONE;
        for squared in squares {
            counts.add(squared);
        }
        let mut level = 0.0625;
        for below in counts.below() {
            let expected = squares.iter().filter(|squared| **squared < level).count();
            assert_eq!(usize::from(below.to_u16()), expected, "{level}");
            level *= 2.0;
        }
    }

    #[test]
    fn the_peak_is_about_one_deviation_of_inliers_wide() {
        for (sd, outliers) in [(0.3, 0), (0.3, 128), (1.0, 77), (4.0_f64, 77)] {
            let seen = counts(normal(256 - outliers, sd).chain(flat(outliers, 60.0)));
            let peak = seen.peak(12, 256.0).unwrap().level;
            assert!((0.8..2.0).contains(&(peak / sd)), "{sd} {outliers}: {peak}");
        }
        let narrow = counts(normal(256, 0.02)).peak(12, 256.0).unwrap();
        assert_eq!(narrow, Peak { level: FIRST_LEVEL_PX, share: 1.0 });
        assert!(!narrow.is_doubtful(false));
    }

    #[test]
    fn outliers_and_few_residuals_form_no_peak() {
        assert_eq!(counts(flat(256, 60.0)).peak(12, 256.0), None);
        assert_eq!(counts(normal(11, 0.3)).peak(12, 11.0), None);
        assert_eq!(counts(normal(40, 0.3).chain(flat(216, 200.0))).peak(12, 256.0), None);
        assert!(counts(normal(70, 0.3).chain(flat(186, 200.0))).peak(12, 256.0).is_some());
    }

    #[test]
    fn two_crowds_are_a_wide_peak_between_them_and_a_narrow_one_at_either() {
        let crowds = |at: f64| {
            let other = normal(80, 0.3).map(move |r| r + 8.0 - at);
            counts(normal(176, 0.3).map(move |r| r - at).chain(other))
        };
        let between = crowds(3.0).peak(12, 256.0).unwrap();
        assert!(between.level > 3.0 && between.is_doubtful(false));
        let [larger, smaller] = [0.0, 8.0].map(|at| crowds(at).peak(12, 256.0).unwrap());
        assert!(larger.level < 0.6 && !larger.is_doubtful(false) && larger.is_doubtful(true));
        assert!(smaller.level < 0.6 && smaller.is_doubtful(false));
    }
}
