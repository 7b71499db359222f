//! The arithmetic of the inner loop: on one correspondence, or on several side by side.

mod four;
#[cfg(feature = "simd")]
mod wide;

pub(crate) use four::{Four, Quad};

#[cfg(feature = "simd")]
pub(crate) use wide::{Vectorised, dispatch};

use core::ops::{Add, Div, Mul, Sub};

use crate::scalar::Scalar;

/// A number for each correspondence.
pub(crate) trait Value:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl<V> Value for V where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<Output = V> + Div<Output = V>
{
}

/// So many correspondences at a time.
pub(crate) trait Lanes<T>: Copy {
    /// A number for each of them.
    type Value: Value;

    /// A yes or no for each.
    type Mask: Copy;

    /// The same number for all.
    fn all(self, x: T) -> Self::Value;

    /// `a b + c`, rounded once or twice.
    fn mul_add(self, a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value;

    /// `c - a b`, rounded once or twice.
    fn less_product(self, c: Self::Value, a: Self::Value, b: Self::Value) -> Self::Value;

    /// `a >= b`: not for a NaN.
    fn at_least(self, a: Self::Value, b: Self::Value) -> Self::Mask;

    /// `a < b`: not for a NaN.
    fn below(self, a: Self::Value, b: Self::Value) -> Self::Mask;

    /// Whether both say so.
    fn both(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// Whether any of them says so. Lanes that find out no faster than they compute say yes.
    fn is_any(self, mask: Self::Mask) -> bool;

    /// `a` where the mask says so, else `b`.
    fn choose(self, mask: Self::Mask, a: Self::Value, b: Self::Value) -> Self::Value;

    /// The sum over the correspondences.
    fn total(self, x: Self::Value) -> T;

    /// The sums of several numbers over the correspondences. A loop: `map` is not always inlined, and
    /// on its own has no vector instructions.
    #[inline(always)]
    fn totals<const N: usize>(self, numbers: &[Self::Value; N]) -> [T; N]
    where
        T: Scalar,
    {
        let mut totals = [T::ZERO; N];
        for (total, x) in totals.iter_mut().zip(numbers) {
            *total = self.total(*x);
        }
        totals
    }

    /// `a`, or zero where the mask says no.
    #[inline(always)]
    fn keep(self, mask: Self::Mask, a: Self::Value) -> Self::Value
    where
        T: Scalar,
    {
        self.choose(mask, a, self.all(T::ZERO))
    }
}

/// One at a time: the reference, and what runs on a controller.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Single;

impl<T: Scalar> Lanes<T> for Single {
    type Value = T;
    type Mask = bool;

    #[inline(always)]
    fn all(self, x: T) -> T {
        x
    }

    #[inline(always)]
    fn mul_add(self, a: T, b: T, c: T) -> T {
        a * b + c
    }

    #[inline(always)]
    fn less_product(self, c: T, a: T, b: T) -> T {
        c - a * b
    }

    #[inline(always)]
    fn at_least(self, a: T, b: T) -> bool {
        a >= b
    }

    #[inline(always)]
    fn below(self, a: T, b: T) -> bool {
        a < b
    }

    #[inline(always)]
    fn both(self, a: bool, b: bool) -> bool {
        a && b
    }

    #[inline(always)]
    fn is_any(self, mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn choose(self, mask: bool, a: T, b: T) -> T {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn total(self, x: T) -> T {
        x
    }
}
