//! Compensated sums: the rounding error of each addition is added with the next term (Kahan, with Knuth's exact
//! two-term sum).

use crate::scalar::Scalar;

/// A running sum whose error does not grow with the number of terms.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sum<T> {
    sum: T,
    /// Rounding error of `sum`.
    lost: T,
}

impl<T: Scalar> Sum<T> {
    pub(super) const ZERO: Self = Self { sum: T::ZERO, lost: T::ZERO };

    /// Adds a term. The last bits of the sum depend on the order of the terms.
    pub(super) fn add(&mut self, x: T) {
        let x = x + self.lost;
        let total = self.sum + x;
        let taken = total - self.sum;
        self.lost = (self.sum - (total - taken)) + (x - taken);
        self.sum = total;
    }

    /// Returns the sum.
    pub(super) fn value(&self) -> T {
        self.sum + self.lost
    }
}

#[cfg(test)]
mod tests {
    use super::Sum;

    #[test]
    fn a_million_small_terms_survive_beside_a_large_one() {
        let mut sum = Sum::<f32>::ZERO;
        sum.add(1e6);
        for _ in 0..1_000_000 {
            sum.add(1e-3);
        }
        assert_eq!(sum.value(), 1_001_000.0);
    }
}
