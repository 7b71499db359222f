//! Correspondences as columns of numbers (structure of arrays), from which vector lanes load.

use crate::batch::correspondence::RayPair;
use crate::scalar::Scalar;

/// One column for each number of a correspondence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Columns<C> {
    /// `x_l`, `y_l`, `x_r`, `y_r` at unit depth, dimensionless.
    pub(crate) rays: [C; 4],
    /// Step of the matcher's grid, px.
    pub(crate) grid_step: C,
}

impl<T: Scalar, const N: usize> Columns<[T; N]> {
    pub(crate) const ZERO: Self = Self { rays: [[T::ZERO; N]; 4], grid_step: [T::ZERO; N] };

    /// Writes a correspondence at index `place`; does nothing beyond the capacity.
    pub(crate) fn set(&mut self, place: usize, pair: &RayPair<T>) {
        let cells = self.rays.iter_mut().chain([&mut self.grid_step]);
        for (column, value) in cells.zip(pair.rays().into_iter().chain([pair.grid_step()])) {
            if let Some(cell) = column.get_mut(place) {
                *cell = value;
            }
        }
    }

    /// The first `n` correspondences.
    pub(crate) fn first(&self, n: usize) -> Columns<&[T]> {
        Columns {
            rays: self.rays.each_ref().map(|column| column.get(..n).unwrap_or_default()),
            grid_step: self.grid_step.get(..n).unwrap_or_default(),
        }
    }
}
