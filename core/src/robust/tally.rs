//! What a judgement counts, and compares with the start.

use super::weight::Spread;
use crate::lanes::Single;
use crate::scalar::Scalar;

/// Counts of correspondences, and sums over them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tally<T> {
    pub(crate) usable: u32,
    pub(crate) skipped: u32,
    /// Residuals within 2, 3, and 4 standard deviations.
    pub(super) within: [u32; 3],
    /// What the squares of those within 2 say of the noise, px^2.
    pub(super) near_squares: T,
    /// Correspondences that fit, and sums of their squared row offsets at start and pose, unit depth.
    pub(crate) screened: u32,
    pub(crate) squares: [T; 2],
    /// Of the row offsets of all correspondences, each cut off beyond Tukey's limit, unit depth.
    pub(crate) cost: [T; 2],
}

impl<T: Scalar> Tally<T> {
    pub(super) const NONE: Self = Self {
        usable: 0,
        skipped: 0,
        within: [0; 3],
        near_squares: T::ZERO,
        screened: 0,
        squares: [T::ZERO; 2],
        cost: [T::ZERO; 2],
    };

    /// * `squared`: of a whitened residual, px^2.
    #[inline(always)]
    pub(super) fn count(&mut self, squared: T, spread: &Spread<T>) {
        self.usable += 1;
        let [two, three, four] = &mut self.within;
        if spread.is_within(Single, T::lit(4.0), squared) {
            *four += 1;
            if spread.is_within(Single, T::lit(3.0), squared) {
                *three += 1;
            }
            if spread.is_within(Single, T::lit(2.0), squared) {
                *two += 1;
                self.near_squares += spread.noise_squared(Single, squared);
            }
        }
    }

    /// Residuals within 2 standard deviations.
    pub(super) fn near(&self) -> u32 {
        let [near, _, _] = self.within;
        near
    }

    /// Residuals from 2 to 4 standard deviations.
    pub(super) fn beside(&self) -> u32 {
        let [near, _, around] = self.within;
        around.saturating_sub(near)
    }

    /// What the squares of the near ones say of the noise, px^2.
    pub(super) fn near_squares(&self) -> T {
        self.near_squares
    }

    /// Share of the usable ones within 3 standard deviations.
    pub(super) fn inliers(&self) -> T {
        let [_, within, _] = self.within;
        T::count(within) / T::count(self.usable.max(1))
    }

    /// * `before`, `after`: squared row offsets at the start and at the pose, unit depth.
    /// * `most`: beyond which they cost no more.
    /// * `fits`: whether the correspondence fits the pose.
    #[inline(always)]
    pub(super) fn compare(&mut self, before: Option<T>, after: T, most: T, fits: bool) {
        let cut = |squared: T| if squared < most { squared } else { most };
        let [cost_before, cost_after] = &mut self.cost;
        *cost_before += before.map_or(most, cut);
        *cost_after += cut(after);
        if let Some(before) = before
            && fits
        {
            self.screened += 1;
            let [squares_before, squares_after] = &mut self.squares;
            *squares_before += before;
            *squares_after += after;
        }
    }
}
