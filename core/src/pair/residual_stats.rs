//! Residual statistics at a pose: noise, inliers, and the fit at the pose compared with the fit at the start
//! (`ESTIMATOR.md`, section 7).

use super::leverage::form_peak;
use super::loss::{BESIDE, ResidualVariance};
use crate::batch::sides::is_behind;
use crate::scalar::Scalar;
use crate::thresholds::{CROWD, INLIER, NEAR, SIGNIFICANT};

/// Counts of correspondences (whole numbers), and sums over correspondences.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ResidualStats<T> {
    /// Correspondences in front of both cameras.
    pub(crate) usable: T,
    /// Correspondences behind a camera.
    pub(crate) skipped: T,
    /// Residuals within 2, 3, and 4 units of the loss.
    pub(crate) within: [T; 3],
    /// Residuals within half a unit, with an allowance for rounding ([`ResidualVariance::is_inner`]).
    pub(super) inner: T,
    /// Numbers of residuals within 2 units of the loss: of points clearly in front of the cameras, and of points
    /// clearly behind them.
    pub(super) sides: [T; 2],
    /// Number of positive minus number of negative residuals from 2 to [`CROWD`] units of the loss.
    pub(super) leaning: T,
    /// Sum of the estimates of the noise variance from the residuals within 2 units, px^2.
    pub(super) near_squares: T,
    /// Correspondences within Tukey's limit at the pose and in front of both cameras at the start.
    pub(crate) screened: T,
    /// Sums of the squared row offsets of the screened correspondences at start and pose, in pixels over the focal
    /// length.
    pub(crate) squares: [T; 2],
    /// Numbers of weighted correspondences in the separate class of high leverage
    /// ([`super::leverage::Leverage::is_separate`]), with residuals below 2 units, and from 2 to 4 units.
    pub(super) high_leverage: [T; 2],
    /// Sums of the truncated squared row offsets of the usable correspondences at start and pose, in pixels over the
    /// focal length. A correspondence behind a camera at the start counts there as truncated.
    pub(crate) cost: [T; 2],
}

/// Squared row offsets of a correspondence at the start and at the pose, in pixels over the focal length.
pub(super) struct Compared<T> {
    /// `None` if the correspondence is behind a camera at the start.
    pub(super) before: Option<T>,
    pub(super) after: T,
    /// Squared row offset at which the cost is truncated, in pixels over the focal length.
    pub(super) most: T,
    /// Whether the residual is within Tukey's limit at the pose.
    pub(super) fits: bool,
}

impl<T: Scalar> ResidualStats<T> {
    /// Statistics without any correspondence.
    pub(super) const NONE: Self = Self {
        usable: T::ZERO,
        skipped: T::ZERO,
        within: [T::ZERO; 3],
        inner: T::ZERO,
        sides: [T::ZERO; 2],
        leaning: T::ZERO,
        near_squares: T::ZERO,
        screened: T::ZERO,
        squares: [T::ZERO; 2],
        high_leverage: [T::ZERO; 2],
        cost: [T::ZERO; 2],
    };

    /// Counts the residual of a correspondence in front of both cameras.
    ///
    /// * `value`: the constraint, with the sign of the residual; `squared`: squared whitened residual, px^2.
    /// * `disparity`, `least`: disparity, and the smallest disparity that noise explains, which is negative; both
    ///   scaled by the same positive factor.
    #[inline(always)]
    pub(super) fn count(
        &mut self,
        [value, squared]: [T; 2],
        [disparity, least]: [T; 2],
        expected: &ResidualVariance<T>,
    ) {
        self.usable += T::ONE;
        let [two, three, four] = &mut self.within;
        if expected.is_within(NEAR, squared) {
            *two += T::ONE;
            *three += T::ONE;
            *four += T::ONE;
            self.near_squares += expected.noise_squared(squared);
            if expected.is_inner(squared) {
                self.inner += T::ONE;
            }
            let [ahead, behind] = &mut self.sides;
            if disparity >= -least {
                *ahead += T::ONE;
            }
            if disparity < least {
                *behind += T::ONE;
            }
        } else if expected.is_within(CROWD, squared) {
            self.leaning += if value < T::ZERO { T::MINUS_ONE } else { T::ONE };
            if expected.is_within(INLIER, squared) {
                *three += T::ONE;
            }
            if expected.is_within(BESIDE, squared) {
                *four += T::ONE;
            }
        }
    }

    /// Adds the row offsets at start and pose of a correspondence in front of both cameras at the pose.
    #[inline(always)]
    pub(super) fn compare(&mut self, compared: &Compared<T>) {
        let Compared { before, after, most, fits } = *compared;
        let truncated = |squared| if squared < most { squared } else { most };
        let [cost_before, cost_after] = &mut self.cost;
        *cost_before += before.map_or(most, truncated);
        *cost_after += truncated(after);
        if let (Some(before), true) = (before, fits) {
            self.screened += T::ONE;
            let [squares_before, squares_after] = &mut self.squares;
            *squares_before += before;
            *squares_after += after;
        }
    }

    /// Returns the number of residuals within 2 units.
    pub(super) fn near(&self) -> T {
        let [near, _, _] = self.within;
        near
    }

    /// Returns the number of residuals from 2 to 4 units.
    pub(super) fn beside(&self) -> T {
        let [near, _, around] = self.within;
        around - near
    }

    /// Returns `leaning` over the number of usable correspondences: the share of a crowd on one side of the peak, with
    /// the sign of its residuals.
    pub(super) fn crowd(&self) -> T {
        self.leaning / self.usable.max(T::ONE)
    }

    /// Returns whether the residuals have a gap at zero: fewer of them are within half a unit than in a flat
    /// distribution, by more than chance. The pose then lies between two crowds. In a flat distribution, a quarter of
    /// the residuals within 2 units are within half a unit.
    pub(super) fn is_hollow(&self) -> bool {
        let missing = self.near() * T::lit(0.25) - self.inner;
        let variance = self.near() * T::lit(0.25 * 0.75);
        missing > T::lit(SIGNIFICANT) * variance.sqrt()
    }

    /// Returns whether too many of the points with residuals within 2 units are behind the cameras.
    pub(super) fn is_behind(&self) -> bool {
        is_behind(self.sides)
    }

    /// Returns the share of the usable correspondences with residuals within 3 units.
    pub(super) fn inlier_share(&self) -> T {
        let [_, inliers, _] = self.within;
        inliers / self.usable.max(T::ONE)
    }

    /// Returns whether the near residuals outnumber the residuals from 2 to 4 units by more than chance.
    pub(super) fn exceed_background(&self) -> bool {
        form_peak([self.near(), self.beside()])
    }
}
