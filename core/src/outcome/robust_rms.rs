//! RMS with large values clipped, so that a few mismatches do not dominate it.

use crate::scalar::Scalar;
use crate::thresholds::{CLIPPED_LEVELS, ROW_LEVELS};

/// Squares of row offsets, sorted into levels of size: each level ends at twice the end of the previous one.
#[derive(Debug, Clone, Copy)]
pub(super) struct SquaresBySize<T> {
    /// Square of the end of the first level.
    first: T,
    /// Number and sum of the squares of each level; the last level has no upper end.
    levels: [(u16, T); ROW_LEVELS],
}

impl<T: Scalar> SquaresBySize<T> {
    /// Returns the sums without any row offset.
    ///
    /// * `first`: end of the first level, above 0, in the unit of the row offsets.
    pub(super) fn none(first: T) -> Self {
        Self { first: first * first, levels: [(0, T::ZERO); ROW_LEVELS] }
    }

    /// Adds a row offset.
    pub(super) fn add(&mut self, offset: T) {
        let squared = offset * offset;
        let level = (squared.doublings_of(self.first).saturating_add(1) / 2).min(ROW_LEVELS - 1);
        if let Some((count, sum)) = self.levels.get_mut(level) {
            *count = count.saturating_add(1);
            *sum += squared;
        }
    }

    /// Returns the RMS; 0 without row offsets. Row offsets are clipped at 4 times the end of the level of the median.
    pub(super) fn rms(&self) -> T {
        let all: u32 = self.levels.iter().map(|(count, _)| u32::from(*count)).sum();
        let (mut end, mut below, mut kept) = (self.first, 0_u32, CLIPPED_LEVELS);
        let mut sum = T::ZERO;
        for (count, squares) in &self.levels {
            sum += if kept > 0 { *squares } else { T::count((*count).into()) * end };
            below = below.saturating_add((*count).into());
            let is_beyond_median = below.saturating_mul(2) > all;
            kept = if is_beyond_median { kept.saturating_sub(1) } else { kept };
            if kept > 0 {
                end *= T::lit(4.0);
            }
        }
        (sum / T::count(all.max(1))).sqrt()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::vec::Vec;

    fn rms(offsets: &[f64]) -> f64 {
        let mut squares = SquaresBySize::none(0.01);
        for offset in offsets {
            squares.add(*offset);
        }
        squares.rms()
    }

    /// Returns approximate quantiles of the standard normal distribution.
    fn normal(n: u32) -> Vec<f64> {
        let one = |i: u32| {
            let p = (f64::from(i) + 0.5) / f64::from(n);
            (p / (1.0 - p)).ln() / 1.702
        };
        (0..n).map(one).collect()
    }

    #[test]
    fn the_robust_rms_is_the_rms_if_no_offset_is_far_beyond_the_median() {
        assert_eq!((rms(&[]), rms(&[0.0; 9]), rms(&[0.5])), (0.0, 0.0, 0.5));
        for scale in [1e-3, 0.03, 0.4, 1.0, 25.0, 700.0] {
            let all: Vec<_> = normal(200).iter().map(|x| scale * x).collect();
            let plain = (all.iter().map(|x| x * x).sum::<f64>() / 200.0).sqrt();
            assert!((rms(&all) / plain - 1.0).abs() < 0.06, "{scale}");
        }
    }

    #[test]
    fn mismatches_of_any_size_raise_the_rms_by_less_than_a_third_if_they_are_a_fiftieth() {
        for scale in [0.03, 0.4, 1.0, 3.0] {
            let mut all: Vec<_> = normal(200).iter().map(|x| scale * x).collect();
            let clean = rms(&all);
            for size in [10.0, 100.0, 1e4, f64::MAX.sqrt() / 10.0] {
                all.truncate(200);
                all.extend([size * scale, -size * scale, size * scale, -size * scale]);
                let ratio = rms(&all) / clean;
                assert!((0.9..1.33).contains(&ratio), "{scale} {size}: {ratio}");
            }
        }
    }
}
