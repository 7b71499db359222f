//! Grid of 8 x 6 cells over the left image. It spreads a selection over the image, and measures the coverage of an
//! estimate.

use crate::scalar::Scalar;

const COLUMNS: u16 = 8;
const ROWS: u16 = 6;
/// Number of cells of the grid.
pub(super) const CELLS: usize = 48;

/// A cell of the grid: row times 8 plus column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Cell(u8);

impl Cell {
    /// Upper left cell.
    pub(super) const FIRST: Self = Self(0);

    /// Returns the cell of a pixel.
    ///
    /// * `pixel`: `[u, v]`, px; a pixel outside the image belongs to the nearest cell at the border.
    /// * `size`: `[width, height]`, px.
    pub(crate) fn of<T: Scalar>(pixel: [T; 2], size: [u16; 2]) -> Self {
        // The image starts half a pixel before the centre of its first pixel.
        let along = |x: T, length: u16, cells: u16| {
            let cell = (x + T::HALF) * T::count(cells.into()) / T::count(length.into());
            cell.to_u16().min(cells - 1)
        };
        let ([u, v], [width, height]) = (pixel, size);
        Self::from_bits(along(v, height, ROWS) * COLUMNS + along(u, width, COLUMNS))
    }

    /// Returns the index of the cell, which fits in 6 bits.
    pub(crate) fn bits(self) -> u16 {
        self.0.into()
    }

    /// Returns the cell of an index; inverse of [`Self::bits`].
    pub(crate) fn from_bits(index: u16) -> Self {
        let [index, _] = index.to_le_bytes();
        Self(index)
    }

    /// Returns the index of the cell in an array of [`CELLS`] elements.
    pub(super) fn index(self) -> usize {
        self.0.into()
    }

    /// Returns all cells in order of index.
    pub(super) fn all() -> impl Iterator<Item = Self> {
        (0..COLUMNS * ROWS).map(Self::from_bits)
    }

    fn word(self) -> usize {
        usize::from(self.0 >> 5)
    }

    fn bit(self) -> u32 {
        1 << (self.0 & 31)
    }
}

/// Set of cells, with one bit per cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CellSet([u32; 2]);

impl CellSet {
    /// The empty set.
    pub(crate) const NONE: Self = Self([0; 2]);

    /// Adds a cell.
    pub(crate) fn insert(&mut self, cell: Cell) {
        if let Some(word) = self.0.get_mut(cell.word()) {
            *word |= cell.bit();
        }
    }

    /// Removes a cell.
    pub(super) fn remove(&mut self, cell: Cell) {
        if let Some(word) = self.0.get_mut(cell.word()) {
            *word &= !cell.bit();
        }
    }

    pub(super) fn is_empty(self) -> bool {
        self.0 == [0; 2]
    }

    /// Returns whether all cells of the set are in the upper left quarter of the image and more than half of the cells
    /// of this quarter are in the set. This is what matches of half the image size fill.
    pub(crate) fn fills_a_corner(self) -> bool {
        let [columns, rows] = [COLUMNS / 2, ROWS / 2];
        self.is_within([columns, rows]) && self.len() * 2 > u32::from(columns * rows)
    }

    /// Returns whether all cells of the set are within, or at the border of, the upper left square whose side is the
    /// shorter side of the image. False if the grid has no cell beyond these cells, as for a square image.
    ///
    /// * `size`: `[width, height]`, px.
    pub(crate) fn is_of_the_square(self, size: [u16; 2]) -> bool {
        let [width, height] = size.map(u32::from);
        let cells = |all: u16, part: u32, whole: u32| {
            let cut = u32::from(all) * part / whole.max(1) + 1;
            u16::try_from(cut).map_or(all, |cut| cut.min(all))
        };
        let [columns, rows] = [cells(COLUMNS, height, width), cells(ROWS, width, height)];
        (columns < COLUMNS || rows < ROWS) && self.is_within([columns, rows])
    }

    /// Returns whether all cells of the set are within the first `columns` columns and the first `rows` rows. False for
    /// the empty set.
    fn is_within(self, [columns, rows]: [u16; 2]) -> bool {
        let mut within = !self.is_empty();
        self.for_each(|cell| {
            let (column, row) = (cell.bits() % COLUMNS, cell.bits() / COLUMNS);
            within &= column < columns && row < rows;
        });
        within
    }

    /// Returns the share of all cells of the grid that are in the set, 0 to 1.
    pub(crate) fn share<T: Scalar>(self) -> T {
        T::count(self.len()) / T::count((COLUMNS * ROWS).into())
    }

    /// Returns the number of cells in the set.
    fn len(self) -> u32 {
        self.0.into_iter().map(u32::count_ones).sum()
    }

    /// Calls `f` with each cell of the set, in order of index.
    #[inline(always)]
    pub(super) fn for_each(self, mut f: impl FnMut(Cell)) {
        for (mut word, first) in self.0.into_iter().zip([0, 32]) {
            while word != 0 {
                let [index, ..] = word.trailing_zeros().to_le_bytes();
                word &= word.wrapping_sub(1);
                f(Cell(index | first));
            }
        }
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
