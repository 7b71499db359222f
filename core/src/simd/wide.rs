//! Vector lanes of the host processor: AVX2 or NEON, found at run time by `pulp`.

use core::ops::{Add, Div, Mul, Sub};

use pulp::bytemuck::cast;
use pulp::{Arch, Simd, WithSimd};

use super::Lanes;

/// Runs `op` on the widest lanes of the processor; `None` where `pulp` knows of none:
/// [`super::Quads`] or [`super::Single`] is faster there.
pub(crate) fn dispatch<Op: WithSimd>(op: Op) -> Option<Op::Output> {
    match Arch::new() {
        Arch::Scalar => None,
        arch => Some(arch.dispatch(op)),
    }
}

/// A number type with vector lanes.
pub(crate) trait Vectorised: super::Number + 'static {
    /// Lanes of the instruction set `S`.
    type Wide<S: Simd>: Lanes<Self>;

    /// One vector in memory.
    type Stored<S: Simd>: Copy;

    /// The lanes of an instruction set.
    fn wide<S: Simd>(simd: S) -> Self::Wide<S>;

    /// Splits a column into whole vectors and the remainder.
    fn split<S: Simd>(column: &[Self]) -> (&[Self::Stored<S>], &[Self]);

    /// Loads a vector.
    fn load<S: Simd>(simd: S, stored: &Self::Stored<S>) -> <Self::Wide<S> as Lanes<Self>>::Value;
}

macro_rules! operators {
    ($packed:ident: $($operator:ident $method:ident $instruction:ident),*) => {$(
        impl<S: Simd> $operator for $packed<S> {
            type Output = Self;
            inlined! {
                fn $method(self, other: Self) -> Self {
                    Self { values: self.simd.$instruction(self.values, other.values), ..self }
                }
            }
        }
    )*};
}

macro_rules! vectorised {
    ($t:ident, $wide:ident, $packed:ident, $values:ident, $masks:ident, $bits:ident, $and_bits:ident, $as_simd:ident,
     $splat:ident, $add:ident, $sub:ident, $mul:ident, $div:ident, $mul_add:ident,
     $negate_mul_add:ident, $ge:ident, $lt:ident, $and:ident, $select:ident, $sum:ident, $sqrt:ident) => {
        /// The lanes of an instruction set.
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct $wide<S>(S);

        /// One number per lane.
        #[derive(Debug, Clone, Copy)]
        pub(crate) struct $packed<S: Simd> {
            simd: S,
            values: S::$values,
        }

        operators!($packed: Add add $add, Sub sub $sub, Mul mul $mul, Div div $div);

        impl<S: Simd> $wide<S> {
            inlined! {
                fn packed(self, values: S::$values) -> $packed<S> { $packed { simd: self.0, values } }
            }
        }

        impl<S: Simd> Lanes<$t> for $wide<S> {
            const BLOCK: usize = 8;
            type Value = $packed<S>;
            type Mask = S::$masks;
            type Sum = $packed<S>;

            inlined! {
                fn splat(self, x: $t) -> $packed<S> { self.packed(self.0.$splat(x)) }
                fn mul_add(self, a: $packed<S>, b: $packed<S>, c: $packed<S>) -> $packed<S> {
                    self.packed(self.0.$mul_add(a.values, b.values, c.values))
                }
                fn neg_mul_add(self, a: $packed<S>, b: $packed<S>, c: $packed<S>) -> $packed<S> {
                    self.packed(self.0.$negate_mul_add(a.values, b.values, c.values))
                }
                fn ge(self, a: $packed<S>, b: $packed<S>) -> S::$masks { self.0.$ge(a.values, b.values) }
                fn lt(self, a: $packed<S>, b: $packed<S>) -> S::$masks { self.0.$lt(a.values, b.values) }
                fn and(self, a: S::$masks, b: S::$masks) -> S::$masks { self.0.$and(a, b) }
                fn select(self, mask: S::$masks, a: $packed<S>, b: $packed<S>) -> $packed<S> {
                    self.packed(self.0.$select(mask, a.values, b.values))
                }
                fn keep(self, mask: S::$masks, a: $packed<S>) -> $packed<S> {
                    let bits = cast::<S::$masks, S::$bits>(mask);
                    let values = cast::<S::$values, S::$bits>(a.values);
                    self.packed(cast(self.0.$and_bits(bits, values)))
                }
                fn sqrt(self, x: $packed<S>) -> $packed<S> { self.packed(self.0.$sqrt(x.values)) }
                fn reduce(self, x: $packed<S>) -> $t { self.0.$sum(x.values) }
                // The lanes start at 0; `store` adds their total to the number that they continue.
                fn resume(self, _: $t) -> $packed<S> { self.splat(0.0) }
                fn add(self, sum: &mut $packed<S>, x: $packed<S>) { *sum = *sum + x; }
                fn add_product(self, sum: &mut $packed<S>, a: $packed<S>, b: $packed<S>) {
                    *sum = self.mul_add(a, b, *sum);
                }
                fn store(self, sum: $packed<S>, to: &mut $t) { *to += self.reduce(sum); }
            }
        }

        impl Vectorised for $t {
            type Wide<S: Simd> = $wide<S>;
            type Stored<S: Simd> = S::$values;

            inlined! {
                fn wide<S: Simd>(simd: S) -> $wide<S> { $wide(simd) }
                fn split<S: Simd>(column: &[$t]) -> (&[S::$values], &[$t]) { S::$as_simd(column) }
                fn load<S: Simd>(simd: S, stored: &S::$values) -> $packed<S> {
                    $packed { simd, values: *stored }
                }
            }
        }
    };
}

#[rustfmt::skip]
vectorised!(
    f32, WideF32, PackedF32, f32s, m32s, u32s, and_u32s, as_simd_f32s,
    splat_f32s, add_f32s, sub_f32s, mul_f32s, div_f32s, mul_add_e_f32s,
    negate_mul_add_e_f32s, greater_than_or_equal_f32s, less_than_f32s, and_m32s, select_f32s, reduce_sum_f32s, sqrt_f32s
);
#[rustfmt::skip]
vectorised!(
    f64, WideF64, PackedF64, f64s, m64s, u64s, and_u64s, as_simd_f64s,
    splat_f64s, add_f64s, sub_f64s, mul_f64s, div_f64s, mul_add_e_f64s,
    negate_mul_add_e_f64s, greater_than_or_equal_f64s, less_than_f64s, and_m64s, select_f64s, reduce_sum_f64s, sqrt_f64s
);
