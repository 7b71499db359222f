//! Numbers from 0 in a few bits, with the same relative rounding at every size: the first bits of an `f32` above an
//! offset.

use crate::scalar::Scalar;

/// Number of bits of the fraction of an `f32`.
const FRACTION: u32 = f32::MANTISSA_DIGITS - 1;

/// Format of a number in a few bits.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShortFloat {
    /// Number of low bits of an `f32` that are left out.
    left_out: u32,
    /// Other bits of the `f32` of code 0.
    first: u32,
    /// Largest code.
    most: u32,
}

impl ShortFloat {
    /// Returns the format whose code 0 is `first`, a positive normal number.
    ///
    /// * `fraction`: number of bits of the fraction; `bits`: number of bits of a code, at most 16.
    pub(super) const fn new(first: f32, fraction: u32, bits: u32) -> Self {
        let left_out = FRACTION - fraction;
        Self { left_out, first: first.to_bits() >> left_out, most: (1 << bits) - 1 }
    }

    /// Returns the nearest code of a number. It is 0 for smaller numbers and negative zero, and the largest code for
    /// larger and for negative numbers.
    pub(super) fn code<T: Scalar>(self, x: T) -> u16 {
        let half = 1 << (self.left_out - 1);
        let code = (x.to_single().to_bits().wrapping_add(half) >> self.left_out)
            .saturating_sub(self.first)
            .min(self.most);
        let [low, high, ..] = code.to_le_bytes();
        u16::from_le_bytes([low, high])
    }

    /// Returns the number of a code.
    pub(super) fn value<T: Scalar>(self, code: u16) -> T {
        T::single(f32::from_bits((u32::from(code) + self.first) << self.left_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const FORMAT: ShortFloat = ShortFloat::new(0.25, 3, 6);

    #[test]
    fn codes_and_numbers_convert_into_each_other_and_the_ends_saturate() {
        for code in 0..64 {
            assert_eq!(FORMAT.code(FORMAT.value::<f32>(code)), code);
        }
        assert_eq!([0, 16, 63].map(|code| FORMAT.value::<f64>(code)), [0.25, 1.0, 60.0]);
        let codes = [0.0, -0.0, 0.1, 100.0, f32::MAX, f32::INFINITY, f32::NAN, -1.0];
        let codes = codes.map(|x| FORMAT.code::<f32>(x));
        assert_eq!(codes, [0, 63, 0, 63, 63, 63, 63, 63]);
    }

    proptest! {
        #[test]
        fn numbers_are_rounded_by_a_sixteenth_at_most(x in 0.25..60.0_f64) {
            let back: f64 = FORMAT.value(FORMAT.code(x));
            prop_assert!((back / x - 1.0).abs() <= 1.0 / 16.0, "{x} {back}");
        }
    }
}
