//! The selection of a batch against its definition.

extern crate std;

use super::correspondence::tests::cameras;
use super::*;
use crate::thresholds::MAX_IN_CELL;
use core::cmp::Reverse;
use proptest::prelude::*;
use std::vec::Vec;

prop_compose! {
    /// Matches on whole pixels with four different scores; half of them lie in one cell and its neighbours.
    fn matches()(u in 0..640_u16, v in 0..480_u16, crowded: bool, d in 1..60_u8, score in 0..4_u8)
        -> Correspondence<f32>
    {
        let [u, v] = if crowded { [100 + u / 8, 200 + v / 8] } else { [u, v] }.map(f32::from);
        let [d, score] = [d, score].map(f32::from);
        Correspondence { left: [u, v], right: [u.max(d) - d, v], score: score / 4.0, grid_step: 1.0 }
    }
}

fn in_one_cell() -> impl Strategy<Value = Correspondence<f32>> {
    (0..79_u8, 0..79_u8, 1..60_u8, 0..4_u8).prop_map(|(u, v, d, score)| {
        let [u, v, d, score] = [u, v, d, score].map(f32::from);
        let left = [240.0 + u, 240.0 + v];
        Correspondence { left, right: [left[0] - d, left[1]], score: score / 4.0, grid_step: 1.0 }
    })
}

/// Priority, and the rays that decide between equal priorities.
type Order = (Priority, [u64; 4]);

fn order(c: &Correspondence<f32>) -> Order {
    (Priority::of(c), ray_bits(&cameras().rays(c).unwrap()))
}

/// Returns the selection by its definition: the first `n` of all matches by rank in their cell, then by priority.
fn first_by_rank_and_priority(offered: &[Correspondence<f32>], n: usize) -> Vec<[u64; 4]> {
    let all: Vec<_> = offered.iter().map(|c| (cameras().cell(c), order(c))).collect();
    let rank = |cell, p| all.iter().filter(|(c, other)| *c == cell && *other > p).count();
    let mut order: Vec<_> = all.iter().map(|&(c, p)| (rank(c, p), Reverse(p))).collect();
    order.retain(|(rank, _)| *rank < MAX_IN_CELL.into());
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
    let mut kept: Vec<_> = batch.matches().iter().map(ray_bits).collect();
    kept.sort_unstable();
    kept
}

proptest! {
    #[test]
    fn the_first_by_rank_and_priority_stay_for_any_order_of_arrival(
        mut offered in prop::collection::vec(matches(), 0..400),
        seed in prop::collection::vec(any::<prop::sample::Index>(), 400),
    ) {
        // Duplicates are removed, because their ranks are not defined.
        offered.sort_by(|a, b| (a.left, a.right).partial_cmp(&(b.left, b.right)).unwrap());
        offered.dedup_by(|a, b| (a.left, a.right) == (b.left, b.right));
        for i in (1..offered.len()).rev() {
            offered.swap(i, seed[i].index(i + 1));
        }
        // The capacities are less than one match, about one match, and several matches per cell.
        prop_assert_eq!(selected::<20>(&offered), first_by_rank_and_priority(&offered, 20));
        prop_assert_eq!(selected::<60>(&offered), first_by_rank_and_priority(&offered, 60));
        prop_assert_eq!(selected::<200>(&offered), first_by_rank_and_priority(&offered, 200));
    }

    #[test]
    fn a_cell_keeps_the_first_by_priority_for_any_order_of_arrival(
        mut offered in prop::collection::vec(in_one_cell(), 100..300),
    ) {
        offered.sort_by(|a, b| (a.left, a.right).partial_cmp(&(b.left, b.right)).unwrap());
        offered.dedup_by(|a, b| (a.left, a.right) == (b.left, b.right));
        let expected = first_by_rank_and_priority(&offered, 512);
        prop_assert_eq!(expected.len(), offered.len().min(MAX_IN_CELL.into()));
        for turn in [0, 50] {
            offered.rotate_left(turn);
            prop_assert_eq!(&selected::<512>(&offered), &expected);
            offered.reverse();
            prop_assert_eq!(&selected::<512>(&offered), &expected);
        }
    }
}
