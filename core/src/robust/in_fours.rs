//! The same pass over four correspondences at a time, in all bits: a host takes half the time for it.

use core::array::from_fn;
use core::hint::black_box;
use core::mem::replace;

use super::Descent;
use super::pass::{Pass, spread_over};
use super::weighing::{Counts, Weighed};
use crate::correspondence::RayPair;
use crate::lanes::{Four, Lanes, Quad};
use crate::quadratic::Quadratic;
use crate::scalar::Scalar;

/// Fours that are weighed before they are summed: a compiler computes four numbers at once where they go
/// to memory side by side.
const BLOCK: usize = 4;

impl<T: Scalar> Descent<T> {
    /// As [`Descent::pass_one_by_one`], in all bits: weighed side by side, summed one by one.
    pub(super) fn pass_in_fours(&self, pairs: &[RayPair<T>], most: usize) -> Pass<T> {
        // From memory a number comes with the operation; the compiler would copy it to all lanes anew.
        let by = black_box(self.weighing(Four));
        let zero = Four.all(T::ZERO);
        let (mut counts, mut capped) = (Counts::zero(Four), Quadratic::ZERO);
        let mut near_squares = T::ZERO;
        let mut pairs = spread_over(pairs, most);
        let (mut rest, mut filled) = ([None; 4], BLOCK);
        let mut block = [Weighed::nothing(Four); BLOCK];
        while filled == BLOCK {
            filled = 0;
            for place in &mut block {
                let next: [_; 4] = from_fn(|_| pairs.next());
                let [Some(a), Some(b), Some(c), Some(d)] = next else {
                    rest = next;
                    break;
                };
                let four = [a, b, c, d];
                let rays = Quad::columns(four.map(RayPair::rays));
                let weighed = counts.weigh(Four, &by, rays, Quad(four.map(RayPair::grid_step)));
                *place = weighed.unwrap_or(Weighed::nothing(Four));
                // One by one too: the order of a sum is in its bits.
                for squares in replace(&mut counts.near_squares, zero).0 {
                    near_squares += squares;
                }
                filled += 1;
            }
            for four in block.get(..filled).unwrap_or_default() {
                for Weighed { weight, value, jacobian } in four.rows() {
                    capped.add_row(weight, value, &jacobian);
                }
            }
        }
        let counts = Counts { near_squares, ..counts.total(Four) };
        self.pass_onward(rest.into_iter().flatten(), counts, capped)
    }
}

impl<T: Scalar> Weighed<Quad<T>> {
    #[inline(always)]
    fn rows(&self) -> impl Iterator<Item = Weighed<T>> {
        let Self { weight, value, jacobian: [j0, j1, j2, j3, j4] } = self;
        let rows = weight.0.iter().zip(&value.0).zip(&j0.0).zip(&j1.0).zip(&j2.0);
        rows.zip(&j3.0).zip(&j4.0).map(|((((((weight, value), j0), j1), j2), j3), j4)| Weighed {
            weight: *weight,
            value: *value,
            jacobian: [*j0, *j1, *j2, *j3, *j4],
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::scenes::{batch, descents};
    use super::*;
    use proptest::prelude::*;

    fn agree<T: Scalar>(pixels: &[[f64; 4]], rotation: [f64; 3], t: [f64; 2], most: usize) {
        let batch = batch::<T>(pixels);
        for descent in descents(&batch, rotation, t) {
            let one = descent.pass_one_by_one(batch.pairs(), most);
            let fours = descent.pass_in_fours(batch.pairs(), most);
            let bits = |x: T| x.to_f64().to_bits();
            let upper = |pass: &Pass<T>| pass.capped.information.0.0.map(bits);
            assert_eq!(upper(&one), upper(&fours));
            assert_eq!(one.capped.gradient.map(bits), fours.capped.gradient.map(bits));
            assert_eq!(bits(one.near_squares), bits(fours.near_squares));
            let counts = |pass: &Pass<T>| [pass.usable, pass.weighted, pass.near];
            assert_eq!(counts(&one), counts(&fours));
        }
    }

    proptest! {
        #[test]
        fn a_pass_in_fours_is_that_one_by_one_in_all_bits(
            pixels in prop::collection::vec([200.0..7800.0, 0.0..599.0, -5.0..80.0, -3.0..3.0], 0..100),
            rotation in [-0.1..0.1, -0.3..0.3, -0.1..0.1], t in [-0.1..0.1, -0.1..0.1],
            most in prop_oneof![Just(usize::MAX), 1..100_usize],
        ) {
            agree::<f64>(&pixels, rotation, t, most);
            agree::<f32>(&pixels, rotation, t, most);
        }
    }
}
