//! Which correspondences stay when a matcher delivers more than the batch has room for.
//!
//! The left image is divided into 8 x 6 cells. A newcomer to a full batch is counted in; then the
//! worst match of the fullest cells leaves, which may be the newcomer. What stays are those that come
//! first by their rank in their cell, then by worth, whatever order they came in. Worth: the score;
//! among equal scores a hash of the rays, a lot that is fair and needs neither state nor memory.
//!
//! Disparity has no say, although near points tell most of `t`: mismatches have the largest ones.
//! Nearest first, at 30 % mismatches, a batch of 128 held 61 of them in place of 39.

use crate::correspondence::RayPair;
use crate::scalar::Scalar;

const COLUMNS: u16 = 8;
const ROWS: u16 = 6;
const CELLS: usize = 48;

/// Odd, its bits without a pattern: the fraction of the golden ratio.
const MULTIPLIER: u64 = 0x9e37_79b9_7f4a_7c15;

/// A cell of the grid over the left image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cell(u8);

impl Cell {
    /// Of a pixel of an image of `size`, px; the outer cells reach beyond the border.
    pub(crate) fn of<T: Scalar>(pixel: [T; 2], size: [u16; 2]) -> Self {
        // The image begins half a pixel before the centre of its first.
        let along = |x: T, length: u16, cells: u16| {
            let cell = (x + T::HALF) * T::count(cells.into()) / T::count(length.into());
            cell.to_u16().min(cells - 1)
        };
        let ([u, v], [width, height]) = (pixel, size);
        Self::from_bits(along(v, height, ROWS) * COLUMNS + along(u, width, COLUMNS))
    }

    /// The index, below 64.
    pub(crate) fn bits(self) -> u16 {
        self.0.into()
    }

    pub(crate) fn from_bits(index: u16) -> Self {
        let [index, _] = index.to_le_bytes();
        Self(index)
    }
}

/// What matches of one rank are ordered by; larger is better.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Worth {
    score: u16,
    lot: u64,
}

impl Worth {
    pub(crate) fn of<T: Scalar>(pair: &RayPair<T>) -> Self {
        let lot = [pair.left, pair.right].iter().fold(0_u64, |hash, ray| {
            // In `f32` two words side by side.
            let words = ray.x.bits() ^ ray.y.bits().rotate_left(32);
            let hash = (hash ^ words).wrapping_mul(MULTIPLIER);
            hash ^ (hash >> 29)
        });
        Self { score: pair.score_steps(), lot: lot.wrapping_mul(MULTIPLIER) }
    }

    /// The most that a match of this score, in steps, can be worth.
    pub(crate) fn at_most(score: u16) -> Self {
        Self { score, lot: u64::MAX }
    }
}

/// Matches in each cell.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Occupancy([u16; CELLS]);

impl Occupancy {
    fn of(cells: impl Iterator<Item = Cell>) -> Self {
        let mut occupancy = Self([0; CELLS]);
        for cell in cells {
            if let Some(count) = occupancy.0.get_mut(usize::from(cell.0)) {
                *count = count.saturating_add(1);
            }
        }
        occupancy
    }

    fn get(&self, cell: Cell) -> Option<&u16> {
        self.0.get(usize::from(cell.0))
    }
}

/// Cells that something has been seen in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coverage(u64);

impl Coverage {
    pub(crate) const NONE: Self = Self(0);

    pub(crate) fn note(&mut self, cell: Cell) {
        self.0 |= 1_u64.checked_shl(cell.0.into()).unwrap_or(0);
    }

    /// Of all cells.
    pub(crate) fn share<T: Scalar>(self) -> T {
        T::count(self.0.count_ones()) / T::count((COLUMNS * ROWS).into())
    }
}

/// Who may leave a full batch.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contest {
    /// The worst of the batch in the fullest cells, and its place.
    worst: Option<(Worth, usize)>,
    newcomer_may_leave: bool,
}

impl Contest {
    /// What a newcomer to a full batch is up against. Two scans of the batch.
    pub(crate) fn of<T: Scalar>(newcomer: Cell, pairs: &[RayPair<T>]) -> Self {
        let cells = pairs.iter().map(RayPair::cell);
        let counted_in = Occupancy::of(cells.chain([newcomer]));
        let fullest = counted_in.0.iter().max();
        let is_fullest = |cell: Cell| counted_in.get(cell) == fullest;
        let worst = (0..)
            .zip(pairs)
            .filter(|(_, pair)| is_fullest(pair.cell()))
            .map(|(place, pair)| (Worth::of(pair), place))
            .min();
        Self { worst, newcomer_may_leave: is_fullest(newcomer) }
    }

    /// The place that a newcomer of this worth takes; `None` if it is the one that leaves.
    pub(crate) fn place(&self, newcomer: Worth) -> Option<usize> {
        let (worst, place) = self.worst?;
        (!self.newcomer_may_leave || newcomer > worst).then_some(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_equal_parts_of_the_image_and_reach_beyond_its_border() {
        let cell = |u: f32, v: f32| Cell::of([u, v], [640, 480]).0;
        assert_eq!([cell(-0.9, -0.9), cell(79.4, 79.4), cell(79.6, 79.4)], [0, 0, 1]);
        assert_eq!([cell(0.0, 79.6), cell(639.0, 0.0), cell(640.0, 480.0)], [8, 7, 47]);
        let mut counts = [0; CELLS];
        for v in 0..480_u16 {
            for u in 0..640_u16 {
                counts[usize::from(cell(u.into(), v.into()))] += 1;
            }
        }
        assert_eq!(counts, [80 * 80; CELLS]);
    }
}
