//! The grid of the rows, as exact ties show it (`ESTIMATOR.md`, section 4). Rows that a matcher measures continuously
//! never tie. Rows on a grid often do, and rows that it did not measure always do: it searched along them.

use crate::scalar::Scalar;
use crate::thresholds::{COARSE_STEP_PX, MAX_ROW_STEP_PX, MIN_TIED, MOST_TIED};

/// Steps per px of the sum of differences. A sum of integers does not depend on the order of the matches.
const STEPS_PER_PX: f64 = 256.0;

/// How a matcher has measured the rows of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Rows<T> {
    /// On a grid with this step, px; 0 for continuous rows.
    Measured(T),
    /// Nearly all rows are equal: they carry no information.
    NotMeasured,
}

/// Counts of the ties among the rows of matches.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowGrid {
    matches: u32,
    tied: u32,
    /// Number, and sum in [`STEPS_PER_PX`], of the differences above a tie and up to [`MAX_ROW_STEP_PX`].
    apart: u32,
    sum: u32,
}

impl RowGrid {
    pub(super) const NONE: Self = Self { matches: 0, tied: 0, apart: 0, sum: 0 };

    /// Counts a match.
    ///
    /// * `difference`: magnitude of the difference of its rows, px; `rounding`: largest difference of a tie, px.
    pub(super) fn add<T: Scalar>(&mut self, difference: T, rounding: T) {
        self.matches = self.matches.saturating_add(1);
        if difference <= rounding {
            self.tied = self.tied.saturating_add(1);
        } else if difference <= T::lit(MAX_ROW_STEP_PX) {
            let steps = (difference * T::lit(STEPS_PER_PX)).to_u16();
            self.apart = self.apart.saturating_add(1);
            self.sum = self.sum.saturating_add(steps.into());
        }
    }

    /// Returns how the rows were measured. If many rows tie, the mean of the other small differences is the step.
    pub(super) fn rows<T: Scalar>(&self) -> Rows<T> {
        let [matches, tied] = [self.matches, self.tied].map(T::count);
        if self.matches > 0 && tied >= matches * T::lit(MOST_TIED) {
            Rows::NotMeasured
        } else if self.apart > 0 && tied > matches * T::lit(MIN_TIED) {
            Rows::Measured(T::count(self.sum) / (T::count(self.apart) * T::lit(STEPS_PER_PX)))
        } else {
            Rows::Measured(T::ZERO)
        }
    }
}

/// Returns the step of the grid that the rows of one match lie on, px: 1 if both are whole, 1/2 if both are whole or
/// half, else the stated step. A step stated from [`COARSE_STEP_PX`] on is not tested, because the rows of coarse steps
/// are often whole by chance.
pub(super) fn step_of<T: Scalar>([left, right]: [T; 2], stated: T) -> T {
    let is_whole = |v: T| T::count(v.to_u16().into()) == v;
    // A continuous row fails the first test.
    if !is_whole(left + left) || stated >= T::lit(COARSE_STEP_PX) || !is_whole(right + right) {
        stated
    } else if is_whole(left) && is_whole(right) {
        T::ONE
    } else {
        T::HALF
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(differences: &[f32]) -> Rows<f32> {
        let mut grid = RowGrid::NONE;
        for difference in differences {
            grid.add(*difference, 0.0);
        }
        grid.rows()
    }

    #[test]
    fn continuous_rows_never_tie_and_copied_rows_always_do() {
        assert_eq!(after(&[]), Rows::Measured(0.0));
        assert_eq!(after(&[0.3, 0.1, 2.4, 0.0]), Rows::Measured(0.0));
        assert_eq!(after(&[0.0; 20]), Rows::NotMeasured);
        let mut copied = [0.0; 20];
        copied[0] = 50.0;
        assert_eq!(after(&copied), Rows::NotMeasured);
    }

    #[test]
    fn the_other_rows_of_a_grid_show_its_step_and_mismatches_do_not() {
        assert_eq!(after(&[0.0, 0.0, 1.25, 1.25, 60.0]), Rows::Measured(1.25));
        let continuous = [0.0, 0.0, 0.3, 0.5, 0.7, 0.1, 0.2, 0.4];
        assert_eq!(after(&continuous), Rows::Measured(0.0));
    }

    #[test]
    fn whole_and_half_rows_lie_on_a_grid_unless_the_matcher_states_its_step() {
        let step = |left, right, stated| step_of::<f32>([left, right], stated);
        assert_eq!([step(7.0, 8.0, 0.0), step(0.0, 0.0, 0.0), step(0.0, 32_767.0, 0.0)], [1.0; 3]);
        assert_eq!([step(7.5, 8.0, 0.0), step(7.5, 8.5, 0.0)], [0.5; 2]);
        assert_eq!([step(7.25, 8.0, 0.0), step(-0.5, 8.0, 0.0)], [0.0; 2]);
        assert_eq!([step(7.0, 8.0, 0.25), step(7.0, 8.0, 2.0)], [0.25, 2.0]);
        assert_eq!([step(7.0, 8.0, 0.125), step(7.1, 8.0, 0.125)], [1.0, 0.125]);
    }
}
