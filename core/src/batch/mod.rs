//! Batch of correspondences: undistorts pixels to rays, and selects correspondences up to a fixed capacity.

pub(crate) mod correspondence;
pub(crate) mod grid;
pub(crate) mod row_grid;
pub(crate) mod row_offset;
mod selection;
mod shift;
mod short_float;
pub(crate) mod sides;

use correspondence::Correspondence;
pub use correspondence::RayPair;
use grid::CellSet;
use nalgebra::Vector2;
use row_grid::{RowGrid, Rows};
use row_offset::is_within_rows;
pub use row_offset::row_offset;
use selection::{MAX_MEMBERS, Priority, Selection, ray_bits};

use crate::error::{PushError, UndistortError};
use crate::geometry::cameras::Cameras;
use crate::geometry::lens_correction::RayChange;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{JUDGED, TIE_PX};
use shift::Shift;

/// Result of offering a valid correspondence to a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Pushed {
    /// The batch had room and holds the correspondence.
    Kept,
    /// The batch holds the correspondence in place of another one.
    Replaced,
    /// The batch or the cell is full, and the batch does not hold the correspondence, which has the lowest priority in
    /// the fullest cells or in its cell.
    LeftOut,
}

codes! { Pushed { Kept = 0, Replaced = 1, LeftOut = 2 } }
texts! { Pushed { Kept = "kept", Replaced = "replaced", LeftOut = "left out" } }

/// Up to `N` correspondences as rays, and counts of the correspondences left out or refused. `N` is at most 16384.
///
/// A full batch keeps correspondences spread over the left image. Within a cell of a grid of 8 x 6 it prefers the better
/// score, and chooses pseudo-randomly among equal scores. A cell holds at most 128. The order of arrival has no
/// influence.
///
/// RAM: 372 bytes, plus 23 bytes per correspondence in `f32`.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{Camera, Cameras, Correspondence, Intrinsics, Lens};
/// use stereo_selfcal::batch::{Batch, Pushed};
/// let intrinsics = Intrinsics { focal: [1400.0; 2], principal: [959.5, 599.5], size: [1920, 1200] };
/// let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
/// let cameras = Cameras { left: camera, right: camera };
/// let mut batch = Batch::<f32, 64>::new();
/// let m = Correspondence { left: [800.0, 400.0], right: [750.0, 401.5], score: 0.9, grid_step: 0.0 };
/// assert_eq!(batch.push(&cameras, &m)?, Pushed::Kept);
/// assert!(batch.push(&cameras, &Correspondence { score: 2.0, ..m }).is_err());
/// assert_eq!((batch.matches().len(), batch.refused(), batch.offered()), (1, 1, 2));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Batch<T, const N: usize> {
    /// The length has 16 bits, so that the slice has a valid size even if a fault has overwritten the length.
    matches: heapless::Vec<RayPair<T>, N, u16>,
    selection: Selection<N>,
    left_out: u32,
    refused: u32,
    /// Number of refused correspondences with a pixel at which the lens model is not invertible.
    without_ray: u16,
    /// Number of correspondences refused for a pixel since the last [`Batch::clear`].
    by_pixel: u16,
    /// Vote for the most frequent displacement of matches from the right image to the left image.
    shift: Shift<T>,
    /// Ties among the rows of the images.
    row_grid: RowGrid,
    /// Cells that contained matches in this batch or in earlier ones since the last reset.
    seen: CellSet,
    /// Whether the matches belong to a transmission frame that has not yet ended with a correct CRC.
    arriving: bool,
}

impl<T: Scalar, const N: usize> Batch<T, N> {
    /// Creates an empty batch.
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        const { assert!(N <= MAX_MEMBERS, "the selection's indices have 14 bits") }
        Self {
            matches: heapless::Vec::new(),
            selection: Selection::new(),
            left_out: 0,
            refused: 0,
            without_ray: 0,
            by_pixel: 0,
            shift: Shift::NONE,
            row_grid: RowGrid::NONE,
            seen: CellSet::NONE,
            arriving: false,
        }
    }

    /// Creates a batch from rays without pixels.
    #[cfg(test)]
    pub(crate) fn of(pairs: &[RayPair<T>]) -> Self {
        let mut batch = Self::new();
        for pair in pairs {
            batch.keep(*pair, Priority::default());
        }
        batch
    }

    /// Undistorts and keeps one correspondence. A full batch replaces the correspondence with the lowest priority in
    /// the fullest cells; if this is the new one, it is left out. A full cell of a batch with room replaces its own.
    ///
    /// A correspondence that is left out for its priority is not undistorted, so a missing ray goes unnoticed. Cost:
    /// two undistortions, and a search in the list of the cell if the correspondence is kept.
    ///
    /// # Errors
    /// [`PushError`]: a value is out of range, or a pixel has no ray. The correspondences in the batch stay unchanged;
    /// the refusal is counted.
    #[inline(never)]
    pub fn push(
        &mut self,
        cameras: &Cameras<T>,
        c: &Correspondence<T>,
    ) -> Result<Pushed, PushError> {
        let pushed = self.select(cameras, c);
        let count = match pushed {
            Ok(Pushed::Kept) => return pushed,
            Ok(Pushed::Replaced | Pushed::LeftOut) => &mut self.left_out,
            Err(why) => {
                let without_ray = matches!(why, PushError::Pixel(_, UndistortError::NotInvertible));
                self.without_ray = self.without_ray.saturating_add(u16::from(without_ray));
                // A score or a grid step out of range tells nothing about the cameras.
                let by_pixel = matches!(why, PushError::Pixel(..));
                self.by_pixel = self.by_pixel.saturating_add(u16::from(by_pixel));
                &mut self.refused
            }
        };
        *count = count.saturating_add(1);
        pushed
    }

    /// Keeps a correspondence, replaces another one, or leaves the new one out. Does not count correspondences that are
    /// left out or refused.
    fn select(&mut self, cameras: &Cameras<T>, c: &Correspondence<T>) -> Result<Pushed, PushError> {
        cameras.check(c)?;
        let (cell, priority) = (cameras.cell(c), Priority::of(c));
        self.seen.insert(cell);
        self.shift.add(c);
        self.row_grid.add((c.left[1] - c.right[1]).abs(), T::ZERO);
        let full = self.matches.is_full() || self.selection.is_full(cell);
        let eviction = full.then(|| self.selection.eviction(cell, &self.matches));
        let stays = eviction.map_or(Some(true), |eviction| eviction.is_replaced_by(priority));
        if stays == Some(false) {
            return Ok(Pushed::LeftOut);
        }
        // Undistorts before the eviction, because the pixel may have no ray.
        let pair = cameras.undistort(c, cell)?;
        let Some(eviction) = eviction else {
            self.keep(pair, priority);
            return Ok(Pushed::Kept);
        };
        let Some(old) = self.matches.get_mut(eviction.index()) else {
            return Ok(Pushed::LeftOut);
        };
        if stays.is_none() && ray_bits(&pair) <= ray_bits(old) {
            return Ok(Pushed::LeftOut);
        }
        *old = pair;
        self.selection.replace(eviction, priority, &self.matches);
        Ok(Pushed::Replaced)
    }

    /// Appends a correspondence to a batch with room.
    fn keep(&mut self, pair: RayPair<T>, priority: Priority) {
        if self.matches.push(pair).is_ok() {
            self.selection.add(priority, &self.matches);
        }
    }

    /// Returns the correspondences, in order of arrival until the first is replaced. Empty while a transmission frame
    /// arrives ([`crate::link`]), because an incomplete frame is not a pair.
    pub fn matches(&self) -> &[RayPair<T>] {
        if self.arriving { &[] } else { &self.matches }
    }

    /// Returns the match whose left ray is nearest to `ray`, among the matches within `reach` that have a small row
    /// offset at a pose.
    ///
    /// * `reach`: largest distance of the left rays; `most`: largest row offset; both in pixels over the focal length.
    pub(crate) fn nearest(
        &self,
        ray: &Vector2<T>,
        reach: T,
        pose: &RectifyingRotations<T>,
        most: T,
    ) -> Option<&RayPair<T>> {
        let mut nearest = (reach * reach, None);
        for pair in self.matches() {
            let squared = (pair.left - ray).norm_squared() / (pair.scale() * pair.scale());
            if squared <= nearest.0 && is_within_rows(pair, pose, most) {
                nearest = (squared, Some(pair));
            }
        }
        nearest.1
    }

    /// Returns how the matcher has measured the rows, in the images or after rectification: a matcher behind a rectifier
    /// has its grid in the rectified images. Widens the grid steps of the matches to the larger of both. Reads at most [`JUDGED`]
    /// matches.
    ///
    /// * `in_use`: the calibration of the rectifier; `change`: change of the right rays to its cameras; `focal`: mean
    ///   focal length, px.
    #[inline(never)]
    pub(crate) fn measure_rows(
        &mut self,
        in_use: &RectifyingRotations<T>,
        change: Option<&RayChange<T>>,
        focal: T,
    ) -> Rows<T> {
        let mut rectified = RowGrid::NONE;
        let stride = self.matches().len().div_ceil(JUDGED).max(1);
        for pair in self.matches().iter().step_by(stride) {
            let changed = change.map_or(*pair, |change| pair.changed(change));
            if let Some(offset) = row_offset(in_use, &changed) {
                rectified.add(offset.abs() * focal, T::lit(TIE_PX));
            }
        }
        let [Rows::Measured(given), Rows::Measured(rectified)] =
            [&self.row_grid, &rectified].map(RowGrid::rows::<T>)
        else {
            return Rows::NotMeasured;
        };
        let step = given.max(rectified);
        if step > T::ZERO {
            self.matches.iter_mut().for_each(|pair| pair.widen_grid(step));
        }
        Rows::Measured(step)
    }

    /// Hides the correspondences until [`Batch::end_frame`] or [`Batch::clear`].
    pub(crate) fn begin_frame(&mut self) {
        self.arriving = true;
    }

    /// Shows the correspondences again, because the frame is complete.
    pub(crate) fn end_frame(&mut self) {
        self.arriving = false;
    }

    /// Returns whether the number of correspondences is within the capacity; a memory fault may break this.
    pub(crate) fn is_within(&self) -> bool {
        self.matches.len() <= N
    }

    /// Returns whether a frame has begun to arrive and has neither ended nor been cleared.
    pub(crate) fn is_arriving(&self) -> bool {
        self.arriving
    }

    /// Returns the number of correspondences offered since the last [`Batch::clear`]: kept, left out or refused.
    pub fn offered(&self) -> u32 {
        let held = u32::try_from(self.matches.len()).unwrap_or(u32::MAX);
        held.saturating_add(self.left_out).saturating_add(self.refused)
    }

    /// Forgets the cells that contained matches, because the next matches come from other cameras.
    pub(crate) fn forget_cells(&mut self) {
        self.seen = CellSet::NONE;
    }

    /// Returns the number of refused correspondences with a pixel at which the lens model is not invertible.
    pub(crate) fn without_ray(&self) -> u32 {
        self.without_ray.into()
    }

    /// Returns the number of correspondences refused for a pixel since the last [`Batch::clear`].
    pub(crate) fn refused_by_pixel(&self) -> u32 {
        self.by_pixel.into()
    }

    /// Returns the cells that contained matches in this batch or in earlier ones since the last reset.
    pub(crate) fn seen(&self) -> CellSet {
        self.seen
    }

    /// Returns the sum and the number of the scores of the matches with the most frequent displacement; see
    /// [`Shift::spread`].
    pub(crate) fn spread(&self) -> [T; 2] {
        self.shift.spread()
    }

    /// Returns whether most matches have the same displacement between the images ([`Shift::is_common`]). Matches without
    /// a ray count, too.
    pub(crate) fn is_moved_alike(&self) -> bool {
        self.shift.is_common()
    }

    /// Returns the number of valid correspondences replaced or left out since the last [`Batch::clear`].
    pub fn left_out(&self) -> u32 {
        self.left_out
    }

    /// Returns the number of correspondences refused since the last [`Batch::clear`].
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Removes all correspondences, and resets the counts. The cells that contained matches stay known.
    pub fn clear(&mut self) {
        self.matches.clear();
        self.selection.clear();
        self.left_out = 0;
        self.refused = 0;
        self.without_ray = 0;
        self.by_pixel = 0;
        self.shift = Shift::NONE;
        self.row_grid = RowGrid::NONE;
        self.arriving = false;
    }
}

impl<T: Scalar, const N: usize> Default for Batch<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests;
