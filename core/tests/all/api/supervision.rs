//! Supervision of an estimate that may be wrong: locking, knocks, pairs of only outliers, still scenes, drift, limits.

use crate::api::disturbed::{garbage, jittered, with_outliers};
use crate::api::presets::{robust, with};
use crate::api::scene::{correspondences, rig, take};
use stereo_selfcal::geometry::RectifyingRotations;
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibrator, Config, Correspondence, Extrinsics, Fused, Proposal, Rejection, State,
};

const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const BASELINE: [f64; 2] = [0.5, -0.4];

type Tested = Calibrator<f32, 256>;

fn scene(rotation: [f64; 3], seed: u64) -> Vec<Correspondence<f32>> {
    correspondences(&rig(rotation, BASELINE), 250, 0.5, seed)
}

/// A calibrator that has locked on ten pairs of the rig and applied the estimate.
fn locked() -> Tested {
    let mut calibrator = robust();
    for seed in 1000..1010 {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
    }
    assert_eq!(calibrator.state(), State::Locked);
    calibrator.apply().unwrap();
    calibrator
}

/// Rotations after a knock of pitch or roll by 0.3 degrees.
fn knocks() -> [[f64; 3]; 4] {
    let [x, y, z] = ROTATION;
    [[x + 0.3, y, z], [x - 0.3, y, z], [x, y, z + 0.3], [x, y, z - 0.3]]
}

/// Whether the estimate agrees with the rig within four of its reported standard deviations.
fn is_of(proposal: &Proposal<f32>, rotation: [f64; 3]) -> bool {
    let error = Deviation::between(&proposal.extrinsics, &rig(rotation, BASELINE));
    error.rotation < 4.0 * proposal.sd.rotation && error.translation < 4.0 * proposal.sd.translation
}

#[test]
fn an_estimate_locks_when_three_pairs_agree_with_the_first_and_never_before() {
    for run in 0..20 {
        let mut calibrator = robust();
        assert_eq!((calibrator.state(), calibrator.proposal()), (State::Acquiring, None));
        for pair in 0..4 {
            let matches = with_outliers(scene(ROTATION, 4 * run + pair), 4);
            assert_eq!(take(&mut calibrator, &matches), Ok(Fused::Added));
            let locked = if pair < 3 { State::Acquiring } else { State::Locked };
            assert_eq!(calibrator.state(), locked, "{run} {pair}");
        }
        assert!(is_of(&calibrator.proposal().unwrap(), ROTATION), "{run}");
    }
}

#[test]
fn a_first_pair_of_another_rig_is_replaced_by_one_that_fits_better() {
    let [x, y, z] = ROTATION;
    for run in 0..10 {
        let mut calibrator = robust();
        take(&mut calibrator, &scene([x + 2.0, y, z - 1.0], 500 + run)).unwrap();
        for pair in 0..5 {
            let _ = take(&mut calibrator, &with_outliers(scene(ROTATION, 5 * run + pair), 4));
        }
        assert_eq!(calibrator.state(), State::Locked, "{run}");
        assert!(is_of(&calibrator.proposal().unwrap(), ROTATION), "{run}");
    }
}

#[test]
fn a_knock_is_suspected_at_once_and_its_third_pair_takes_over() {
    for knocked in knocks() {
        let mut calibrator = locked();
        let (before, in_use) = (calibrator.proposal().unwrap(), calibrator.in_use().extrinsics);
        for seed in [1, 2] {
            assert_eq!(take(&mut calibrator, &scene(knocked, seed)), Ok(Fused::KeptApart));
            let now = calibrator.proposal().unwrap();
            assert_eq!(now.state, State::Suspect);
            assert_eq!((now.extrinsics, now.sd), (before.extrinsics, before.sd));
        }
        assert_eq!(take(&mut calibrator, &scene(knocked, 3)), Ok(Fused::TookOver));
        let now = calibrator.proposal().unwrap();
        assert_eq!((now.state, now.pairs), (State::Locked, 3));
        assert!(is_of(&now, knocked), "{knocked:?} {now:?}");
        assert_eq!((&calibrator.in_use().extrinsics, calibrator.in_use().generation), (&in_use, 1));
        assert_eq!(calibrator.apply().unwrap().extrinsics, now.extrinsics);
    }
}

#[test]
fn a_lone_bad_pair_does_not_unseat_the_estimate() {
    for knocked in knocks() {
        let mut calibrator = locked();
        assert_eq!(take(&mut calibrator, &scene(knocked, 1)), Ok(Fused::KeptApart));
        assert_eq!(calibrator.state(), State::Suspect);
        for seed in [2, 3] {
            assert_eq!(take(&mut calibrator, &scene(ROTATION, seed)), Ok(Fused::Added));
        }
        assert_eq!(calibrator.state(), State::Locked);
        assert_eq!(calibrator.proposal().unwrap().pairs, 12);
        assert!(is_of(&calibrator.proposal().unwrap(), ROTATION));
    }
}

#[test]
fn ten_pairs_of_rubbish_lose_the_rig_not_the_estimate_and_good_ones_recover_it() {
    for run in 0..5 {
        let mut calibrator = locked();
        let (before, in_use) = (calibrator.proposal().unwrap(), calibrator.in_use().extrinsics);
        for pair in 0..20 {
            let _ = take(&mut calibrator, &garbage(250, 100 * run + pair));
            let now = calibrator.proposal().unwrap();
            let expected = if pair < 9 { State::Suspect } else { State::Lost };
            assert_eq!(now.state, expected, "{run} {pair}");
            assert_eq!((now.extrinsics, now.sd, now.pairs), (before.extrinsics, before.sd, 10));
        }
        assert!(calibrator.apply().is_err());
        assert_eq!(&calibrator.in_use().extrinsics, &in_use);
        for seed in 0..2 {
            take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
        }
        assert_eq!(calibrator.state(), State::Locked, "{run}");
        assert!(is_of(&calibrator.proposal().unwrap(), ROTATION));
    }
}

/// A pair of a rig with `percent` percent of outliers.
pub(crate) fn poor(rotation: [f64; 3], percent: usize, seed: u64) -> Vec<Correspondence<f32>> {
    let mut matches = scene(rotation, seed);
    let outliers = matches.len() * percent / 100;
    matches.truncate(matches.len() - outliers);
    matches.extend(garbage(outliers, seed));
    matches
}

#[test]
fn a_right_estimate_is_not_lost_where_more_than_half_of_the_matches_are_suddenly_outliers() {
    for percent in [48, 52, 56, 60] {
        let mut calibrator = locked();
        let states = (0..100).map(|seed| {
            let _ = take(&mut calibrator, &poor(ROTATION, percent, 100 * percent as u64 + seed));
            calibrator.state()
        });
        let states: Vec<State> = states.collect();
        let [locked, lost] = [State::Locked, State::Lost]
            .map(|state| states.iter().filter(|s| **s == state).count());
        println!("{percent} % outliers: locked after {locked} of 100 pairs, lost after {lost}");
        assert_eq!(lost, 0, "{percent} {states:?}");
        assert!(locked >= 90, "{percent} {states:?}");
        let proposal = calibrator.proposal().unwrap();
        assert!(is_of(&proposal, ROTATION) && proposal.pairs > 80, "{percent} {proposal:?}");
    }
}

#[test]
fn a_knock_where_more_than_half_of_the_matches_become_outliers_is_followed() {
    let [x, y, z] = ROTATION;
    for by in [0.05, 0.1, 0.3] {
        let mut calibrator = locked();
        for seed in 0..30 {
            let _ = take(&mut calibrator, &poor([x + by, y, z], 56, seed));
        }
        let proposal = calibrator.proposal().unwrap();
        assert_eq!(proposal.state, State::Locked, "{by}");
        assert!(is_of(&proposal, [x + by, y, z]), "{by} {proposal:?}");
    }
}

#[test]
fn a_lost_rig_is_found_again_where_it_is_now() {
    let mut calibrator = locked();
    for seed in 0..12 {
        let _ = take(&mut calibrator, &garbage(250, seed));
    }
    assert_eq!(calibrator.state(), State::Lost);
    // Further from the estimate than a track reaches.
    let moved = [-1.5, 1.0, -2.0];
    for seed in 0..6 {
        let _ = take(&mut calibrator, &scene(moved, seed));
    }
    assert_eq!(calibrator.state(), State::Locked);
    assert!(is_of(&calibrator.proposal().unwrap(), moved));
}

#[test]
fn outliers_alone_never_lock() {
    for run in 0..5 {
        let mut calibrator = robust::<f32>();
        for pair in 0..60 {
            let _ = take(&mut calibrator, &garbage(250, 60 * run + pair));
            assert_eq!(calibrator.state(), State::Acquiring, "{run} {pair}");
        }
    }
}

#[test]
fn a_still_scene_is_one_pair_however_often_it_comes_and_fresh_scenes_are_many() {
    let still = scene(ROTATION, 1);
    let mut calibrator = robust();
    take(&mut calibrator, &still).unwrap();
    let once = calibrator.proposal().unwrap();
    for seed in 0..200 {
        assert!(take(&mut calibrator, &jittered(&still, 0.5, seed)).is_ok(), "{seed}");
        let now = calibrator.proposal().unwrap();
        assert_eq!(now.pairs, 1);
        assert!(now.sd.rotation > 0.9 * once.sd.rotation, "{seed}");
        assert!(now.sd.translation > 0.9 * once.sd.translation, "{seed}");
    }

    let mut calibrator = robust();
    for seed in 0..200 {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
    }
    let many = calibrator.proposal().unwrap();
    assert_eq!(many.pairs, 200);
    // With the same information in every scene it would be a fourteenth: one over the root of 200.
    assert!(many.sd.rotation < 0.1 * once.sd.rotation, "{many:?}");
    assert!(many.sd.translation < 0.1 * once.sd.translation, "{many:?}");
}

#[test]
fn a_still_scene_adds_one_pair_to_those_before_it() {
    let mut calibrator = locked();
    let still = scene(ROTATION, 1);
    assert_eq!(take(&mut calibrator, &still), Ok(Fused::Added));
    let once = calibrator.proposal().unwrap();
    for seed in 0..50 {
        let fused = take(&mut calibrator, &jittered(&still, 0.5, seed));
        assert_eq!(fused, Ok(Fused::Repeated), "{seed}");
    }
    assert_eq!(calibrator.proposal().unwrap(), once);
    assert_eq!(take(&mut calibrator, &scene(ROTATION, 2)), Ok(Fused::Added));
}

/// Axes (pitch, yaw, roll) and their drift in degrees per pair, which is less than a single pair shows.
const STEPS: [(usize, f64); 6] =
    [(0, 0.0005), (0, 0.001), (1, 0.005), (1, 0.01), (2, 0.001), (2, 0.002)];

#[test]
fn a_drift_of_small_steps_is_noticed_and_followed() {
    for (axis, step) in STEPS {
        let mut calibrator = locked();
        let mut rotation = ROTATION;
        let [mut renewals, mut renewed, mut locks] = [0; 3];
        let mut worst = 0.0_f32;
        let ten_pairs = calibrator.proposal().unwrap().covariance[(axis, axis)].sqrt();
        for seed in 0..200 {
            rotation[axis] += step;
            let fused = take(&mut calibrator, &scene(rotation, seed));
            renewals += u32::from(matches!(fused, Ok(Fused::Renewed | Fused::TookOver)));
            renewed += u32::from(fused == Ok(Fused::Renewed));
            let proposal = calibrator.proposal().unwrap();
            locks += u32::from(proposal.state == State::Locked);
            let truth = RectifyingRotations::from(&rig::<f32>(rotation, BASELINE));
            let off = RectifyingRotations::from(&proposal.extrinsics).unknowns_to(&truth);
            worst = worst.max(off[axis].abs() / ten_pairs);
        }
        assert!(renewals >= 4 && locks >= 150, "{axis} {step}: {renewals} {locks}");
        // The window over recent pairs detects the drift, which no single pair shows.
        assert!(renewed >= 1, "{axis} {step}");
        // 25 deviations of ten pairs are eight deviations of a single pair.
        assert!(worst < 25.0, "{axis} {step}: {worst}");
    }
}

#[test]
fn a_rig_beyond_the_correction_limit_is_refused_and_unlocks() {
    let config = Config::robust().with_max_correction_rad(0.03).unwrap();
    let mut calibrator = with::<f32, 256>(config);
    for seed in 0..6 {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
    }
    assert_eq!(calibrator.state(), State::Locked);
    calibrator.apply().unwrap();
    let (before, in_use) = (calibrator.proposal().unwrap(), calibrator.in_use().extrinsics);
    for seed in 10..30 {
        let refused = take(&mut calibrator, &scene([3.0, -0.5, 0.8], seed));
        assert_eq!(refused, Err(Rejection::CorrectionLimit), "{seed}");
        let now = calibrator.proposal().unwrap();
        assert_eq!((now.extrinsics, now.sd, now.pairs), (before.extrinsics, before.sd, 6));
        assert_ne!(now.state, State::Locked);
    }
    assert_eq!(calibrator.state(), State::Lost);
    assert_eq!(&calibrator.in_use().extrinsics, &in_use);
}

#[test]
fn a_pair_that_agrees_but_leads_beyond_the_correction_limit_makes_the_estimate_suspect() {
    let mut calibrator = robust::<f32>();
    let mut limit = 0.0_f32;
    for seed in 0..6 {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
        let found = calibrator.proposal().unwrap().extrinsics;
        let off = Deviation::between(&found, &Extrinsics::SIDE_BY_SIDE);
        limit = limit.max(off.rotation).max(off.translation) + 1e-7;
    }
    // The limit allows the corrections after these six pairs, and no larger one.
    let config = Config::robust().with_max_correction_rad(limit).unwrap();
    let mut calibrator = with::<f32, 256>(config);
    for seed in 0..6 {
        take(&mut calibrator, &scene(ROTATION, seed)).unwrap();
    }
    let beyond = Err(Rejection::CorrectionLimit);
    let mut before = calibrator.proposal().unwrap();
    let refused = (6..200).find(|&seed| {
        before = calibrator.proposal().unwrap();
        assert_eq!(before.state, State::Locked);
        // The rig slowly turns further from the factory extrinsics.
        let [x, y, z] = ROTATION;
        let further = 0.0002 * (seed - 5) as f64;
        take(&mut calibrator, &scene([x + further, y, z], seed)) == beyond
    });
    let after = calibrator.proposal().unwrap();
    assert!(refused.is_some());
    assert_eq!(after.state, State::Suspect);
    assert_eq!((after.extrinsics, after.sd), (before.extrinsics, before.sd));
}

#[test]
fn a_rig_that_creeps_beyond_the_correction_limit_stops_short_of_it() {
    let limit = 0.025;
    let config = Config::robust().with_max_correction_rad(limit).unwrap();
    let mut calibrator = with::<f32, 256>(config);
    let mut refused = false;
    for seed in 0..200_u8 {
        let rotation = [1.38 + 0.001 * f64::from(seed), 0.0, 0.0];
        let fused = take(&mut calibrator, &scene(rotation, seed.into()));
        if fused == Err(Rejection::CorrectionLimit) {
            refused = true;
            assert_ne!(calibrator.state(), State::Locked, "{seed}");
        }
        if let Some(proposal) = calibrator.proposal() {
            let off = Deviation::between(&proposal.extrinsics, &Extrinsics::SIDE_BY_SIDE);
            assert!(off.rotation <= limit && off.translation <= limit, "{off:?}");
        }
    }
    assert!(refused);
    assert_ne!(calibrator.state(), State::Locked);
}

#[test]
fn a_rig_is_locked_again_ten_pairs_after_its_matcher_became_four_times_as_noisy() {
    for one_in in [3, 250] {
        let mut calibrator = locked();
        let noisy = |seed| correspondences(&rig(ROTATION, BASELINE), 250, 2.0, seed);
        let states: Vec<State> = (2000..2020)
            .map(|seed| {
                let _ = take(&mut calibrator, &with_outliers(noisy(seed), one_in));
                calibrator.state()
            })
            .collect();
        assert!(states.ends_with(&[State::Locked; 10]), "{one_in} {states:?}");
        assert!(is_of(&calibrator.proposal().unwrap(), ROTATION), "{one_in}");
    }
}
