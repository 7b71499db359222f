//! The two number types of the core, with the constants and conversions that it needs.

use nalgebra::RealField;

mod sealed {
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// Number type: `f32` for products, or `f64` as the reference for tests. The trait is sealed.
pub trait Scalar: sealed::Sealed + RealField + Copy + Default {
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// One half.
    const HALF: Self;
    /// Minus one.
    const MINUS_ONE: Self;
    /// Positive infinity.
    const INFINITY: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Bytes of the representation: 4 or 8.
    const BYTES: u8;

    /// Ratios of consecutive coefficients of the series of `sin(h) / h` in `h^2`, without sign:
    /// `1 / (2 * 3)`, `1 / (4 * 5)`, and so on.
    const SINE: [Self; 11];
    /// The same ratios of the series of `cos(h)`: `1 / (1 * 2)`, `1 / (3 * 4)`, and so on.
    const COSINE: [Self; 11];

    /// Converts a constant of the source text, rounded to nearest.
    #[must_use]
    fn lit(value: f64) -> Self;

    /// Converts a parameter of a configuration, exactly.
    #[must_use]
    fn single(value: f32) -> Self;

    /// Converts a count, rounded to nearest: exact up to 2^24 in `f32`.
    #[must_use]
    fn count(value: u32) -> Self;

    /// Returns this number as `f64`, exactly.
    #[must_use]
    fn to_f64(self) -> f64;

    /// Returns this number as `f32`, rounded to nearest.
    #[must_use]
    fn to_single(self) -> f32;

    /// Returns the integer part, saturated to the range of `u16`; 0 for NaN and for numbers below 0.
    #[must_use]
    fn to_u16(self) -> u16;

    /// Returns the bits of the representation, zero-extended to 64 bits.
    #[must_use]
    fn bits(self) -> u64;

    /// Returns the number of doublings after which `first` exceeds the magnitude of this number; more than 100 for NaN.
    ///
    /// * `first`: a normal number from above 0 to 1e8.
    #[must_use]
    fn doublings_of(self, first: Self) -> usize;
}

/// Reciprocals of literals, rounded in the type of the array.
macro_rules! inverses {
    ($($x:literal)*) => { [$(1.0 / $x),*] };
}

macro_rules! scalar {
    ($t:ident, $signed:ident, $bytes:literal) => {
        #[expect(clippy::as_conversions, reason = "rounding and truncation are meant")]
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        #[allow(
            clippy::cast_precision_loss,
            clippy::cast_lossless,
            reason = "one macro, two types"
        )]
        #[expect(clippy::cast_possible_wrap, reason = "the sign bit is 0")]
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const MINUS_ONE: Self = -1.0;
            const INFINITY: Self = $t::INFINITY;
            const EPSILON: Self = $t::EPSILON;
            const BYTES: u8 = $bytes;
            const SINE: [Self; 11] =
                inverses!(6.0 20.0 42.0 72.0 110.0 156.0 210.0 272.0 342.0 420.0 506.0);
            const COSINE: [Self; 11] =
                inverses!(2.0 12.0 30.0 56.0 90.0 132.0 182.0 240.0 306.0 380.0 462.0);

            #[inline]
            fn lit(value: f64) -> Self {
                value as $t
            }
            #[inline]
            fn single(value: f32) -> Self {
                value.into()
            }
            #[inline]
            fn count(value: u32) -> Self {
                value as $t
            }
            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline]
            fn to_single(self) -> f32 {
                self as f32
            }
            // Through 32 bits, because the conversion instruction of the controller saturates at 32 bits.
            #[inline]
            fn to_u16(self) -> u16 {
                (self as u32).min(0xffff) as u16
            }
            #[inline]
            fn bits(self) -> u64 {
                self.to_bits().into()
            }
            // Numbers above 0 are in the order of their bits, and a doubling adds 1 to the exponent.
            #[inline]
            fn doublings_of(self, first: Self) -> usize {
                let [own, first] = [self.abs(), first].map(|x| x.to_bits() as $signed);
                (((own - first) >> ($t::MANTISSA_DIGITS - 1)) + 1).max(0) as usize
            }
        }
    };
}

scalar!(f32, i32, 4);
scalar!(f64, i64, 8);
