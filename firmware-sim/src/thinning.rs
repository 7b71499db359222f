//! Which records of a frame longer than the batch are taken.

/// Takes `room` of `count` records, evenly over the frame.
///
/// A matcher sends in scan order: the first `room` would be one part of the image, which leaves
/// directions of the extrinsics weakly determined.
#[derive(Debug)]
pub(crate) struct Thinning {
    room: usize,
    count: usize,
    credit: usize,
}

impl Thinning {
    pub(crate) fn new(room: usize, count: usize) -> Self {
        Self { room: room.min(count), count, credit: 0 }
    }

    /// Whether the next record is taken.
    pub(crate) fn takes_next(&mut self) -> bool {
        self.credit = self.credit.saturating_add(self.room);
        let takes = self.credit >= self.count;
        if takes {
            self.credit = self.credit.saturating_sub(self.count);
        }
        takes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn as_many_as_there_is_room_for_are_taken_at_even_distances(
            room in 0..600_usize,
            count in 0..3000_usize,
        ) {
            let mut thinning = Thinning::new(room, count);
            let taken: Vec<usize> = (0..count).filter(|_| thinning.takes_next()).collect();
            prop_assert_eq!(taken.len(), room.min(count));
            let gaps: Vec<usize> = taken.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let widest = gaps.iter().max().copied().unwrap_or(1);
            prop_assert!(gaps.iter().all(|gap| gap + 1 >= widest), "{:?}", gaps);
        }
    }
}
