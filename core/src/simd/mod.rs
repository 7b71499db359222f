//! Arithmetic of the inner loops: on one correspondence, on four, or on a whole vector unit.
//!
//! A formula written once over [`Lanes`] serves the controller ([`Single`]), any host ([`Quads`],
//! bit-identical to [`Single`]), and vector units (`Wide`, feature `simd`, equal to rounding).

/// Defines methods with `#[inline(always)]`: at opt-level "s" a call costs more than the operation.
macro_rules! inlined {
    ($(fn $name:ident $(<$g:ident: $bound:ident>)? ($($parameter:tt)*) $(-> $output:ty)? $body:block)*) => {$(
        #[inline(always)]
        fn $name $(<$g: $bound>)? ($($parameter)*) $(-> $output)? $body
    )*};
}
pub(crate) use inlined;

mod quads;
#[cfg(feature = "simd")]
mod wide;

pub(crate) use quads::{Quad, Quads};
#[cfg(feature = "simd")]
pub(crate) use wide::{Vectorised, dispatch};

use core::ops::{Add, Div, Mul, Sub};

use nalgebra::ComplexField;

/// One number per lane, with the four operations lane by lane.
pub(crate) trait Value:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
}

impl<V> Value for V where
    V: Copy + Add<Output = V> + Sub<Output = V> + Mul<Output = V> + Div<Output = V>
{
}

/// Number type of one lane: `f32` or `f64`. The default is 0.
pub(crate) trait Number: Value + Default + PartialOrd + ComplexField {}

impl<T: Value + Default + PartialOrd + ComplexField> Number for T {}

/// A set of lanes: one correspondence in each.
pub(crate) trait Lanes<T: Number>: Copy {
    /// Groups of lanes that are computed before they are summed: the registers hold the terms of
    /// either step, not of both.
    const BLOCK: usize;

    /// One number per lane.
    type Value: Value;

    /// One truth value per lane.
    type Mask: Copy;

    /// A sum over the batch: one number where the order of summation is that of [`Single`], else
    /// one number per lane.
    type Sum: Copy;

    /// `x` in every lane.
    fn splat(self, x: T) -> Self::Value;

    /// `a b + c`, rounded once or twice.
    #[inline(always)]
    fn mul_add(self, a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value {
        a * b + c
    }

    /// `c - a b`, rounded once or twice.
    #[inline(always)]
    fn neg_mul_add(self, a: Self::Value, b: Self::Value, c: Self::Value) -> Self::Value {
        c - a * b
    }

    /// `a >= b`; false for NaN.
    fn ge(self, a: Self::Value, b: Self::Value) -> Self::Mask;

    /// `a < b`; false for NaN.
    fn lt(self, a: Self::Value, b: Self::Value) -> Self::Mask;

    /// Logical and.
    fn and(self, a: Self::Mask, b: Self::Mask) -> Self::Mask;

    /// Whether a lane is true. The default is true without a test: on several lanes the test costs
    /// as much as the computation it saves.
    #[inline(always)]
    fn any(self, _: Self::Mask) -> bool {
        true
    }

    /// `a` where the mask is true, else `b`.
    fn select(self, mask: Self::Mask, a: Self::Value, b: Self::Value) -> Self::Value;

    /// `a` where the mask is true, else 0.
    #[inline(always)]
    fn keep(self, mask: Self::Mask, a: Self::Value) -> Self::Value {
        self.select(mask, a, self.splat(T::default()))
    }

    /// Square root, correctly rounded.
    fn sqrt(self, x: Self::Value) -> Self::Value;

    /// The number, where there is one lane.
    #[inline(always)]
    fn single(self, _: Self::Value) -> Option<T> {
        None
    }

    /// Sum over the lanes.
    fn reduce(self, x: Self::Value) -> T;

    /// A sum over the batch that continues `from`.
    fn resume(self, from: T) -> Self::Sum;

    /// Adds `x` to a sum over the batch.
    fn add(self, sum: &mut Self::Sum, x: Self::Value);

    /// Adds `a b` to a sum over the batch, rounded once or twice.
    #[inline(always)]
    fn add_product(self, sum: &mut Self::Sum, a: Self::Value, b: Self::Value) {
        self.add(sum, a * b);
    }

    /// Stores a sum over the batch in the number that it continues.
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
}

/// One correspondence: the reference, and the code of the controller.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Single;

impl<T: Number> Lanes<T> for Single {
    const BLOCK: usize = 1;
    type Value = T;
    type Mask = bool;
    type Sum = T;

    inlined! {
        fn splat(self, x: T) -> T { x }
        fn ge(self, a: T, b: T) -> bool { a >= b }
        fn lt(self, a: T, b: T) -> bool { a < b }
        fn and(self, a: bool, b: bool) -> bool { a && b }
        fn any(self, mask: bool) -> bool { mask }
        fn select(self, mask: bool, a: T, b: T) -> T { if mask { a } else { b } }
        fn sqrt(self, x: T) -> T { ComplexField::sqrt(x) }
        fn single(self, x: T) -> Option<T> { Some(x) }
        fn reduce(self, x: T) -> T { x }
        fn resume(self, from: T) -> T { from }
        fn add(self, sum: &mut T, x: T) { *sum += x; }
        fn store(self, sum: T, to: &mut T) { *to = sum; }
    }
}
