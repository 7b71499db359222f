//! What a row offset costs, and the weight it gets in the normal equations.

use crate::scalar::Scalar;

/// Huber's loss: quadratic up to the threshold, linear beyond (eq 18).
///
/// Bounds the pull of one gross mismatch, but not of many: see the limits in the README.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Huber<T> {
    /// `c_t`, in the unit of the residual.
    pub(crate) threshold: T,
}

impl<T: Scalar> Huber<T> {
    /// `w_i` of eq 18: 1 within the threshold, `c_t / |e|` beyond.
    #[inline(always)]
    pub(crate) fn weight(&self, e: T) -> T {
        let size = e.abs();
        if size <= self.threshold { T::ONE } else { self.threshold / size }
    }

    /// The loss whose derivative is `w(e) e`.
    #[inline(always)]
    pub(crate) fn cost(&self, e: T) -> T {
        let size = e.abs();
        if size <= self.threshold {
            e * e * T::HALF
        } else {
            self.threshold * (size - self.threshold * T::HALF)
        }
    }
}

/// A loss that gives up on what is far out: the weight falls to zero, not only the pull.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Redescending {
    /// `1 / (1 + x)^2`, `x = (r / scale)^2`: smooth and wide, for graduated non-convexity.
    GemanMcClure,
    /// `(1 - x)^2` up to `x = 1`, zero beyond, `x = (r / limit)^2`: Tukey's biweight.
    Tukey,
}

impl Redescending {
    /// * `x`: the square of the residual over that of its scale.
    #[inline(always)]
    pub(crate) fn weight<T: Scalar>(self, x: T) -> T {
        let root = match self {
            Self::GemanMcClure => T::ONE / (T::ONE + x),
            Self::Tukey if x < T::ONE => T::ONE - x,
            Self::Tukey => T::ZERO,
        };
        root * root
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_the_derivatives_of_the_costs() {
        let h = 1e-6;
        for r in [-9.0, -2.0, -0.3, 0.0, 0.7, 1.9, 5.0_f64] {
            let slope = |cost: &dyn Fn(f64) -> f64| (cost(r + h) - cost(r - h)) / (2.0 * h);
            let huber = Huber { threshold: 1.0 };
            assert!((slope(&|r| huber.cost(r)) - huber.weight(r) * r).abs() < 1e-8);
            let geman_mcclure = |r: f64| 2.0 * r * r / (4.0 + r * r);
            let weight = Redescending::GemanMcClure.weight(r * r / 4.0);
            assert!((slope(&geman_mcclure) - weight * r).abs() < 1e-8, "{r}");
            let tukey = |r: f64| 4.0 / 6.0 * (1.0 - (1.0 - r * r / 4.0).max(0.0).powi(3));
            let weight = Redescending::Tukey.weight(r * r / 4.0);
            assert!((slope(&tukey) - weight * r).abs() < 1e-8, "{r}");
        }
    }
}
