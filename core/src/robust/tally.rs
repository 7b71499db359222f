//! What a judgement has counted.

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
}
