//! Yaw of the mount and apparent yaw of the lens as a Gaussian (`ESTIMATOR.md`, section 20).
//!
//! Its coordinates are the yaw of the rows, which is the sum of the two, and the yaw of the lens. Rows then measure a
//! coordinate, and no update subtracts numbers that are nearly equal.

use crate::scalar::Scalar;

/// Largest variance of a yaw in a record, rad^2. A turn is at most pi.
pub(crate) const MAX_YAW_VARIANCE: f32 = 10.0;

/// Yaw that the rows show, relative to the factory extrinsics, rad, and its variance, rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RowsYaw<T> {
    pub(crate) turn: T,
    pub(crate) variance: T,
}

/// Yaw of the rows relative to the factory extrinsics, apparent yaw of the lens, rad, and their covariance, rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct YawEstimate<T> {
    rows: T,
    lens: T,
    var_rows: T,
    var_lens: T,
    /// Covariance of the two.
    mixed: T,
}

/// A measurement of a yaw.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Measured {
    /// The rows: mount plus lens.
    Rows,
    /// The mount alone.
    Mount,
}

impl<T: Scalar> YawEstimate<T> {
    const ZERO: Self =
        Self { rows: T::ZERO, lens: T::ZERO, var_rows: T::ZERO, var_lens: T::ZERO, mixed: T::ZERO };

    /// Returns the estimate before any rows: a mount yaw, rad, its variance, rad^2, and an independent yaw of the lens
    /// with mean 0 and this variance, rad^2.
    pub(super) fn of_mount(mount: T, var_mount: T, var_lens: T) -> Self {
        let var_rows = var_mount + var_lens;
        Self { rows: mount, lens: T::ZERO, var_rows, var_lens, mixed: var_lens }
    }

    /// Returns the estimate for an unknown mount yaw: a yaw of the rows, rad, its variance, rad^2, and an independent
    /// yaw of the lens with mean 0 and this variance, rad^2.
    pub(super) fn of_rows(rows: T, var_rows: T, var_lens: T) -> Self {
        Self { rows, lens: T::ZERO, var_rows, var_lens, mixed: T::ZERO }
    }

    /// Returns the mount yaw relative to the factory extrinsics, rad.
    pub(crate) fn mount(&self) -> T {
        self.rows - self.lens
    }

    /// Returns the apparent yaw `o` of the lens, rad: rows are off by `o x y` at unit depth.
    pub(crate) fn lens(&self) -> T {
        self.lens
    }

    /// Returns the yaw that the rows show, rad.
    pub(super) fn rows(&self) -> T {
        self.rows
    }

    /// Returns the variance of the mount yaw, rad^2.
    pub(crate) fn var_mount(&self) -> T {
        (self.var_rows - (self.mixed + self.mixed) + self.var_lens).max(T::ZERO)
    }

    /// Returns the variance of the apparent yaw of the lens, rad^2.
    pub(super) fn var_lens(&self) -> T {
        self.var_lens
    }

    /// Returns the variance of the yaw that the rows show, rad^2.
    pub(super) fn var_rows(&self) -> T {
        self.var_rows
    }

    /// Returns the difference of a measured yaw from the expected one, rad, and its variance, rad^2.
    pub(super) fn innovation(&self, of: Measured, yaw: T, variance: T) -> (T, T) {
        match of {
            Measured::Rows => (yaw - self.rows, self.var_rows + variance),
            Measured::Mount => (yaw - self.mount(), self.var_mount() + variance),
        }
    }

    /// Returns the estimate after a measurement, which must have a variance above 0.
    #[must_use]
    pub(super) fn with(&self, of: Measured, yaw: T, variance: T) -> Self {
        let (off, total) = self.innovation(of, yaw, variance);
        let Self { rows, lens, var_rows, var_lens, mixed } = *self;
        // At least 0 in spite of rounding, so no updated variance is negative.
        let determinant = (var_rows * var_lens - mixed * mixed).max(T::ZERO);
        // Covariances of the coordinates with the measured yaw, and what the determinant adds to each element.
        let (of_rows, of_lens, [to_rows, to_mixed]) = match of {
            Measured::Rows => (var_rows, mixed, [T::ZERO, T::ZERO]),
            Measured::Mount => (var_rows - mixed, mixed - var_lens, [determinant, determinant]),
        };
        Self {
            rows: rows + of_rows / total * off,
            lens: lens + of_lens / total * off,
            var_rows: (var_rows * variance + to_rows) / total,
            var_lens: (var_lens * variance + determinant) / total,
            mixed: (mixed * variance + to_mixed) / total,
        }
    }

    /// Returns the estimate after a turn of the mount by a random angle of this variance, rad^2.
    #[must_use]
    pub(super) fn turned(&self, variance: T) -> Self {
        Self { var_rows: self.var_rows + variance, ..*self }
    }

    /// Returns the estimate with at least this variance of the mount yaw, rad^2. The lens takes the missing part.
    #[must_use]
    pub(super) fn not_below(&self, variance: T) -> Self {
        let missing = (variance - self.var_mount()).max(T::ZERO);
        Self { var_lens: self.var_lens + missing, ..*self }
    }

    /// Returns mean and covariance of a mixture.
    ///
    /// * `parts`: weights, whose sum is 1, and estimates.
    pub(super) fn mixture<const N: usize>(parts: &[(T, Self); N]) -> Self {
        let mut all = Self::ZERO;
        for (weight, part) in parts {
            all.rows += *weight * part.rows;
            all.lens += *weight * part.lens;
        }
        for (weight, part) in parts {
            let [rows, lens] = [part.rows - all.rows, part.lens - all.lens];
            all.var_rows += *weight * (part.var_rows + rows * rows);
            all.var_lens += *weight * (part.var_lens + lens * lens);
            all.mixed += *weight * (part.mixed + rows * lens);
        }
        all
    }

    /// Returns the five numbers, in the order of the record.
    pub(super) fn numbers(&self) -> [T; 5] {
        let Self { rows, lens, var_rows, var_lens, mixed } = *self;
        [rows, lens, var_rows, var_lens, mixed]
    }

    /// Returns the estimate from the five numbers; `None` unless their covariance is valid.
    pub(super) fn of([rows, lens, var_rows, var_lens, mixed]: [T; 5]) -> Option<Self> {
        let allowed = T::ONE + T::lit(1e-3);
        let is_covariance = var_rows >= T::ZERO
            && var_lens >= T::ZERO
            && mixed * mixed <= var_rows * var_lens * allowed;
        is_covariance.then_some(Self { rows, lens, var_rows, var_lens, mixed })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};

    /// Returns the same update, computed with matrices.
    fn updated(of: &YawEstimate<f64>, h: Vector2<f64>, value: f64, variance: f64) -> [f64; 5] {
        let p = Matrix2::new(of.var_rows, of.mixed, of.mixed, of.var_lens);
        let x = Vector2::new(of.rows, of.lens);
        let gain = p * h / ((h.transpose() * p * h)[0] + variance);
        let x = x + gain * (value - h.dot(&x));
        let p = (Matrix2::identity() - gain * h.transpose()) * p;
        [x[0], x[1], p[(0, 0)], p[(1, 1)], p[(0, 1)]]
    }

    fn agree(one: [f64; 5], other: [f64; 5]) {
        for (a, b) in one.into_iter().zip(other) {
            assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-6), "{one:?} {other:?}");
        }
    }

    #[test]
    fn rows_and_mount_update_the_estimate_as_a_kalman_filter_does() {
        let (rows, mount) = (Vector2::new(1.0, 0.0), Vector2::new(1.0, -1.0));
        let prior = YawEstimate::of_mount(1e-3_f64, 8e-7, 2e-5);
        assert!((prior.mount() - 1e-3).abs() < 1e-15 && (prior.var_mount() - 8e-7).abs() < 1e-15);
        let one = prior.with(Measured::Rows, 9e-3, 1e-8);
        agree(one.numbers(), updated(&prior, rows, 9e-3, 1e-8));
        let two = one.with(Measured::Mount, 3e-4, 1e-7);
        agree(two.numbers(), updated(&one, mount, 3e-4, 1e-7));
        let three = two.turned(0.1).with(Measured::Rows, -4e-3, 1e-8);
        agree(three.numbers(), updated(&two.turned(0.1), rows, -4e-3, 1e-8));
    }

    #[test]
    fn after_a_turn_of_the_mount_the_change_of_rows_is_that_of_the_mount() {
        let known = YawEstimate::of_mount(0.0, 8e-7_f32, 2e-5).with(Measured::Rows, 9e-3, 1e-8);
        let turned = known.turned(1.0).with(Measured::Rows, 9e-3 + 0.0175, 1e-8);
        assert!((turned.mount() - known.mount() - 0.0175).abs() < 1e-5, "{turned:?}");
        assert!((turned.lens - known.lens).abs() < 1e-5, "{turned:?}");
        assert!((turned.var_mount() / known.var_mount() - 1.0).abs() < 0.05, "{turned:?}");
    }

    #[test]
    fn rows_do_not_determine_a_mount_yaw_that_was_unknown_before() {
        let unknown = YawEstimate::of_rows(9e-3, 1e-8, 2e-5_f32);
        let again = unknown.turned(1e-8).with(Measured::Rows, 8e-3, 1e-8);
        assert_eq!((again.lens, again.var_lens), (0.0, 2e-5));
        assert!(again.var_mount() > 2e-5);
    }

    #[test]
    fn a_mixture_has_the_moments_of_its_parts() {
        let of = |rows, lens| YawEstimate { rows, lens, var_rows: 1.0, var_lens: 2.0, mixed: 0.5 };
        let all = YawEstimate::mixture(&[(0.25, of(4.0, 0.0)), (0.75, of(0.0, 8.0))]);
        // Variance of two points `d` apart: `w (1 - w) d^2`.
        agree(all.numbers(), [1.0, 6.0, 1.0 + 3.0, 2.0 + 12.0, 0.5 - 6.0]);
    }

    #[test]
    fn a_least_variance_of_the_mount_widens_the_lens() {
        let known = YawEstimate::of_mount(0.0, 1e-7_f64, 2e-5).with(Measured::Rows, 9e-3, 1e-8);
        assert!((known.not_below(4e-7).var_mount() - 4e-7).abs() < 1e-15);
        assert_eq!(known.not_below(1e-8), known);
    }

    #[test]
    fn numbers_that_are_not_a_covariance_are_refused() {
        let good = YawEstimate::of_mount(0.0, 8e-7_f32, 2e-5).with(Measured::Rows, 9e-3, 1e-9);
        assert_eq!(YawEstimate::of(good.numbers()), Some(good));
        for bad in [[0.0, 0.0, -1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0, 2.0], [f32::NAN; 5]] {
            assert_eq!(YawEstimate::of(bad), None, "{bad:?}");
        }
    }
}
