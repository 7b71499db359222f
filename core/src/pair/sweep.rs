//! One pass over the batch: a source of correspondences feeds a sink of sums, on lanes of the processor.
//!
//! [`Pass`] names the sums, [`Sink`] adds terms to them, [`run`] selects the lanes: [`Single`], [`Quads`], or with the
//! feature `simd` vector lanes. [`Single`] and [`Quads`] give the same bits; vector lanes agree to rounding.

use core::array::from_fn;
use core::hint::black_box;
use core::iter;

use crate::batch::Matches;
use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Number, Quad, Quads, Single};

/// Rays `x_l`, `y_l`, `x_r`, `y_r` at unit depth, and the grid step, px.
pub(super) type Sample<V> = ([V; 4], V);

/// Largest [`Lanes::BLOCK`].
const MAX_BLOCK: usize = 8;

/// Rows of [`sweep_gathered`].
const GATHERED: usize = 8;

/// Sums over correspondences, by one expression for all lanes.
pub(super) trait Sink<T: Scalar, L: Lanes<T>> {
    /// Terms that correspondences add to the sums.
    type Row: Copy;

    /// Terms of one correspondence per lane; `None` if all of them are zero.
    fn row(&mut self, lanes: L, sample: Sample<L::Value>) -> Option<Self::Row>;

    /// Terms of zero.
    fn none(lanes: L) -> Self::Row;

    /// Adds terms to the sums, in order.
    fn add(&mut self, lanes: L, rows: &[Self::Row]);

    /// As [`Sink::add`] of one row, bit for bit; without its loop, which costs instructions on a controller.
    fn add_one(&mut self, lanes: L, row: Self::Row);
}

/// A pass with its sums, on any lanes.
pub(super) trait Pass<T: Scalar> {
    /// Whether [`Quads`] are faster than [`Single`] where the target supports them.
    const QUADS: bool;

    /// Adds the correspondences of a source.
    fn sweep<L: Lanes<T>>(&mut self, lanes: L, source: impl Iterator<Item = Sample<L::Value>>);

    /// [`Pass::sweep`] over [`Single`].
    #[inline(always)]
    fn sweep_single(&mut self, source: impl Iterator<Item = Sample<T>>) {
        self.sweep(Single, source);
    }
}

/// Feeds a source to a sink, [`Lanes::BLOCK`] samples at a time.
#[inline(always)]
pub(super) fn sweep<T: Scalar, L: Lanes<T>, S: Sink<T, L>>(
    lanes: L,
    mut source: impl Iterator<Item = Sample<L::Value>>,
    sink: &mut S,
) {
    const { assert!(L::BLOCK <= MAX_BLOCK) };
    if L::BLOCK == 1 {
        for sample in source {
            if let Some(row) = sink.row(lanes, sample) {
                sink.add_one(lanes, row);
            }
        }
        return;
    }
    let mut block = [S::none(lanes); MAX_BLOCK];
    let mut filled = L::BLOCK;
    while filled == L::BLOCK {
        filled = 0;
        for (row, sample) in block.iter_mut().take(L::BLOCK).zip(&mut source) {
            *row = sink.row(lanes, sample).unwrap_or(S::none(lanes));
            filled += 1;
        }
        sink.add(lanes, block.get(..filled).unwrap_or_default());
    }
}

/// [`sweep`] over [`Single`], where each row adds to many sums: adds [`GATHERED`] rows at a time.
#[inline(always)]
pub(super) fn sweep_gathered<T: Scalar, S: Sink<T, Single>>(
    source: impl Iterator<Item = Sample<T>>,
    sink: &mut S,
) {
    let mut block = [S::none(Single); GATHERED];
    let mut filled = 0;
    for sample in source {
        let Some(row) = sink.row(Single, sample) else { continue };
        if let Some(place) = block.get_mut(filled) {
            *place = row;
        }
        filled += 1;
        if filled == GATHERED {
            sink.add(Single, &block);
            filled = 0;
        }
    }
    sink.add(Single, block.get(..filled).unwrap_or_default());
}

/// What a pass reads of the batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    All,
    Half,
}

impl Part {
    /// How many places are left out before each of 16 that are read and recur; two bits each, the lowest first.
    ///
    /// Half: as those between numbers with an even number of ones. Every second place could be all of the outliers, and
    /// they none of the rest; of outliers in half of any places that recur it reads about half.
    fn left_out(self) -> u32 {
        match self {
            Self::All => 0,
            Self::Half => 0x1891_9219,
        }
    }

    /// The part of a slice.
    #[inline(always)]
    fn of<T>(self, all: &[T]) -> impl Iterator<Item = &T> {
        let (mut place, mut left_out) = (0_usize, self.left_out());
        iter::from_fn(move || {
            place += usize::try_from(left_out & 3).unwrap_or_default();
            left_out = left_out.rotate_right(2);
            let read = all.get(place);
            place += 1;
            read
        })
    }
}

/// Runs a pass over a part of the batch.
#[inline(always)]
pub(super) fn run<T: Scalar, P: Pass<T>>(pass: &mut P, matches: Matches<'_, T>, part: Part) {
    #[cfg(feature = "simd")]
    if part == Part::All && wide::run(pass, matches) {
        return;
    }
    run_baseline(pass, matches.pairs, part);
}

/// [`run`] without vector lanes: bit-identical to [`Single`] on every target.
#[inline(always)]
pub(super) fn run_baseline<T: Scalar, P: Pass<T>>(pass: &mut P, pairs: &[RayPair<T>], part: Part) {
    let mut pairs = part.of(pairs);
    if !(P::QUADS && Quads::SUPPORTED) {
        return pass.sweep_single(pairs.map(sample));
    }
    let mut rest = [None; 4];
    let quads = iter::from_fn(|| {
        let next: [_; 4] = from_fn(|_| pairs.next());
        let [Some(a), Some(b), Some(c), Some(d)] = next else {
            rest = next;
            return None;
        };
        let four: [&RayPair<T>; 4] = [a, b, c, d];
        Some((Quad::columns(four.map(RayPair::rays)), Quad(four.map(RayPair::grid_step))))
    });
    pass.sweep(Quads, quads);
    pass.sweep_single(rest.into_iter().flatten().map(sample));
}

/// Keeps values that all samples share in memory, as operands of vector instructions; otherwise the compiler broadcasts
/// each anew.
#[inline(always)]
pub(super) fn in_memory<T: Number, L: Lanes<T>, C>(_: L, context: C) -> C {
    if L::BLOCK == 1 { context } else { black_box(context) }
}

/// A correspondence as a sample.
#[inline(always)]
pub(super) fn sample<T: Scalar>(pair: &RayPair<T>) -> Sample<T> {
    (pair.rays(), pair.grid_step())
}

/// Sweeps on the vector lanes of the processor.
#[cfg(feature = "simd")]
pub(super) mod wide {
    use pulp::{Simd, WithSimd};

    use super::{Pass, sample};
    use crate::batch::Matches;
    use crate::scalar::Scalar;
    use crate::simd::dispatch;

    /// Sweeps the whole batch; false without vector lanes.
    pub(in crate::pair) fn run<T: Scalar>(
        pass: &mut impl Pass<T>,
        matches: Matches<'_, T>,
    ) -> bool {
        dispatch(Whole { pass, matches }).is_some()
    }

    /// Sweep over a whole batch, dispatched on the processor's instruction set.
    struct Whole<'a, T: Scalar, P> {
        pass: &'a mut P,
        matches: Matches<'a, T>,
    }

    impl<T: Scalar, P: Pass<T>> WithSimd for Whole<'_, T, P> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let Self { pass, matches: Matches { pairs, columns } } = self;
            let (steps, left_over) = T::split::<S>(columns.grid_step);
            let [x_l, y_l, x_r, y_r] = columns.rays.map(|column| T::split::<S>(column).0.iter());
            let samples = x_l.zip(y_l).zip(x_r).zip(y_r).zip(steps);
            let load = |stored| T::load(simd, stored);
            pass.sweep(
                T::wide(simd),
                samples.map(|((((x_l, y_l), x_r), y_r), step)| {
                    ([x_l, y_l, x_r, y_r].map(load), load(step))
                }),
            );
            let (_, rest) = pairs.split_at(pairs.len().saturating_sub(left_over.len()));
            pass.sweep_single(rest.iter().map(sample));
        }
    }
}

#[cfg(test)]
#[cfg(feature = "simd")]
pub(super) mod simd_tests;
#[cfg(test)]
mod tests;
