//! Compensated sums: the rounding error of an addition enters the next one (Kahan, with Knuth's exact two-term sum).

use crate::codec::{Reader, Writer};
use crate::error::RestoreError;
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

    /// Adds a term; the order of terms decides the bits.
    pub(super) fn add(&mut self, x: T) {
        let x = x + self.lost;
        let total = self.sum + x;
        let taken = total - self.sum;
        self.lost = (self.sum - (total - taken)) + (x - taken);
        self.sum = total;
    }

    pub(super) fn write(&self, to: &mut Writer<'_>) {
        to.numbers(&[self.sum, self.lost]);
    }

    /// Reads a record.
    ///
    /// * `limit`: largest absolute value.
    ///
    /// # Errors
    /// [`RestoreError`] beyond the limit.
    pub(super) fn read(&mut self, from: &mut Reader<'_>, limit: T) -> Result<(), RestoreError> {
        from.numbers_within(limit, [&mut self.sum, &mut self.lost])
    }

    /// The sum.
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
