//! The two number types the core is built for, and the few constants it needs of them.

use nalgebra::RealField;

mod sealed {
    #[cfg(feature = "simd")]
    #[allow(private_bounds, reason = "nobody else can name it")]
    pub trait Sealed: crate::simd::Vectorised {}
    #[cfg(not(feature = "simd"))]
    pub trait Sealed {}
    impl Sealed for f32 {}
    impl Sealed for f64 {}
}

/// `f32`, the scalar that ships, or `f64`, the reference it is tested against. Sealed.
pub trait Scalar: sealed::Sealed + RealField + Copy + Default {
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// One half.
    const HALF: Self;
    /// Minus one.
    const MINUS_ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;

    /// Bytes of the representation.
    const BYTES: u8;

    /// Each coefficient of the series of the sine over the one before, sign turned: `1 / (2 * 3)`,
    /// `1 / (4 * 5)`, and so on.
    const SINE: [Self; 11];
    /// The same of the cosine: `1 / (1 * 2)`, `1 / (3 * 4)`.
    const COSINE: [Self; 11];

    /// A constant of the source text, rounded to this type.
    #[must_use]
    fn lit(value: f64) -> Self;

    /// A parameter of a configuration, exact.
    #[must_use]
    fn single(value: f32) -> Self;

    /// A count, rounded to this type.
    #[must_use]
    fn count(value: u32) -> Self;

    /// This number as `f64`, exact.
    #[must_use]
    fn to_f64(self) -> f64;

    /// The integer part, kept within `u16`; 0 for NaN.
    #[must_use]
    fn to_u16(self) -> u16;

    /// The bits of the representation.
    #[must_use]
    fn bits(self) -> u64;

    /// The number of this representation; bits beyond it are ignored.
    #[must_use]
    fn from_bits(bits: u64) -> Self;
}

macro_rules! scalar {
    ($t:ident, $bits:ident, $bytes:literal) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const MINUS_ONE: Self = -1.0;
            const EPSILON: Self = $t::EPSILON;
            const BYTES: u8 = $bytes;
            const SINE: [Self; 11] = [
                1.0 / 6.0,
                1.0 / 20.0,
                1.0 / 42.0,
                1.0 / 72.0,
                1.0 / 110.0,
                1.0 / 156.0,
                1.0 / 210.0,
                1.0 / 272.0,
                1.0 / 342.0,
                1.0 / 420.0,
                1.0 / 506.0,
            ];
            const COSINE: [Self; 11] = [
                1.0 / 2.0,
                1.0 / 12.0,
                1.0 / 30.0,
                1.0 / 56.0,
                1.0 / 90.0,
                1.0 / 132.0,
                1.0 / 182.0,
                1.0 / 240.0,
                1.0 / 306.0,
                1.0 / 380.0,
                1.0 / 462.0,
            ];

            #[inline(always)]
            #[expect(clippy::as_conversions, reason = "rounding to nearest is meant")]
            #[allow(clippy::cast_possible_truncation, reason = "one macro, two types")]
            fn lit(value: f64) -> Self {
                value as $t
            }

            #[inline(always)]
            fn single(value: f32) -> Self {
                value.into()
            }

            #[inline(always)]
            #[expect(clippy::as_conversions, reason = "rounding to nearest is meant")]
            #[allow(
                clippy::cast_precision_loss,
                clippy::cast_lossless,
                reason = "one macro, two types"
            )]
            fn count(value: u32) -> Self {
                value as $t
            }

            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline(always)]
            #[expect(clippy::as_conversions, reason = "cutting off the fraction is meant")]
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "`as` keeps within the range"
            )]
            fn to_u16(self) -> u16 {
                self as u16
            }

            #[inline(always)]
            fn bits(self) -> u64 {
                self.to_bits().into()
            }

            #[inline(always)]
            #[expect(clippy::as_conversions, reason = "cutting off what is beyond is meant")]
            #[allow(clippy::cast_possible_truncation, reason = "one macro, two types")]
            fn from_bits(bits: u64) -> Self {
                Self::from_bits(bits as $bits)
            }
        }
    };
}

scalar!(f32, u32, 4);
scalar!(f64, u64, 8);
