//! A pair counts once, in whichever way it is taken, and copies of a pair do not count.

use crate::api::presets::robust;
use crate::api::scene::{correspondences, fill, rig, take};
use stereo_selfcal::{Calibrator, Correspondence, Fused, Outcome, State};
use test_support::runs;

type Tested = Calibrator<f32, 256>;

fn scene(seed: u64) -> Vec<Correspondence<f32>> {
    correspondences(&rig([1.0, -0.5, 0.8], [0.5, -0.4]), 250, 0.5, seed)
}

type Way = fn(&mut Tested, &[Correspondence<f32>]) -> Outcome<f32>;

/// Ways to take a pair.
const WAYS: [Way; 4] = [
    // In one call.
    |calibrator, matches| calibrator.take_pair(matches.iter().copied()),
    // A match at a time.
    |calibrator, matches| {
        for c in matches {
            calibrator.push(c).unwrap();
        }
        calibrator.solve_pair()
    },
    // Two passes in one call each, and then the other passes in one call.
    |calibrator, matches| {
        fill(calibrator, matches);
        assert_eq!([(); 2].map(|()| calibrator.advance_pair()), [None; 2]);
        calibrator.solve_pair()
    },
    // While another pair is being solved; that pair is discarded.
    |calibrator, matches| {
        fill(calibrator, &scene(99));
        assert_eq!(calibrator.advance_pair(), None);
        calibrator.take_pair(matches.iter().copied())
    },
];

#[test]
fn every_way_to_take_a_pair_counts_it_once_and_with_the_same_bits() {
    let mut estimates = WAYS.into_iter().map(|take| {
        let mut calibrator = robust();
        for seed in 0..8 {
            assert_eq!(take(&mut calibrator, &scene(seed)).fused, Ok(Fused::Added), "{seed}");
            // The matches of the pair are not solved again.
            assert!(calibrator.clone().solve_pair().fused.is_err());
        }
        let proposal = calibrator.proposal().unwrap();
        assert_eq!((proposal.state, proposal.pairs), (State::Locked, 8));
        (proposal, *calibrator.verdict())
    });
    let first = estimates.next().unwrap();
    assert!(estimates.all(|estimate| estimate == first));
}

#[test]
fn a_pair_that_is_begun_and_not_fused_is_not_remembered() {
    let mut calibrator = robust();
    for seed in 0..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    fill(&mut calibrator, &scene(7));
    assert_eq!(calibrator.advance_pair(), None);
    // A copy of the last fused pair.
    assert_eq!(take(&mut calibrator, &scene(5)), Ok(Fused::Repeated));
    assert_eq!(take(&mut calibrator, &scene(7)), Ok(Fused::Added));
    assert_eq!(calibrator.proposal().unwrap().pairs, 7);
}

#[test]
fn copies_of_one_pair_lock_nothing() {
    let mut calibrator = robust();
    for copy in 0..20 {
        take(&mut calibrator, &scene(0)).unwrap();
        assert_eq!(calibrator.state(), State::Acquiring, "{copy}");
        assert_eq!(calibrator.proposal().unwrap().pairs, 1);
    }
    for seed in 1..4 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    assert_eq!(calibrator.state(), State::Locked);
}

#[test]
fn copies_of_one_pair_of_another_rig_take_nothing_over() {
    let mut calibrator = robust();
    for seed in 0..8 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    let before = calibrator.proposal().unwrap().extrinsics;
    let other = correspondences(&rig([1.3, -0.5, 0.8], [0.5, -0.4]), 250, 0.5, 20);
    for copy in 0..20 {
        assert_ne!(take(&mut calibrator, &other), Ok(Fused::TookOver), "{copy}");
        assert_eq!(calibrator.proposal().unwrap().extrinsics, before, "{copy}");
    }
}

#[test]
fn a_parked_vehicle_forgets_nothing() {
    let lives = [0, runs(1000, 10_000)].map(|parked| {
        let mut calibrator = robust();
        for seed in 0..30 {
            take(&mut calibrator, &scene(seed)).unwrap();
        }
        for _ in 0..parked {
            assert_eq!(take(&mut calibrator, &scene(29)), Ok(Fused::Repeated));
        }
        // The knowledge of lens and mount shows once a knock has replaced the sums.
        let after = (0..10).map(|seed| {
            let knocked = rig([1.3, -0.5, 0.8], [0.5, -0.4]);
            let fused = take(&mut calibrator, &correspondences(&knocked, 250, 0.5, 50 + seed));
            (fused, calibrator.proposal())
        });
        after.collect::<Vec<_>>()
    });
    let [driven, parked] = lives;
    assert!(driven.iter().any(|(fused, _)| *fused == Ok(Fused::TookOver)));
    assert_eq!(driven, parked);
}
