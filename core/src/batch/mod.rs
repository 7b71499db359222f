//! Batch of correspondences: undistorted to rays, selected to a fixed capacity.

pub(crate) mod correspondence;
pub(crate) mod grid;
pub(crate) mod row_offset;
mod selection;
mod shift;
pub(crate) mod sides;

pub use correspondence::RayPair;
use correspondence::{Cameras, Correspondence};
use grid::CellSet;
use nalgebra::Vector2;
use row_offset::is_within_rows;
pub use row_offset::row_offset;
use selection::{MAX_MEMBERS, Priority, Selection, ray_bits};

use crate::error::{PushError, Rejection, UndistortError};
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::cause::Cause;
use crate::scalar::Scalar;
use shift::Shift;

/// Result of offering a valid correspondence to a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Pushed {
    /// The batch had room and holds it.
    Kept,
    /// The batch holds it in place of another one.
    Replaced,
    /// The batch is full and its priority too low: it is left out.
    LeftOut,
}

codes! { Pushed { Kept = 0, Replaced = 1, LeftOut = 2 } }
texts! { Pushed { Kept = "kept", Replaced = "replaced", LeftOut = "left out" } }

/// Up to `N` correspondences as rays, and counts of the others. `N` is at most 16384.
///
/// A full batch keeps correspondences spread over the left image: in one cell it prefers the better score, and chooses
/// at random among equal scores. The order of arrival has no influence.
///
/// RAM: 23 bytes a correspondence in `f32`, and 356.
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
/// assert_eq!((batch.pairs().len(), batch.refused(), batch.offered()), (1, 1, 2));
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Batch<T, const N: usize> {
    /// A short length: if memory is overwritten from outside, a wrong length is still a slice.
    pairs: heapless::Vec<RayPair<T>, N, u16>,
    selection: Selection<N>,
    left_out: u32,
    refused: u32,
    /// Refused correspondences without a ray.
    without_ray: u32,
    /// Most frequent motion of matches from the right image to the left one.
    shift: Shift<T>,
    /// Cells that matches of any batch have visited.
    seen: CellSet,
    /// Whether the matches belong to a frame that has not ended with a correct CRC yet.
    arriving: bool,
}

impl<T: Scalar, const N: usize> Batch<T, N> {
    /// An empty batch.
    #[must_use]
    #[inline(always)]
    pub const fn new() -> Self {
        const { assert!(N <= MAX_MEMBERS, "the selection's indices have 14 bits") }
        Self {
            pairs: heapless::Vec::new(),
            selection: Selection::new(),
            left_out: 0,
            refused: 0,
            without_ray: 0,
            shift: Shift::NONE,
            seen: CellSet::NONE,
            arriving: false,
        }
    }

    /// A batch of rays without pixels.
    #[cfg(test)]
    pub(crate) fn of(pairs: &[RayPair<T>]) -> Self {
        let mut batch = Self::new();
        for pair in pairs {
            batch.keep(*pair, Priority::default());
        }
        batch
    }

    /// Undistorts and keeps one correspondence; a full batch replaces one of lower priority or
    /// leaves the new one out.
    ///
    /// A correspondence left out for its priority is not undistorted, so a missing ray goes unnoticed. Cost: two
    /// undistortions, and for a kept one a search of the cell's list for its place.
    ///
    /// # Errors
    /// [`PushError`]: out of range or without a ray. Only the count of refusals changes.
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
                self.without_ray = self.without_ray.saturating_add(u32::from(without_ray));
                &mut self.refused
            }
        };
        *count = count.saturating_add(1);
        pushed
    }

    /// Keeps, replaces or leaves out; counts nothing.
    fn select(&mut self, cameras: &Cameras<T>, c: &Correspondence<T>) -> Result<Pushed, PushError> {
        cameras.check(c)?;
        let (cell, priority) = (cameras.cell(c), Priority::of(c));
        self.seen.insert(cell);
        self.shift.add(c);
        let full = self.pairs.is_full();
        let eviction = full.then(|| self.selection.eviction(cell, &self.pairs));
        let stays = eviction.map_or(Some(true), |eviction| eviction.is_replaced_by(priority));
        if stays == Some(false) {
            return Ok(Pushed::LeftOut);
        }
        // Before the eviction: the pixel may have no ray.
        let pair = cameras.undistort(c, cell)?;
        let Some(eviction) = eviction else {
            self.keep(pair, priority);
            return Ok(Pushed::Kept);
        };
        let Some(old) = self.pairs.get_mut(eviction.index()) else {
            return Ok(Pushed::LeftOut);
        };
        if stays.is_none() && ray_bits(&pair) <= ray_bits(old) {
            return Ok(Pushed::LeftOut);
        }
        *old = pair;
        self.selection.replace(eviction, priority, &self.pairs);
        Ok(Pushed::Replaced)
    }

    /// Appends to a batch with room.
    fn keep(&mut self, pair: RayPair<T>, priority: Priority) {
        if self.pairs.push(pair).is_ok() {
            self.selection.add(priority, &self.pairs);
        }
    }

    /// The correspondences, in order of arrival until the first is replaced. Empty while a frame arrives
    /// ([`crate::link`]): half a frame is not a pair.
    pub fn pairs(&self) -> &[RayPair<T>] {
        if self.arriving { &[] } else { &self.pairs }
    }

    /// The match nearest to a left ray, among those within reach of it and within a row offset at a pose.
    ///
    /// * `reach`, `most`: largest distance of the left rays and largest row offset, at unit depth.
    pub(crate) fn nearest(
        &self,
        ray: &Vector2<T>,
        reach: T,
        pose: &RectifyingRotations<T>,
        most: T,
    ) -> Option<&RayPair<T>> {
        let mut nearest = (reach * reach, None);
        for pair in self.pairs() {
            let squared = (pair.left - ray).norm_squared();
            if squared <= nearest.0 && is_within_rows(pair, pose, most) {
                nearest = (squared, Some(pair));
            }
        }
        nearest.1
    }

    /// Hides the correspondences from now on, until [`Batch::end_frame`] or [`Batch::clear`].
    pub(crate) fn begin_frame(&mut self) {
        self.arriving = true;
    }

    /// Shows the correspondences of a whole frame.
    pub(crate) fn end_frame(&mut self) {
        self.arriving = false;
    }

    /// Whether the length is within the capacity.
    pub(crate) fn is_within(&self) -> bool {
        self.pairs.len() <= N
    }

    /// Whether a frame arrives that was not cleared since its start.
    pub(crate) fn is_arriving(&self) -> bool {
        self.arriving
    }

    /// Correspondences offered since the last [`Batch::clear`]: kept, left out or refused.
    pub fn offered(&self) -> u32 {
        let held = u32::try_from(self.pairs.len()).unwrap_or(u32::MAX);
        held.saturating_add(self.left_out).saturating_add(self.refused)
    }

    /// Forgets the cells that matches have visited, because the next ones come from other cameras.
    pub(crate) fn forget_cells(&mut self) {
        self.seen = CellSet::NONE;
    }

    /// The mistake that the pixels show: most matches were refused since the last [`Batch::clear`]; or no match of any
    /// batch was right of the middle of the left image, nor below it.
    pub(crate) fn cause(&self) -> Option<Cause> {
        if self.refused > self.offered() / 2 {
            let most_without_ray = self.without_ray > self.refused / 2;
            Some(if most_without_ray { Cause::FocalLength } else { Cause::SmallerImages })
        } else {
            self.seen.is_of_a_corner().then_some(Cause::LargerImages)
        }
    }

    /// The mistake that an unsolved pair shows.
    pub(crate) fn cause_of(&self, why: Rejection, size: [u16; 2]) -> Option<Cause> {
        let transposed = self.refused > 0 && self.seen.is_of_the_square(size);
        self.cause().or_else(|| Cause::of_unsolved(why, transposed, self.is_moved_alike()))
    }

    /// Scatter of the matches with a common motion: [`Shift::spread`].
    pub(crate) fn spread(&self) -> [T; 2] {
        self.shift.spread()
    }

    /// Whether most matches have a common motion between both images.
    pub(crate) fn is_moved_alike(&self) -> bool {
        let taken = self.offered().saturating_sub(self.refused);
        self.shift.excess > taken / 4
    }

    /// Valid correspondences replaced or left out since the last [`Batch::clear`].
    pub fn left_out(&self) -> u32 {
        self.left_out
    }

    /// Correspondences refused since the last [`Batch::clear`].
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Removes all correspondences and resets the counts.
    pub fn clear(&mut self) {
        self.pairs.clear();
        self.selection.clear();
        self.left_out = 0;
        self.refused = 0;
        self.without_ray = 0;
        self.shift = Shift::NONE;
        self.arriving = false;
    }
}

impl<T: Scalar, const N: usize> Default for Batch<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::correspondence::tests::cameras;
    use super::*;
    use core::cmp::Reverse;
    use proptest::prelude::*;
    use std::vec::Vec;

    prop_compose! {
        /// On whole pixels, half of them in one cell and its neighbours; four different scores.
        fn matches()(u in 0..640_u16, v in 0..480_u16, crowded: bool, d in 1..60_u8, score in 0..4_u8)
            -> Correspondence<f32>
        {
            let [u, v] = if crowded { [100 + u / 8, 200 + v / 8] } else { [u, v] }.map(f32::from);
            let [d, score] = [d, score].map(f32::from);
            Correspondence { left: [u, v], right: [u.max(d) - d, v], score: score / 4.0, grid_step: 1.0 }
        }
    }

    /// Priority, and the rays that decide among equal ones.
    type Order = (Priority, [u64; 4]);

    fn order(c: &Correspondence<f32>) -> Order {
        (Priority::of(c), ray_bits(&cameras().rays(c).unwrap()))
    }

    /// The definition: the first `n` of all matches by rank in their cell, then by priority.
    fn first_by_rank_and_priority(offered: &[Correspondence<f32>], n: usize) -> Vec<[u64; 4]> {
        let all: Vec<_> = offered.iter().map(|c| (cameras().cell(c), order(c))).collect();
        let rank = |cell, p| all.iter().filter(|(c, other)| *c == cell && *other > p).count();
        let mut order: Vec<_> = all.iter().map(|&(c, p)| (rank(c, p), Reverse(p))).collect();
        order.sort_unstable();
        let mut kept: Vec<_> = order.iter().take(n).map(|(_, Reverse((_, rays)))| *rays).collect();
        kept.sort_unstable();
        kept
    }

    fn selected<const N: usize>(offered: &[Correspondence<f32>]) -> Vec<[u64; 4]> {
        let mut batch = Batch::<f32, N>::new();
        for c in offered {
            batch.push(&cameras(), c).unwrap();
        }
        let mut kept: Vec<_> = batch.pairs().iter().map(ray_bits).collect();
        kept.sort_unstable();
        kept
    }

    proptest! {
        #[test]
        fn the_first_by_rank_and_priority_stay_for_any_order_of_arrival(
            mut offered in prop::collection::vec(matches(), 0..400),
            seed in prop::collection::vec(any::<prop::sample::Index>(), 400),
        ) {
            // Equal matches have equal priority, which leaves their ranks undefined.
            offered.sort_by(|a, b| (a.left, a.right).partial_cmp(&(b.left, b.right)).unwrap());
            offered.dedup_by(|a, b| (a.left, a.right) == (b.left, b.right));
            for i in (1..offered.len()).rev() {
                offered.swap(i, seed[i].index(i + 1));
            }
            // Less than one, about one, and several matches a cell.
            prop_assert_eq!(selected::<20>(&offered), first_by_rank_and_priority(&offered, 20));
            prop_assert_eq!(selected::<60>(&offered), first_by_rank_and_priority(&offered, 60));
            prop_assert_eq!(selected::<200>(&offered), first_by_rank_and_priority(&offered, 200));
        }
    }
}
