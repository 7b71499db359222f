//! Four correspondences at a time, each computed as if it were alone: for processors that any compiler
//! may ask for four numbers at once.

use core::ops::{Add, Div, Mul, Sub};

use super::Lanes;
use crate::scalar::Scalar;

/// Four at a time: of each what [`super::Single`] makes of it, in all bits.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Four;

impl Four {
    /// Whether the processor has instructions for them. Where not, they would but crowd its registers.
    pub(crate) const AT_ONCE: bool = cfg!(any(target_arch = "x86_64", target_arch = "aarch64"));
}

/// A number for each of four.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quad<T>(pub(crate) [T; 4]);

impl<T: Copy> Quad<T> {
    /// Numbers of four correspondences, each with its own together, as each of the numbers together.
    #[inline(always)]
    pub(crate) fn columns(
        [[a, b, c, d], [e, f, g, h], [i, j, k, l], [m, n, o, p]]: [[T; 4]; 4],
    ) -> [Self; 4] {
        [Self([a, e, i, m]), Self([b, f, j, n]), Self([c, g, k, o]), Self([d, h, l, p])]
    }

    #[inline(always)]
    fn with<U: Copy, V>(self, other: Quad<U>, f: impl Fn(T, U) -> V) -> Quad<V> {
        let ([a, b, c, d], [e, g, h, i]) = (self.0, other.0);
        Quad([f(a, e), f(b, g), f(c, h), f(d, i)])
    }
}

impl<T: Scalar> Add for Quad<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.with(other, |a, b| a + b)
    }
}

impl<T: Scalar> Sub for Quad<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.with(other, |a, b| a - b)
    }
}

impl<T: Scalar> Mul for Quad<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.with(other, |a, b| a * b)
    }
}

impl<T: Scalar> Div for Quad<T> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.with(other, |a, b| a / b)
    }
}

impl<T: Scalar> Lanes<T> for Four {
    type Value = Quad<T>;
    type Mask = Quad<bool>;

    #[inline(always)]
    fn all(self, x: T) -> Quad<T> {
        Quad([x; 4])
    }

    #[inline(always)]
    fn mul_add(self, a: Quad<T>, b: Quad<T>, c: Quad<T>) -> Quad<T> {
        a * b + c
    }

    #[inline(always)]
    fn less_product(self, c: Quad<T>, a: Quad<T>, b: Quad<T>) -> Quad<T> {
        c - a * b
    }

    #[inline(always)]
    fn at_least(self, a: Quad<T>, b: Quad<T>) -> Quad<bool> {
        a.with(b, |a, b| a >= b)
    }

    #[inline(always)]
    fn below(self, a: Quad<T>, b: Quad<T>) -> Quad<bool> {
        a.with(b, |a, b| a < b)
    }

    #[inline(always)]
    fn both(self, a: Quad<bool>, b: Quad<bool>) -> Quad<bool> {
        a.with(b, |a, b| a & b)
    }

    #[inline(always)]
    fn is_any(self, _: Quad<bool>) -> bool {
        true
    }

    #[inline(always)]
    fn choose(self, mask: Quad<bool>, a: Quad<T>, b: Quad<T>) -> Quad<T> {
        let ([m, n, o, p], [a, c, e, g], [b, d, f, h]) = (mask.0, a.0, b.0);
        let one = |yes: bool, a: T, b: T| if yes { a } else { b };
        Quad([one(m, a, b), one(n, c, d), one(o, e, f), one(p, g, h)])
    }

    #[inline(always)]
    fn total(self, x: Quad<T>) -> T {
        let [a, b, c, d] = x.0;
        a + b + c + d
    }
}
