//! A pair counts once, however often it is solved, begun or sent.

use crate::api::presets::robust;
use crate::api::scene::{correspondences, fill, rig, take};
use stereo_selfcal::{Calibrator, Correspondence, Fused, State};

type Tested = Calibrator<f32, 256>;

fn scene(seed: u64) -> Vec<Correspondence<f32>> {
    correspondences(&rig([1.0, -0.5, 0.8], [0.5, -0.4]), 250, 0.5, seed)
}

type Way = fn(&mut Tested, &[Correspondence<f32>]);

/// Ways to begin a batch more than once before its pair is fused.
const WAYS: [Way; 4] = [
    // Once.
    |calibrator, matches| {
        fill(calibrator, matches);
        calibrator.solve_pair().unwrap();
    },
    // Matches come late.
    |calibrator, matches| {
        let (early, late) = matches.split_at(200);
        fill(calibrator, early);
        calibrator.solve_pair().unwrap();
        for c in late {
            calibrator.push(c).unwrap();
        }
        calibrator.solve_pair().unwrap();
    },
    // A time slice is given up.
    |calibrator, matches| {
        fill(calibrator, matches);
        calibrator.begin_pair().unwrap();
        calibrator.advance_pair().unwrap();
        calibrator.solve_pair().unwrap();
    },
    // Solved at once, then in slices.
    |calibrator, matches| {
        fill(calibrator, matches);
        calibrator.solve_pair().unwrap();
        calibrator.begin_pair().unwrap();
        while calibrator.advance_pair().unwrap().is_none() {}
    },
];

#[test]
fn a_pair_that_is_begun_more_than_once_replaces_none_of_the_pairs_before() {
    for (way, solve) in WAYS.into_iter().enumerate() {
        let mut calibrator = robust();
        for seed in 0..8 {
            solve(&mut calibrator, &scene(seed));
            assert_eq!(calibrator.fuse(), Ok(Fused::Added), "{way}: {seed}");
        }
        let proposal = calibrator.proposal().unwrap();
        assert_eq!((proposal.state, proposal.pairs), (State::Locked, 8), "{way}");
    }
}

#[test]
fn a_pair_that_is_begun_and_not_fused_is_not_remembered() {
    let mut calibrator = robust();
    for seed in 0..6 {
        take(&mut calibrator, &scene(seed)).unwrap();
    }
    fill(&mut calibrator, &scene(7));
    calibrator.begin_pair().unwrap();
    // The last fused pair comes again.
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
