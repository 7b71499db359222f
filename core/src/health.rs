//! How well a calibration fits the matches at hand: of the one in use and of the proposed one, over
//! the same matches.

use crate::correspondence::RayPair;
use crate::extrinsics::Extrinsics;
use crate::rectification::RectifyingRotations;
use crate::residual::row_offset;
use crate::scalar::Scalar;

/// RMS row offset, px, of two calibrations over the same screened matches (0 is perfect), and how
/// many matches fit each.
///
/// Read both: an estimate that fits fewer matches is worse, however well it fits those.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Health<T> {
    /// Of the extrinsics in use, px.
    pub in_use_px: T,
    /// Of the proposed extrinsics, px.
    pub proposed_px: T,
    /// Matches within the screening threshold under the extrinsics in use.
    pub fit_in_use: u32,
    /// Matches within it under the proposed extrinsics: those that both RMS are over.
    pub fit_proposed: u32,
}

impl<T: Scalar> Health<T> {
    /// Compares two calibrations over a batch. One pass; `None` if no match is left to judge by.
    ///
    /// * `screen_px`: a match fits if its row offset is no larger, px.
    pub(crate) fn over(
        pairs: &[RayPair<T>],
        in_use: &Extrinsics<T>,
        proposed: &Extrinsics<T>,
        focal: T,
        screen_px: T,
    ) -> Option<Self> {
        let in_use = RectifyingRotations::from(in_use);
        let proposed = RectifyingRotations::from(proposed);
        let [mut fit_in_use, mut fit_proposed] = [0_u32; 2];
        let fits = |offset: T| (offset * focal).abs() <= screen_px;
        let [mut squares_in_use, mut squares_proposed] = [T::ZERO; 2];
        for pair in pairs {
            let offsets = row_offset(&in_use, pair).zip(row_offset(&proposed, pair));
            let Some((used, new)) = offsets else {
                continue;
            };
            fit_in_use = fit_in_use.saturating_add(u32::from(fits(used)));
            if fits(new) {
                fit_proposed = fit_proposed.saturating_add(1);
                squares_in_use += used * used;
                squares_proposed += new * new;
            }
        }
        let rms = |squares: T| (squares / T::count(fit_proposed)).sqrt() * focal;
        (fit_proposed > 0).then(|| Self {
            in_use_px: rms(squares_in_use),
            proposed_px: rms(squares_proposed),
            fit_in_use,
            fit_proposed,
        })
    }
}
