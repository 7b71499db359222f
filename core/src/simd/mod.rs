//! Arithmetic of the inner loops: on one correspondence, on four, or on as many as a vector unit holds.
//!
//! A formula written once over [`Lanes`] serves the controller ([`Single`]), any host ([`Quads`], with the bits of
//! [`Single`]), and vector units (`Wide`, feature `simd`, equal to rounding).

mod quads;
#[cfg(feature = "simd")]
mod wide;

pub(crate) use quads::{Quad, Quads};
#[cfg(feature = "simd")]
pub(crate) use wide::{Vectorised, dispatch};

use core::ops::{Add, Div, Mul, Sub};

/// A number per lane.
pub(crate) trait Value:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl<V> Value for V where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<Output = V> + Div<Output = V>
{
}

/// A number type of the lanes.
pub(crate) trait Number: Value + Default + PartialOrd {}

impl<T: Value + Default + PartialOrd> Number for T {}

/// A set of lanes: one correspondence in each.
pub(crate) trait Lanes<T: Number>: Copy {
    /// Groups of lanes that are computed before they are summed: registers hold the terms of either step, not of both.
    const BLOCK: usize;

    /// A number per lane.
    type Value: Value;

    /// A truth value per lane.
    type Mask: Copy;

    /// A sum over the batch: one number where the order of summation is that of [`Single`], else a number per lane.
    type Sum: Copy;

    /// `x` in every lane.
    fn splat(self, x: T) -> Self::Value;

    /// `a b + c`, rounded once or twice.
    fn mul_add(self, a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value;

    /// `c - a b`, rounded once or twice.
    fn neg_mul_add(self, a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value;

    /// `a >= b`; false for NaN.
    fn ge(self, a: Self::Value, b: Self::Value) -> Self::Mask;

    /// `a < b`; false for NaN.
    fn lt(self, a: Self::Value, b: Self::Value) -> Self::Mask;

    /// Logical and.
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// Whether a lane is true. Lanes on which the test costs as much as the computation it saves return true.
    fn any(self, mask: Self::Mask) -> bool;

    /// `a` where the mask is true, else `b`.
    fn select(self, mask: Self::Mask, a: Self::Value, b: Self::Value) -> Self::Value;

    /// Sum over the lanes.
    fn reduce(self, x: Self::Value) -> T;

    /// A sum over the batch that goes on from `from`.
    fn resume(self, from: T) -> Self::Sum;

    /// Adds `x` to a sum over the batch.
    fn add(self, sum: &mut Self::Sum, x: Self::Value);

    /// Adds `a b` to a sum over the batch.
    fn add_product(self, sum: &mut Self::Sum, a: Self::Value, b: Self::Value);

    /// Stores a sum over the batch in the number that it has gone on from.
    fn store(self, sum: Self::Sum, to: &mut T);

    /// [`Lanes::store`] of several sums.
    #[inline(always)]
    fn store_all<'t>(
        self,
        sums: impl IntoIterator<Item = Self::Sum>,
        to: impl IntoIterator<Item = &'t mut T>,
    ) where
        T: 't,
    {
        for (to, sum) in to.into_iter().zip(sums) {
            self.store(sum, to);
        }
    }

    /// `a` where the mask is true, else 0.
    #[inline(always)]
    fn keep(self, mask: Self::Mask, a: Self::Value) -> Self::Value {
        self.select(mask, a, self.splat(T::default()))
    }
}

/// One correspondence: the reference, and the code of the controller.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Single;

impl<T: Number> Lanes<T> for Single {
    const BLOCK: usize = 1;
    type Value = T;
    type Mask = bool;
    type Sum = T;

    #[inline(always)]
    fn splat(self, x: T) -> T {
        x
    }

    #[inline(always)]
    fn mul_add(self, a: T, b: T, c: T) -> T {
        a * b + c
    }

    #[inline(always)]
    fn neg_mul_add(self, a: T, b: T, c: T) -> T {
        c - a * b
    }

    #[inline(always)]
    fn ge(self, a: T, b: T) -> bool {
        a >= b
    }

    #[inline(always)]
    fn lt(self, a: T, b: T) -> bool {
        a < b
    }

    #[inline(always)]
    fn and(self, a: bool, b: bool) -> bool {
        a && b
    }

    #[inline(always)]
    fn any(self, mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn select(self, mask: bool, a: T, b: T) -> T {
        if mask { a } else { b }
    }

    #[inline(always)]
    fn reduce(self, x: T) -> T {
        x
    }

    #[inline(always)]
    fn resume(self, from: T) -> T {
        from
    }

    #[inline(always)]
    fn add(self, sum: &mut T, x: T) {
        *sum = *sum + x;
    }

    #[inline(always)]
    fn add_product(self, sum: &mut T, a: T, b: T) {
        *sum = *sum + a * b;
    }

    #[inline(always)]
    fn store(self, sum: T, to: &mut T) {
        *to = sum;
    }
}
