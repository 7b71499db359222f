//! Loss of a row offset, and its weight in the normal equations.

use crate::scalar::Scalar;

/// Huber's loss: quadratic up to the threshold, linear beyond (eq 18).
///
/// It bounds the influence of one gross outlier, but the influences of many add up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Huber<T> {
    /// `c_t`, in the unit of the residual.
    pub(super) threshold: T,
}

impl<T: Scalar> Huber<T> {
    /// Returns the weight `w_i` of eq 18: 1 within the threshold, `c_t / |e|` beyond.
    #[inline(always)]
    pub(super) fn weight(&self, e: T) -> T {
        let size = e.abs();
        if size <= self.threshold { T::ONE } else { self.threshold / size }
    }

    /// Returns the loss, whose derivative is `w(e) e`.
    #[inline(always)]
    pub(super) fn cost(&self, e: T) -> T {
        let size = e.abs();
        if size <= self.threshold {
            e * e * T::HALF
        } else {
            self.threshold * (size - self.threshold * T::HALF)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weight_is_the_derivative_of_the_cost() {
        let h = 1e-6;
        for r in [-9.0, -2.0, -0.3, 0.0, 0.7, 1.9, 5.0_f64] {
            let slope = |cost: &dyn Fn(f64) -> f64| (cost(r + h) - cost(r - h)) / (2.0 * h);
            let huber = Huber { threshold: 1.0 };
            assert!((slope(&|r| huber.cost(r)) - huber.weight(r) * r).abs() < 1e-8);
        }
    }
}
