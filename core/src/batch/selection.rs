//! Selection of correspondences when a matcher delivers more than the batch holds.
//!
//! A correspondence that is offered to a full batch first counts in its cell. Then the correspondence with the lowest
//! priority in the fullest cells is evicted, which may be the new one. For any order of arrival, the batch keeps the
//! first correspondences by rank in their cell, then by priority. Priority is given by the score; for equal scores by a
//! hash of the pixels, which is unbiased; and for equal hashes by the rays.
//!
//! The members of each cell form a list in order of priority, so the whole batch is never scanned. A cell has at most
//! [`MAX_IN_CELL`] members, also in a batch with room, so the cost of a push does not grow with the capacity.
//!
//! Disparity has no influence. Near points determine most of `t`, but outliers have the largest disparities. With a
//! preference for large disparities, a batch of 128 held 61 outliers instead of 39 when 30 % of the offered matches
//! were outliers.

use super::correspondence::{Correspondence, RayPair};
use super::grid::{CELLS, Cell, CellSet};
use crate::scalar::Scalar;
use crate::thresholds::MAX_IN_CELL;

/// Multiplier of the hash: the fractional part of the golden ratio times 2^32, which is odd and has no pattern in its
/// bits.
const MULTIPLIER: u32 = 0x9e37_79b9;

/// Number of bits of an index; the other 18 bits of a [`Member`] hold the priority.
const INDEX_BITS: u32 = 14;
const MAX_INDEX: u16 = (1 << INDEX_BITS) - 1;
/// Largest number of members.
pub(super) const MAX_MEMBERS: usize = 1 << INDEX_BITS;

/// Priority within a cell, without the rays: 10 bits of the score, then 8 bits of a hash. The larger value stays.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default)]
pub(super) struct Priority(u32);

impl Priority {
    /// Returns the priority of a correspondence. Equal pixels have equal hashes.
    pub(super) fn of<T: Scalar>(c: &Correspondence<T>) -> Self {
        let add = |hash: u32, x: T| {
            let [a, b, c, d, e, f, g, h] = x.bits().to_le_bytes();
            let word = u32::from_le_bytes([a, b, c, d]) ^ u32::from_le_bytes([e, f, g, h]);
            let hash = (hash ^ word).wrapping_mul(MULTIPLIER);
            hash ^ (hash >> 15)
        };
        // Written out, because at opt-level "s" the compiler does not unroll a loop.
        let ([u_l, v_l], [u_r, v_r]) = (c.left, c.right);
        let hash = add(add(add(add(0, u_l), v_l), u_r), v_r);
        let [.., hash] = hash.wrapping_mul(MULTIPLIER).to_le_bytes();
        Self::new(c.score_steps(), hash)
    }

    fn new(score: u16, hash: u8) -> Self {
        Self(u32::from(score) << 8 | u32::from(hash))
    }

    fn hash(self) -> u8 {
        let [hash, ..] = self.0.to_le_bytes();
        hash
    }
}

/// Priority of a member in the high bits, and its index in the batch in the low bits.
#[derive(Debug, Clone, Copy)]
struct Member(u32);

impl Member {
    const NONE: Self = Self(0);

    fn new(priority: Priority, index: u16) -> Self {
        Self(priority.0 << INDEX_BITS | u32::from(index))
    }

    fn priority(self) -> Priority {
        Priority(self.0 >> INDEX_BITS)
    }

    fn index(self) -> u16 {
        let [low, high, ..] = self.0.to_le_bytes();
        u16::from_le_bytes([low, high]) & MAX_INDEX
    }

    #[inline(always)]
    fn is_lower_than<T: Scalar>(self, other: Self, pairs: &[RayPair<T>]) -> bool {
        let (a, b) = (self.priority(), other.priority());
        a < b || a == b && has_lower_rays(self.index(), other.index(), pairs)
    }
}

/// Members of a batch by cell, each cell in order of priority.
#[derive(Debug, Clone)]
pub(super) struct Selection<const N: usize> {
    /// Hash of the pixels of each member.
    hashes: [u8; N],
    /// For each member, the member of the same cell with the next higher priority.
    next: [u16; N],
    /// Member with the lowest priority in each cell.
    lowest: [Member; CELLS],
    /// Number of members of each cell, that is, the length of its list.
    counts: [u16; CELLS],
    /// Largest of the counts; `fullest` holds the cells with that count.
    most: u16,
    fullest: CellSet,
    /// The cell whose lowest member has the lowest priority among the fullest cells; `None` while not known.
    fullest_with_lowest: Option<Cell>,
}

/// Candidate for eviction from a full batch: the member with the lowest priority in the fullest cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Eviction {
    cell: Cell,
    member: Member,
    /// Whether the cell of the new correspondence is among the fullest cells, if the new one is counted in it.
    new_is_candidate: bool,
}

impl Eviction {
    pub(super) fn index(self) -> usize {
        self.member.index().into()
    }

    /// Returns whether the new correspondence stays; `None` if the rays must decide.
    pub(super) fn is_replaced_by(self, new: Priority) -> Option<bool> {
        let old = self.member.priority();
        let equal = self.new_is_candidate && new == old;
        (!equal).then_some(!self.new_is_candidate || new > old)
    }
}

impl<const N: usize> Selection<N> {
    /// Creates an empty selection.
    #[inline(always)]
    pub(super) const fn new() -> Self {
        Self {
            hashes: [0; N],
            next: [0; N],
            lowest: [Member::NONE; CELLS],
            counts: [0; CELLS],
            most: 0,
            fullest: CellSet::NONE,
            fullest_with_lowest: None,
        }
    }

    /// Removes all members.
    pub(super) fn clear(&mut self) {
        self.counts = [0; CELLS];
        (self.most, self.fullest, self.fullest_with_lowest) = (0, CellSet::NONE, None);
    }

    /// Returns whether a cell has [`MAX_IN_CELL`] members.
    pub(super) fn is_full(&self, cell: Cell) -> bool {
        self.count(cell) >= MAX_IN_CELL
    }

    /// Returns the member that a new correspondence may replace ([`Eviction::is_replaced_by`]): the member with the
    /// lowest priority in the fullest cells. The new correspondence is counted in its cell. A full cell is among the
    /// fullest.
    ///
    /// * `new`: cell of the new correspondence.
    /// * `pairs`: correspondences of the batch, which is full, or whose cell `new` is.
    pub(super) fn eviction<T: Scalar>(&mut self, new: Cell, pairs: &[RayPair<T>]) -> Eviction {
        let (count, member) = (self.count(new), self.lowest(new));
        let new_is_candidate = count.saturating_add(1) >= self.most;
        let of_new = Eviction { cell: new, member, new_is_candidate };
        if count >= self.most {
            return of_new;
        }
        let cell = self.fullest_with_lowest(pairs);
        let of_fullest = Eviction { cell, member: self.lowest(cell), new_is_candidate };
        let is_lower = || member.is_lower_than(of_fullest.member, pairs);
        if new_is_candidate && count > 0 && is_lower() { of_new } else { of_fullest }
    }

    /// Adds the last of `pairs`.
    pub(super) fn add<T: Scalar>(&mut self, priority: Priority, pairs: &[RayPair<T>]) {
        let index = pairs.len().checked_sub(1).and_then(|index| u16::try_from(index).ok());
        if let (Some(pair), Some(index)) = (pairs.last(), index) {
            self.link(pair.cell(), index, priority, pairs);
            self.raise(pair.cell());
        }
    }

    /// Removes a member, and adds the correspondence that is now at its index.
    #[inline(always)]
    pub(super) fn replace<T: Scalar>(
        &mut self,
        old: Eviction,
        new: Priority,
        pairs: &[RayPair<T>],
    ) {
        let Some(cell) = pairs.get(old.index()).map(RayPair::cell) else {
            return;
        };
        self.unlink_lowest(old.cell, pairs);
        self.link(cell, old.member.index(), new, pairs);
        if cell != old.cell {
            self.raise(cell);
            self.lower(old.cell);
        }
        // The lowest member of the old cell has been removed, so another cell may now have the lowest member.
        if self.fullest_with_lowest == Some(old.cell) {
            self.fullest_with_lowest = None;
        }
    }

    /// Returns the cell whose lowest member has the lowest priority among the fullest cells.
    fn fullest_with_lowest<T: Scalar>(&mut self, pairs: &[RayPair<T>]) -> Cell {
        if let Some(cell) = self.fullest_with_lowest {
            return cell;
        }
        let (mut found, mut lowest) = (Cell::FIRST, None);
        self.fullest.for_each(|cell| {
            let member = self.lowest(cell);
            if lowest.is_none_or(|lowest| member.is_lower_than(lowest, pairs)) {
                (found, lowest) = (cell, Some(member));
            }
        });
        self.fullest_with_lowest = Some(found);
        found
    }

    fn lowest(&self, cell: Cell) -> Member {
        self.lowest.get(cell.index()).copied().unwrap_or(Member::NONE)
    }

    fn count(&self, cell: Cell) -> u16 {
        self.counts.get(cell.index()).copied().unwrap_or(0)
    }

    /// Returns the member of the same cell with the next higher priority.
    fn next(&self, index: u16) -> u16 {
        self.next.get(usize::from(index)).copied().unwrap_or(0)
    }

    #[inline(always)]
    fn priority<T: Scalar>(&self, index: u16, pairs: &[RayPair<T>]) -> Priority {
        let index = usize::from(index);
        let score = pairs.get(index).map_or(0, RayPair::score_steps);
        Priority::new(score, self.hashes.get(index).copied().unwrap_or(0))
    }

    /// Inserts a member into the list of its cell, and counts it.
    #[inline(always)]
    fn link<T: Scalar>(&mut self, cell: Cell, index: u16, new: Priority, pairs: &[RayPair<T>]) {
        if let Some(hash) = self.hashes.get_mut(usize::from(index)) {
            *hash = new.hash();
        }
        let (mut before, mut after) = (None, self.lowest(cell).index());
        for _ in 0..self.count(cell) {
            let priority = self.priority(after, pairs);
            if new < priority || new == priority && has_lower_rays(index, after, pairs) {
                break;
            }
            (before, after) = (Some(after), self.next(after));
        }
        if let Some(next) = self.next.get_mut(usize::from(index)) {
            *next = after;
        }
        if let Some(before) = before {
            if let Some(next) = self.next.get_mut(usize::from(before)) {
                *next = index;
            }
        } else if let Some(lowest) = self.lowest.get_mut(cell.index()) {
            *lowest = Member::new(new, index);
        }
        if let Some(count) = self.counts.get_mut(cell.index()) {
            *count = count.saturating_add(1);
        }
    }

    fn unlink_lowest<T: Scalar>(&mut self, cell: Cell, pairs: &[RayPair<T>]) {
        let next = self.next(self.lowest(cell).index());
        let member = Member::new(self.priority(next, pairs), next);
        let places = (self.lowest.get_mut(cell.index()), self.counts.get_mut(cell.index()));
        if let (Some(lowest), Some(count)) = places {
            (*lowest, *count) = (member, count.saturating_sub(1));
        }
    }

    /// Updates the fullest cells after a cell has gained a member.
    fn raise(&mut self, cell: Cell) {
        let count = self.count(cell);
        if count > self.most {
            (self.most, self.fullest) = (count, CellSet::NONE);
        }
        if count == self.most {
            self.fullest.insert(cell);
            self.fullest_with_lowest = None;
        }
    }

    /// Updates the fullest cells after one of them has lost a member.
    fn lower(&mut self, cell: Cell) {
        self.fullest.remove(cell);
        if self.fullest.is_empty() {
            self.most = self.most.saturating_sub(1);
            self.find_fullest();
        }
    }

    /// Collects the cells with the largest count. Rarely called, because the largest count only falls in a full batch.
    #[cold]
    fn find_fullest(&mut self) {
        for (count, cell) in self.counts.iter().zip(Cell::all()) {
            if *count == self.most {
                self.fullest.insert(cell);
            }
        }
        self.fullest_with_lowest = None;
    }
}

/// Returns whether member `a` ranks below member `b` by rays. Decides between equal priorities.
#[cold]
fn has_lower_rays<T: Scalar>(a: u16, b: u16, pairs: &[RayPair<T>]) -> bool {
    let [a, b] = [a, b].map(|index| pairs.get(usize::from(index)));
    a.map(ray_bits) < b.map(ray_bits)
}

/// Returns the bits of the rays, which order correspondences of equal priority.
pub(super) fn ray_bits<T: Scalar>(pair: &RayPair<T>) -> [u64; 4] {
    pair.rays().map(T::bits)
}
