//! The last pairs: how they fitted the calibration in use (`ESTIMATOR.md`, section 16).

use crate::scalar::Scalar;
use crate::thresholds::{BAD_IN_A_ROW, GOOD_IN_A_ROW, MAX_REJECTED, MAX_UNSOLVED};

/// How the last pairs fitted the calibration in use.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recent<T> {
    /// Numbers of pairs in a row that fitted and that did not. One of them is 0.
    good: u8,
    bad: u8,
    /// Number of pairs in a row that could not be solved.
    unsolved: u8,
    /// Number of solved pairs in a row that the estimate rejected.
    rejected: u8,
    /// Whether [`GOOD_IN_A_ROW`] pairs have fitted, and since then no [`BAD_IN_A_ROW`] pairs in a row have not.
    pub(super) fits: bool,
    /// Whether the last solved pair fits the calibration that [`crate::Calibrator::apply`] puts into use.
    next_fits: bool,
    /// Mean square of `x_l^2 - x_r^2` over the last solved pair: error of a disparity per turn of the baseline.
    pub(super) nearness: T,
}

impl<T: Scalar> Recent<T> {
    pub(crate) const NONE: Self = Self {
        good: 0,
        bad: 0,
        unsolved: 0,
        rejected: 0,
        fits: false,
        next_fits: false,
        nearness: T::ZERO,
    };

    /// Notes a solved pair.
    pub(super) fn add(&mut self, fits: bool, next_fits: bool) {
        self.next_fits = next_fits;
        self.unsolved = 0;
        if fits {
            (self.good, self.bad) = (self.good.saturating_add(1), 0);
        } else {
            (self.good, self.bad) = (0, self.bad.saturating_add(1));
        }
        self.fits = if self.fits { self.bad < BAD_IN_A_ROW } else { self.good >= GOOD_IN_A_ROW };
    }

    /// Notes whether the estimate rejects a solved pair.
    pub(super) fn add_rejected(&mut self, rejected: bool) {
        self.rejected = if rejected { self.rejected.saturating_add(1) } else { 0 };
    }

    /// Returns whether the estimate has rejected so many pairs in a row that it confirms no depth.
    pub(super) fn rejects(&self) -> bool {
        self.rejected >= MAX_REJECTED
    }

    /// Notes a pair that could not be solved.
    pub(super) fn add_unsolved(&mut self) {
        self.unsolved = self.unsolved.saturating_add(1);
        if self.unsolved >= MAX_UNSOLVED {
            (self.good, self.fits, self.next_fits) = (0, false, false);
        }
    }

    /// Notes that the estimate has changed: no pair has been compared with the calibration that follows from it.
    pub(crate) fn forget_next(&mut self) {
        self.next_fits = false;
    }

    /// Notes that another calibration has been put into use. The last pair counts for it or against it.
    pub(crate) fn change(&mut self) {
        (self.good, self.bad) =
            if self.next_fits { (self.good.max(1), 0) } else { (0, self.bad.max(1)) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns after how many of the pairs the rig is fit to arm.
    fn fits(pairs: &[Option<bool>]) -> [bool; 8] {
        let mut recent = Recent::<f32>::NONE;
        core::array::from_fn(|i| {
            match pairs.get(i) {
                Some(Some(fits)) => recent.add(*fits, *fits),
                Some(None) => recent.add_unsolved(),
                None => {}
            }
            recent.fits
        })
    }

    #[test]
    fn two_good_pairs_in_a_row_arm_and_two_bad_ones_disarm() {
        let [good, bad] = [true, false].map(Some);
        let pairs = [good, bad, good, good, bad, good, bad, bad];
        let armed = [false, false, false, true, true, true, true, false];
        assert_eq!(fits(&pairs), armed);
        // A pair without a solution is no evidence either way.
        assert_eq!(
            fits(&[good, None, good, bad, None, bad])[..6],
            [false, false, true, true, true, false]
        );
    }

    #[test]
    fn without_any_evidence_it_ends() {
        let mut recent = Recent::<f32>::NONE;
        recent.add(true, true);
        recent.add(true, true);
        let pairs = (1..100).find(|_| {
            recent.add_unsolved();
            !recent.fits
        });
        assert_eq!(pairs, Some(MAX_UNSOLVED));
    }

    #[test]
    fn a_pair_that_misses_the_new_calibration_is_the_first_of_two_that_disarm() {
        for next_fits in [true, false] {
            let mut recent = Recent::<f32>::NONE;
            recent.add(true, true);
            recent.add(true, next_fits);
            recent.change();
            assert!(recent.fits);
            recent.add(false, false);
            assert_eq!(recent.fits, next_fits);
        }
    }

    #[test]
    fn a_new_calibration_that_fits_the_last_pair_needs_one_more() {
        for (next_fits, armed) in [(true, true), (false, false)] {
            let mut recent = Recent::<f32>::NONE;
            recent.add(false, next_fits);
            recent.change();
            recent.add(true, true);
            assert_eq!(recent.fits, armed);
        }
    }
}
