//! The two number types the core is built for, and the few constants it needs of them.

use nalgebra::RealField;

mod sealed {
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

    /// A constant of the source text or of a configuration, rounded to this type.
    #[must_use]
    fn lit(value: f64) -> Self;

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
}

macro_rules! scalar {
    ($t:ident) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const HALF: Self = 0.5;
            const MINUS_ONE: Self = -1.0;
            const EPSILON: Self = $t::EPSILON;

            #[inline]
            #[expect(clippy::as_conversions, reason = "rounding to nearest is meant")]
            #[allow(clippy::cast_possible_truncation, reason = "one macro, two types")]
            fn lit(value: f64) -> Self {
                value as $t
            }

            #[inline]
            #[expect(clippy::as_conversions, reason = "rounding to nearest is meant")]
            #[allow(
                clippy::cast_precision_loss,
                clippy::cast_lossless,
                reason = "one macro, two types"
            )]
            fn count(value: u32) -> Self {
                value as $t
            }

            #[inline]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }

            #[inline]
            #[expect(clippy::as_conversions, reason = "cutting off the fraction is meant")]
            #[allow(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "`as` keeps within the range"
            )]
            fn to_u16(self) -> u16 {
                self as u16
            }

            #[inline]
            fn bits(self) -> u64 {
                self.to_bits().into()
            }
        }
    };
}

scalar!(f32);
scalar!(f64);
