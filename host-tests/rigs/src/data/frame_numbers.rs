//! The frame numbers read so far from a file, stored as ranges: a run of consecutive numbers takes the memory of one
//! range.

use std::collections::BTreeMap;

/// A set of numbers.
#[derive(Debug, Clone, Default)]
pub(super) struct FrameNumbers {
    /// Last number of each range, by its first number.
    ranges: BTreeMap<u64, u64>,
}

impl FrameNumbers {
    pub(super) fn is_empty(&self) -> bool {
        self.ranges.is_empty()
    }

    /// Adds a number; returns `false` if it was present.
    pub(super) fn insert(&mut self, number: u64) -> bool {
        let below = self.ranges.range(..=number).next_back().map(|(first, last)| (*first, *last));
        if below.is_some_and(|(_, last)| number <= last) {
            return false;
        }
        let joins = below.filter(|(_, last)| last.checked_add(1) == Some(number));
        let first = joins.map_or(number, |(first, _)| first);
        let above = number.checked_add(1).and_then(|next| self.ranges.remove(&next));
        self.ranges.insert(first, above.unwrap_or(number));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_is_new_once_and_neighbours_make_one_range() {
        let mut numbers = FrameNumbers::default();
        assert!(numbers.is_empty());
        let order = [5, 7, 6, 0, u64::MAX, 1, u64::MAX - 1, 100];
        for (i, number) in order.into_iter().enumerate() {
            assert!(numbers.insert(number), "{number}");
            assert!(order[..=i].iter().all(|seen| !numbers.insert(*seen)));
        }
        let ranges: Vec<_> = numbers.ranges.into_iter().collect();
        assert_eq!(ranges, [(0, 1), (5, 7), (100, 100), (u64::MAX - 1, u64::MAX)]);
    }

    #[test]
    fn consecutive_frames_take_the_memory_of_one_range() {
        let mut numbers = FrameNumbers::default();
        assert!((0..10_000).all(|number| numbers.insert(number)));
        assert_eq!(numbers.ranges.len(), 1);
    }
}
