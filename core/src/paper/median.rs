//! A median in constant memory.
//!
//! Exact over the first [`MEDIAN_VALUES`] values; then Robbins and Monro's stochastic approximation,
//! `m += 1.25 s sign(x - m) / n`, with the error of the exact median (`1.25 s / sqrt n`) for a normal distribution. `s`
//! is 1.4826 times the median absolute deviation of the first values, so a minority of outliers changes centre and step
//! by a bounded amount only. After a later shift of the distribution the estimate moves only by these steps.

use crate::scalar::Scalar;
use crate::thresholds::paper::{MEDIAN_VALUES, MIN_DEVIATION_RAD};

/// Step over the median absolute deviation. The factor 1.4826 turns this deviation into a standard deviation; 1.2533 =
/// sqrt(pi / 2) is one over twice the normal density at the median.
const MEDIAN_STEP: f64 = 1.4826 * 1.2533;

/// Streaming median. RAM: about 140 bytes in `f32`.
#[derive(Debug, Clone)]
pub(super) struct Median<T> {
    /// The first values.
    window: Sorted<T>,
    /// Number of values added.
    count: u32,
    /// Median so far.
    centre: T,
    /// `1.25 s`, the step before the division by the number of values.
    step: T,
}

impl<T: Scalar> Median<T> {
    pub(super) const EMPTY: Self =
        Self { window: Sorted::EMPTY, count: 0, centre: T::ZERO, step: T::ZERO };

    /// Adds a value.
    pub(super) fn add(&mut self, x: T) {
        self.count = self.count.saturating_add(1);
        if self.window.insert(x) {
            self.centre = self.window.middle();
            self.step = self.first_step();
        } else {
            let step = self.step / T::count(self.count);
            if x > self.centre {
                self.centre += step;
            } else if x < self.centre {
                self.centre -= step;
            }
        }
    }

    /// Returns the median so far; `None` before the first value.
    pub(super) fn value(&self) -> Option<T> {
        (self.count > 0).then_some(self.centre)
    }

    /// Returns `1 / (2 density at the median)` of a normal distribution with the deviation of the window.
    fn first_step(&self) -> T {
        let mut deviations = Sorted::EMPTY;
        for x in self.window.values.iter().take(self.window.filled) {
            deviations.insert((*x - self.centre).abs());
        }
        deviations.middle().max(T::lit(MIN_DEVIATION_RAD)) * T::lit(MEDIAN_STEP)
    }
}

/// The first values, in ascending order.
#[derive(Debug, Clone)]
struct Sorted<T> {
    values: [T; MEDIAN_VALUES],
    filled: usize,
}

impl<T: Scalar> Sorted<T> {
    const EMPTY: Self = Self { values: [T::ZERO; MEDIAN_VALUES], filled: 0 };

    /// Inserts a value in order; returns false if the window is full.
    fn insert(&mut self, x: T) -> bool {
        if self.filled == MEDIAN_VALUES {
            return false;
        }
        let mut carried = x;
        for value in self.values.iter_mut().take(self.filled) {
            if carried < *value {
                core::mem::swap(value, &mut carried);
            }
        }
        if let Some(free) = self.values.get_mut(self.filled) {
            *free = carried;
        }
        self.filled = self.filled.saturating_add(1);
        true
    }

    /// Returns the middle value, or the mean of the two middle ones; 0 without values.
    fn middle(&self) -> T {
        let at = |i: usize| self.values.get(i).copied().unwrap_or(T::ZERO);
        let half = self.filled / 2;
        if self.filled % 2 == 1 {
            at(half)
        } else {
            (at(half) + at(half.saturating_sub(1))) * T::HALF
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Median;

    fn median(values: impl IntoIterator<Item = f32>) -> Option<f32> {
        let mut m = Median::EMPTY;
        values.into_iter().for_each(|x| m.add(x));
        m.value()
    }

    /// Returns value `i` of 101 equally spaced values in `0..=1`, in a repeating scattered order.
    fn scattered(i: u16) -> f32 {
        f32::from(i % 101 * 37 % 101) / 100.0
    }

    #[test]
    fn the_median_is_exact_over_the_first_values_in_any_order() {
        assert_eq!(median([]), None);
        assert_eq!(median([4.0]), Some(4.0));
        assert_eq!(median([4.0, 1.0]), Some(2.5));
        assert_eq!(median([4.0, 9.0, 1.0, 2.0, 3.0]), Some(3.0));
        assert_eq!(median((0..31_u8).rev().map(f32::from)), Some(15.0));
    }

    #[test]
    fn the_median_of_a_thousand_values_is_close_to_the_exact_one() {
        let m = median((0..1000).map(scattered)).expect("values");
        assert!((m - 0.5).abs() < 0.05, "{m}");
    }

    #[test]
    fn a_third_of_gross_values_leaves_the_median_among_the_good_values() {
        let gross = |i: u16| if i.is_multiple_of(3) { 1e3 } else { scattered(i) };
        let m = median((0..1000).map(gross)).expect("values");
        // The median of the mixture is the upper quartile of the good values.
        assert!((m - 0.75).abs() < 0.1, "{m}");
    }

    #[test]
    fn the_median_of_equal_values_is_exact() {
        assert_eq!(median((0..1000).map(|_| 0.1)), Some(0.1));
    }
}
