//! Fit of two calibrations to the matches of a pair that fit its own pose (`ESTIMATOR.md`, section 16).

use crate::batch::correspondence::RayPair;
use crate::batch::grid::CellSet;
use crate::batch::row_offset::pixel_row_offset;
use crate::depth::pose::RowsPose;
use crate::outcome::robust_rms::SquaresBySize;
use crate::outcome::rows_of::RowsOf;
use crate::scalar::Scalar;
use crate::thresholds::{BAD_PX, FIRST_ROW_LEVEL, IMPROVEMENT, JUDGED};

/// Number of unknowns of a pose.
const UNKNOWNS: f64 = 5.0;

/// Fit of the calibration in use and of the estimate to a pair.
pub(super) struct Fit<T> {
    /// Row offset beyond that of the pair's own pose, px, and share of the matches that fit.
    pub(super) in_use: [T; 2],
    pub(super) next: [T; 2],
    /// RMS difference between the row offsets in use and of the estimate, px.
    off_px: T,
    /// RMS row offset of the pair's own pose, px.
    own_px: T,
    pub(super) image_coverage: T,
    pub(super) nearness: T,
}

impl<T: Scalar> Fit<T> {
    /// Returns whether the estimate is clearly better than the calibration in use.
    ///
    /// * `over_pairs`: whether it is over all pairs, if that is known.
    pub(super) fn improves(&self, over_pairs: Option<bool>) -> bool {
        let squared = |[rows_px, _]: [T; 2]| rows_px * rows_px + self.own_px * self.own_px;
        let least = T::lit(IMPROVEMENT * IMPROVEMENT);
        let over_pair = squared(self.next) < least * squared(self.in_use);
        self.off_px >= T::lit(BAD_PX) || over_pairs.unwrap_or(over_pair)
    }
}

/// Sums over the matches of a pair that fit its own pose.
pub(super) struct Sums<T> {
    /// Numbers of matches that fit the pair's own pose, the calibration in use and the estimate.
    matches: [u32; 3],
    /// Row offsets in use minus own, of the estimate minus own, and in use minus of the estimate.
    differences: [SquaresBySize<T>; 3],
    /// Sum of the squared row offsets of the own pose.
    own: T,
    /// Sum of `(x_l^2 - x_r^2)^2`.
    nearness: T,
    seen: CellSet,
}

impl<T: Scalar> Sums<T> {
    /// Takes the sums over at most [`JUDGED`] matches.
    ///
    /// * `own`: pose of the pair alone; `calibrations`: in use, and of the estimate.
    /// * `screens`: largest row offset of a match that fits the pair's own pose, and that fits the calibrations; at unit
    ///   focal length.
    pub(super) fn of(
        matches: &[RayPair<T>],
        own: &RowsPose<T>,
        calibrations: &[RowsOf<T>; 2],
        [own_screen, screen]: [T; 2],
    ) -> Self {
        let none = SquaresBySize::none(own_screen * T::lit(FIRST_ROW_LEVEL));
        let mut sums = Self {
            matches: [0; 3],
            differences: [none; 3],
            own: T::ZERO,
            nearness: T::ZERO,
            seen: CellSet::NONE,
        };
        let stride = matches.len().div_ceil(JUDGED).max(1);
        for pair in matches.iter().step_by(stride) {
            let Some(offset) =
                pixel_row_offset(own.rotations(), pair).filter(|offset| offset.abs() <= own_screen)
            else {
                continue;
            };
            let [x_l, _, x_r, _] = pair.rays();
            let nearness = x_l * x_l - x_r * x_r;
            sums.own += offset * offset;
            sums.nearness += nearness * nearness;
            sums.seen.insert(pair.cell());
            let others = calibrations.each_ref().map(|rows| rows.offset(pair));
            let [all, fit @ ..] = &mut sums.matches;
            *all = all.saturating_add(1);
            for (count, other) in fit.iter_mut().zip(others) {
                let fits = other.is_some_and(|other| other.abs() <= screen);
                *count = count.saturating_add(fits.into());
            }
            if let [Some(used), Some(next)] = others {
                let all = [used - offset, next - offset, used - next];
                sums.differences.iter_mut().zip(all).for_each(|(sum, one)| sum.add(one));
            }
        }
        sums
    }

    /// Returns the fit; `None` without more matches than unknowns.
    ///
    /// * `focal`: mean focal length, px.
    pub(super) fn fit(&self, focal: T) -> Option<Fit<T>> {
        let [all, used, next] = self.matches.map(T::count);
        let unknowns = T::lit(UNKNOWNS);
        if !(all > unknowns) {
            return None;
        }
        let variance = self.own / (all - unknowns);
        let [in_use, of_next, off] = self.differences.each_ref().map(SquaresBySize::rms);
        // The own pose follows the noise of the pair: its row offsets are off by the noise of five unknowns.
        let by_noise = variance * unknowns / all;
        let beyond = |rms: T| (rms * rms - by_noise).max(T::ZERO).sqrt() * focal;
        Some(Fit {
            in_use: [beyond(in_use), used / all],
            next: [beyond(of_next), next / all],
            off_px: off * focal,
            own_px: variance.sqrt() * focal,
            image_coverage: self.seen.share(),
            nearness: self.nearness / all,
        })
    }
}
