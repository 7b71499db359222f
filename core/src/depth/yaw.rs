//! Mount yaw and apparent yaw of the lens as a Gaussian: means and 2 x 2 covariance (`ESTIMATOR.md`, section 20).

use crate::scalar::Scalar;
use crate::thresholds::UNKNOWN_YAW_RAD;

/// Largest variance of a mount yaw in a record, rad^2. A turn is at most pi.
pub(crate) const MAX_YAW_VARIANCE: f32 = 10.0;

/// Mount yaw `y` relative to the factory extrinsics, apparent yaw `o` of the lens, rad, and their covariance, rad^2.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct YawEstimate<T> {
    pub(super) mount: T,
    pub(super) lens: T,
    pub(super) var_mount: T,
    pub(super) var_lens: T,
    /// Covariance of the two yaws; negative once rows have measured their sum.
    pub(super) mixed: T,
}

impl<T: Scalar> YawEstimate<T> {
    /// Returns two independent yaws with mean 0.
    ///
    /// * `var_mount`: variance of the mount yaw, rad^2; `None` for an unknown yaw.
    /// * `var_lens`: variance of the apparent yaw of the lens, rad^2.
    pub(super) fn independent(var_mount: Option<T>, var_lens: T) -> Self {
        let var_mount = var_mount.unwrap_or(unknown());
        Self { mount: T::ZERO, lens: T::ZERO, var_mount, var_lens, mixed: T::ZERO }
    }

    /// Returns the mount yaw relative to the factory extrinsics, rad.
    pub(crate) fn mount(&self) -> T {
        self.mount
    }

    /// Returns the apparent yaw `o` of the lens, rad: rows are off by `o x y` at unit depth.
    pub(crate) fn lens(&self) -> T {
        self.lens
    }

    /// Returns the variance of the mount yaw, rad^2.
    pub(crate) fn var_mount(&self) -> T {
        self.var_mount
    }

    /// Returns the variance of the apparent yaw, rad^2.
    pub(crate) fn var_lens(&self) -> T {
        self.var_lens
    }

    /// Returns the variance of the sum, rad^2.
    fn var_sum(&self) -> T {
        (self.var_mount + (self.mixed + self.mixed) + self.var_lens).max(T::ZERO)
    }

    /// Returns the squared difference of the measured and the expected sum, divided by its variance.
    pub(super) fn surprise(&self, sum: T, variance: T) -> T {
        let off = sum - self.mount - self.lens;
        off * off / (self.var_sum() + variance)
    }

    /// Returns the squared difference of the measured and the expected sum minus its variance, at least 0, rad^2. This
    /// is the likeliest variance of a turn of the mount.
    pub(super) fn excess(&self, sum: T, variance: T) -> T {
        let off = sum - self.mount - self.lens;
        (off * off - self.var_sum() - variance).max(T::ZERO)
    }

    /// Returns whether the mount yaw is unknown.
    fn is_free(&self) -> bool {
        self.var_mount >= unknown()
    }

    /// Returns the part of an error of the measured sum that goes into the mount yaw, 0 to 1.
    pub(super) fn gain_of_rows(&self, variance: T) -> T {
        if self.is_free() {
            return T::ONE;
        }
        (self.var_mount + self.mixed) / (self.var_sum() + variance)
    }

    /// Returns the estimate after rows have measured the sum.
    #[must_use]
    pub(super) fn with_rows(&self, sum: T, variance: T) -> Self {
        if self.is_free() {
            // The limit for an infinite variance of the mount yaw: the mount takes the part of the sum that the lens
            // does not explain.
            let (lens, var_lens) = (self.lens, self.var_lens);
            let (mount, var_mount) = (sum - lens, var_lens + variance);
            return Self { mount, lens, var_mount, var_lens, mixed: -var_lens };
        }
        let total = self.var_sum() + variance;
        if !(total > T::ZERO) {
            return *self;
        }
        let off = (sum - self.mount - self.lens) / total;
        let common = self.determinant();
        Self {
            mount: self.mount + (self.var_mount + self.mixed) * off,
            lens: self.lens + (self.var_lens + self.mixed) * off,
            var_mount: (self.var_mount * variance + common) / total,
            var_lens: (self.var_lens * variance + common) / total,
            mixed: (self.mixed * variance - common) / total,
        }
    }

    /// Returns the estimate after a witness has measured the mount yaw.
    #[must_use]
    pub(super) fn with_mount(&self, yaw: T, variance: T) -> Self {
        let total = self.var_mount + variance;
        if !(total > T::ZERO) {
            return *self;
        }
        let off = (yaw - self.mount) / total;
        Self {
            mount: self.mount + self.var_mount * off,
            lens: self.lens + self.mixed * off,
            var_mount: self.var_mount * variance / total,
            var_lens: (self.var_lens * variance + self.determinant()) / total,
            mixed: self.mixed * variance / total,
        }
    }

    /// Returns the estimate after a turn of the mount by an angle with this variance, rad^2; the yaw of the lens stays.
    #[must_use]
    pub(super) fn turned(&self, variance: T) -> Self {
        Self { var_mount: self.var_mount + variance, ..*self }
    }

    /// Returns the estimate after a turn of the mount by an unknown angle.
    #[must_use]
    pub(super) fn freed(&self) -> Self {
        self.turned(unknown())
    }

    /// Returns the estimate with at least this variance of the mount yaw.
    #[must_use]
    pub(super) fn not_below(&self, variance: T) -> Self {
        self.turned((variance - self.var_mount).max(T::ZERO))
    }

    /// Returns the determinant of the covariance. It is at least 0 in spite of rounding, so no updated variance is
    /// negative.
    fn determinant(&self) -> T {
        (self.var_mount * self.var_lens - self.mixed * self.mixed).max(T::ZERO)
    }

    /// Returns the five numbers, in the order of the record. The variance of the mount yaw is at most
    /// [`MAX_YAW_VARIANCE`], above which the yaw is just as unknown.
    pub(super) fn numbers(&self) -> [T; 5] {
        let Self { mount, lens, var_mount, var_lens, mixed } = *self;
        let most = var_mount.min(T::single(MAX_YAW_VARIANCE));
        let factor = if most < var_mount { most / var_mount } else { T::ONE };
        [mount, lens, most, var_lens, mixed * factor]
    }

    /// Returns the estimate from the five numbers; `None` unless their covariance is valid.
    pub(super) fn of([mount, lens, var_mount, var_lens, mixed]: [T; 5]) -> Option<Self> {
        let allowed = T::ONE + T::lit(1e-3);
        let is_covariance = var_mount >= T::ZERO
            && var_lens >= T::ZERO
            && mixed * mixed <= var_mount * var_lens * allowed;
        is_covariance.then_some(Self { mount, lens, var_mount, var_lens, mixed })
    }
}

/// Returns the variance of an unknown mount yaw, rad^2.
fn unknown<T: Scalar>() -> T {
    T::lit(UNKNOWN_YAW_RAD * UNKNOWN_YAW_RAD)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix2, Vector2};

    /// Returns the same update, computed with matrices.
    fn updated(of: &YawEstimate<f64>, h: Vector2<f64>, value: f64, variance: f64) -> [f64; 5] {
        let p = Matrix2::new(of.var_mount, of.mixed, of.mixed, of.var_lens);
        let x = Vector2::new(of.mount, of.lens);
        let gain = p * h / ((h.transpose() * p * h)[0] + variance);
        let x = x + gain * (value - h.dot(&x));
        let p = (Matrix2::identity() - gain * h.transpose()) * p;
        [x[0], x[1], p[(0, 0)], p[(1, 1)], p[(0, 1)]]
    }

    fn agree(one: [f64; 5], other: [f64; 5]) {
        for (a, b) in one.into_iter().zip(other) {
            assert!((a - b).abs() <= 1e-12 * b.abs().max(1e-6), "{one:?} {other:?}");
        }
    }

    #[test]
    fn measurements_of_sum_and_mount_are_those_of_a_kalman_filter() {
        let prior = YawEstimate::independent(Some(8e-7), 2e-5);
        let rows = prior.with_rows(9e-3, 1e-8);
        agree(rows.numbers(), updated(&prior, Vector2::new(1.0, 1.0), 9e-3, 1e-8));
        let ranged = rows.with_mount(3e-4, 1e-7);
        agree(ranged.numbers(), updated(&rows, Vector2::new(1.0, 0.0), 3e-4, 1e-7));
        let turned = ranged.turned(0.1).with_rows(-4e-3, 1e-8);
        let by_hand = updated(&ranged.turned(0.1), Vector2::new(1.0, 1.0), -4e-3, 1e-8);
        for (a, b) in turned.numbers().into_iter().zip(by_hand) {
            // The matrices lose digits by cancellation.
            assert!((a - b).abs() <= 1e-6 * b.abs().max(1e-6), "{turned:?} {by_hand:?}");
        }
    }

    #[test]
    fn after_a_turn_of_the_mount_the_change_of_rows_is_that_of_the_mount() {
        let known = YawEstimate::independent(Some(8e-7_f32), 2e-5).with_rows(9e-3, 1e-8);
        let turned = known.freed().with_rows(9e-3 + 0.0175, 1e-8);
        assert!((turned.mount - known.mount - 0.0175).abs() < 1e-5, "{turned:?}");
        assert!((turned.lens - known.lens).abs() < 1e-5, "{turned:?}");
        // The variance of the mount is then nearly the variance of the lens.
        assert!((turned.var_mount / known.var_lens - 1.0).abs() < 0.05, "{turned:?}");
    }

    #[test]
    fn rows_do_not_determine_a_mount_yaw_that_was_unknown_before() {
        let unknown = YawEstimate::independent(None, 2e-5_f32).with_rows(9e-3, 1e-8);
        assert_eq!((unknown.mount, unknown.lens), (9e-3, 0.0));
        assert!((unknown.var_mount / 2e-5 - 1.0).abs() < 0.01, "{unknown:?}");
    }

    #[test]
    fn a_mount_yaw_beyond_the_range_of_a_record_stays_unknown_with_a_valid_covariance() {
        let known = YawEstimate::independent(Some(8e-7), 2e-5).with_rows(9e-3, 0.0);
        let wide = YawEstimate { mixed: -0.006, ..known.turned(50.0) };
        let kept = YawEstimate::of(wide.numbers()).unwrap();
        assert!(kept.is_free() && kept.var_mount <= f64::from(MAX_YAW_VARIANCE), "{kept:?}");
        assert_eq!(wide.with_rows(0.1, 1e-8), kept.with_rows(0.1, 1e-8));
        assert_eq!(YawEstimate::of(known.numbers()), Some(known));
    }

    #[test]
    fn numbers_that_are_not_a_covariance_are_refused() {
        let good = YawEstimate::independent(Some(8e-7_f32), 2e-5).with_rows(9e-3, 0.0);
        assert_eq!(YawEstimate::of(good.numbers()), Some(good));
        for bad in [[0.0, 0.0, -1.0, 1.0, 0.0], [0.0, 0.0, 1.0, 1.0, 2.0], [f32::NAN; 5]] {
            assert_eq!(YawEstimate::of(bad), None, "{bad:?}");
        }
    }
}
