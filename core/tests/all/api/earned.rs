//! Evidence for one calibration or estimate must not count for another one.

use crate::api::presets::{calibrated, with};
use crate::api::scene::{correspondences, correspondences_within, fill, rig, take};
use stereo_selfcal::{Calibrator, Cause, Config, Correspondence, Fused, Reason, Rejection, State};

const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const BASELINE: [f64; 2] = [0.5, -0.4];

/// Matches of a rig that is pitched by some degrees.
fn pitched(degrees: f64, seed: u64) -> Vec<Correspondence<f32>> {
    let [x, y, z] = ROTATION;
    correspondences(&rig([x + degrees, y, z], BASELINE), 250, 0.3, seed)
}

/// A calibrator that has locked, with the right calibration in use.
fn locked() -> Calibrator<f32, 256> {
    let mut calibrator = calibrated(rig(ROTATION, BASELINE));
    for seed in 0..8 {
        take(&mut calibrator, &pitched(0.0, seed)).unwrap();
    }
    assert!(calibrator.verdict().may_arm);
    calibrator
}

#[test]
fn a_restored_estimate_arms_only_after_a_pair_has_supported_it() {
    // The estimate of the record is another rig than that in use, which the pairs fit.
    let mut calibrator = calibrated(rig(ROTATION, BASELINE));
    for seed in 0..8 {
        take(&mut calibrator, &pitched(0.3, seed)).unwrap();
    }
    let record = calibrator.snapshot();
    let mut restored = calibrated(rig(ROTATION, BASELINE));
    restored.restore(&record).unwrap();
    let mut armed = (8..20).map(|seed| {
        let _ = take(&mut restored, &pitched(0.0, seed));
        let verdict = restored.verdict();
        (verdict.may_arm, verdict.rows_ok)
    });
    assert_eq!([(); 2].map(|()| armed.next().unwrap()), [(false, true); 2]);
    // Pairs that agree with each other end the estimate of the record.
    assert_eq!(armed.last(), Some((true, true)));
}

#[test]
fn a_pair_that_counts_has_its_verdict_wherever_it_is_abandoned() {
    let before = locked();
    let mut suspect = 0;
    for steps in 0..30 {
        let mut calibrator = before.clone();
        fill(&mut calibrator, &pitched(0.5, 9));
        for _ in 0..steps {
            let _ = calibrator.advance_pair();
        }
        let state = calibrator.state();
        assert!(state == State::Locked || calibrator.clone().apply().is_err(), "{steps}");
        calibrator.discard_pair();
        assert_eq!((calibrator.state(), calibrator.verdict().state), (state, state), "{steps}");
        suspect += u32::from(state == State::Suspect);
    }
    assert!((1..30).contains(&suspect), "{suspect}");
}

#[test]
fn an_estimate_is_not_locked_by_a_pair_that_disagrees_with_it() {
    // The matcher becomes noisy, so the estimate rejects pairs that agree with each other and with it.
    let (mut apart, mut locked) = (0, 0);
    for run in 0..8 {
        let mut calibrator = calibrated(rig(ROTATION, BASELINE));
        for pair in 0..40 {
            let noise = if pair < 20 { 0.15 } else { 3.0 };
            let matches = correspondences(&rig(ROTATION, BASELINE), 250, noise, 100 * run + pair);
            let fused = take(&mut calibrator, &matches);
            let disagrees = matches!(fused, Ok(Fused::KeptApart) | Err(Rejection::Disagrees));
            assert!(!disagrees || calibrator.state() != State::Locked, "{run} {pair}: {fused:?}");
            apart += u32::from(disagrees);
        }
        locked += u32::from(calibrator.state() == State::Locked);
    }
    assert!(apart > 8 && locked == 8, "{apart} {locked}");
}

#[test]
fn one_far_scene_does_not_replace_a_baseline_in_use_and_three_do() {
    // The rows of all matches are off as with a baseline 8 degrees away.
    let biased = rig(ROTATION, BASELINE.map(|angle| angle + 8.0 * angle.signum()));
    let replaces = |scenes: u64| {
        let mut calibrator = calibrated(rig(ROTATION, BASELINE));
        for pair in 0..9_u8 {
            let seed = u64::from(pair) % scenes;
            let scene = correspondences_within(&biased, [150.0, 1500.0], 250, 1.0, seed);
            // The view moves less than a pixel, so a pair of one scene repeats it.
            let by = 0.1 * f32::from(pair);
            let moved = |c: Correspondence<f32>| {
                let [left, right] = [c.left, c.right].map(|pixel| pixel.map(|x| x + by));
                Correspondence { left, right, ..c }
            };
            let _ = take(&mut calibrator, &scene.into_iter().map(moved).collect::<Vec<_>>());
        }
        let t = calibrator.proposal().unwrap().applicable.translation().into_inner();
        (t - calibrator.in_use().extrinsics.translation().into_inner()).norm() > 1e-4
    };
    assert_eq!([1, 3].map(replaces), [false, true]);
}

#[test]
fn pairs_do_not_contradict_an_estimate_that_is_not_there() {
    let config = Config::robust().with_max_correction_rad(0.03).unwrap();
    let mut calibrator = with::<f32, 256>(config);
    let mut beyond = 0;
    for seed in 0..12 {
        // The rig is 0.05 rad off.
        let pair = correspondences(&rig([0.0, 0.0, 3.0], [0.0; 2]), 250, 0.3, seed);
        let refused = take(&mut calibrator, &pair).unwrap_err();
        beyond += u32::from(refused == Rejection::CorrectionLimit);
        assert_ne!(calibrator.verdict().cause, Some(Cause::Moments), "{seed}");
    }
    assert!(beyond > 6, "{beyond}");
}

#[test]
fn a_reset_forgets_that_the_scene_has_not_moved() {
    let mut calibrator = locked();
    let pair = pitched(0.0, 7);
    let _ = take(&mut calibrator, &pair);
    assert!(calibrator.verdict().reasons.contains(Reason::Repeated));
    calibrator.reset();
    let _ = take(&mut calibrator, &pair[..3]);
    assert!(!calibrator.verdict().reasons.contains(Reason::Repeated));
}
