//! How well a calibration fits the matches at hand: of the one in use and of the proposed one, over
//! the same matches.

use crate::correspondence::RayPair;
use crate::extrinsics::Extrinsics;
use crate::rectification::RectifyingRotations;
use crate::residual::row_offset;
use crate::scalar::Scalar;

/// RMS row offset, px, of two calibrations over the same screened matches; 0 is perfect.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Health<T> {
    /// Of the extrinsics in use, px.
    pub in_use_px: T,
    /// Of the proposed extrinsics, px.
    pub proposed_px: T,
    /// Matches behind both: those within the screening threshold under the proposal.
    pub screened: u32,
}

impl<T: Scalar> Health<T> {
    /// Compares two calibrations over a batch. One pass; `None` if no match is left to judge by.
    ///
    /// * `screen_px`: matches with a larger row offset under the proposal do not count, px.
    pub(crate) fn over(
        pairs: &[RayPair<T>],
        in_use: &Extrinsics<T>,
        proposed: &Extrinsics<T>,
        focal: T,
        screen_px: T,
    ) -> Option<Self> {
        let in_use = RectifyingRotations::from(in_use);
        let proposed = RectifyingRotations::from(proposed);
        let mut screened = 0_u32;
        let [mut squares_in_use, mut squares_proposed] = [T::ZERO; 2];
        for pair in pairs {
            let offsets = row_offset(&in_use, pair).zip(row_offset(&proposed, pair));
            if let Some((used, new)) = offsets
                && (new * focal).abs() <= screen_px
            {
                screened = screened.saturating_add(1);
                squares_in_use += used * used;
                squares_proposed += new * new;
            }
        }
        let rms = |squares: T| (squares / T::count(screened)).sqrt() * focal;
        (screened > 0).then(|| Self {
            in_use_px: rms(squares_in_use),
            proposed_px: rms(squares_proposed),
            screened,
        })
    }
}
