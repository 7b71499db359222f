//! Four correspondences at a time as arrays, which the compiler vectorises.

use core::ops::{Add, Div, Mul, Sub};

use nalgebra::ComplexField;

use super::{Lanes, Number};

/// Four lanes, each bit-identical to [`super::Single`]; sums keep the order of the batch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quads;

impl Quads {
    /// Whether the target has baseline vector instructions; without them four lanes need too many
    /// registers.
    pub(crate) const SUPPORTED: bool = cfg!(any(target_arch = "x86_64", target_arch = "aarch64"));
}

/// One number for each of four lanes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Quad<T>(pub(crate) [T; 4]);

impl<T: Copy> Quad<T> {
    /// Transposes: four numbers of each of four correspondences to four lanes of each number.
    #[inline(always)]
    pub(crate) fn columns(
        [[a, b, c, d], [e, f, g, h], [i, j, k, l], [m, n, o, p]]: [[T; 4]; 4],
    ) -> [Self; 4] {
        [Self([a, e, i, m]), Self([b, f, j, n]), Self([c, g, k, o]), Self([d, h, l, p])]
    }

    /// `f` lane by lane.
    #[inline(always)]
    fn zip<U: Copy, V>(self, other: Quad<U>, f: impl Fn(T, U) -> V) -> Quad<V> {
        let ([a, b, c, d], [e, g, h, i]) = (self.0, other.0);
        Quad([f(a, e), f(b, g), f(c, h), f(d, i)])
    }
}

macro_rules! lane_by_lane {
    ($($operator:ident $method:ident $symbol:tt),*) => {$(
        impl<T: Number> $operator for Quad<T> {
            type Output = Self;
            inlined! {
                fn $method(self, other: Self) -> Self { self.zip(other, |a, b| a $symbol b) }
            }
        }
    )*};
}

lane_by_lane!(Add add +, Sub sub -, Mul mul *, Div div /);

impl<T: Number> Lanes<T> for Quads {
    const BLOCK: usize = 4;
    type Value = Quad<T>;
    type Mask = Quad<bool>;
    type Sum = T;

    inlined! {
        fn splat(self, x: T) -> Quad<T> { Quad([x; 4]) }
        fn ge(self, a: Quad<T>, b: Quad<T>) -> Quad<bool> { a.zip(b, |a, b| a >= b) }
        fn lt(self, a: Quad<T>, b: Quad<T>) -> Quad<bool> { a.zip(b, |a, b| a < b) }
        fn and(self, a: Quad<bool>, b: Quad<bool>) -> Quad<bool> { a.zip(b, |a, b| a & b) }
        fn select(self, mask: Quad<bool>, a: Quad<T>, b: Quad<T>) -> Quad<T> {
            mask.zip(a.zip(b, |a, b| (a, b)), |mask, (a, b)| if mask { a } else { b })
        }
        fn sqrt(self, x: Quad<T>) -> Quad<T> { Quad(x.0.map(ComplexField::sqrt)) }
        fn reduce(self, x: Quad<T>) -> T {
            let [a, b, c, d] = x.0;
            a + b + c + d
        }
        fn resume(self, from: T) -> T { from }
        fn add(self, sum: &mut T, x: Quad<T>) {
            let [a, b, c, d] = x.0;
            *sum = *sum + a + b + c + d;
        }
        fn store(self, sum: T, to: &mut T) { *to = sum; }
    }
}
