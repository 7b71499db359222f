//! Evidence for one calibration or estimate must not count for another one.

use crate::api::depth;
use crate::api::lens::pair_of;
use crate::api::presets::{calibrated, with};
use crate::api::scene::{cameras, correspondences, correspondences_within, fill, rig, take};
use stereo_selfcal::{
    Calibrator, Cause, Config, Correspondence, Extrinsics, FactoryCalibration, Fused, LensTracking,
    Reason, Rejection, State,
};

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
fn one_scene_does_not_replace_the_baseline_of_a_calibration_and_three_do() {
    // The rows of all matches are off as with a baseline 8 degrees away.
    let biased = rig(ROTATION, BASELINE.map(|angle| angle + 8.0 * angle.signum()));
    let replaces = |(depths, scenes, step_px): ([f64; 2], u64, f32)| {
        let mut calibrator = calibrated(rig(ROTATION, BASELINE));
        for pair in 0..9_u8 {
            let seed = u64::from(pair) % scenes;
            let scene = correspondences_within(&biased, depths, 250, 1.0, seed);
            let by = step_px * f32::from(pair);
            // Both images lose what moves out of their upper left part.
            let moved = |c: Correspondence<f32>| {
                let [left, right] = [c.left, c.right].map(|pixel| pixel.map(|x| x + by));
                let is_inside = left.into_iter().chain(right).all(|x| x < 1100.0);
                is_inside.then_some(Correspondence { left, right, ..c })
            };
            let pair: Vec<_> = scene.into_iter().filter_map(moved).collect();
            let _ = take(&mut calibrator, &pair);
        }
        let t = calibrator.proposal().unwrap().applicable.translation().into_inner();
        (t - calibrator.in_use().extrinsics.translation().into_inner()).norm() > 1e-4
    };
    let (far, near) = ([150.0, 1500.0], [5.0, 50.0]);
    // A view that moves by less than a pixel repeats the scene. A motion of 2 px is a quarter of a new scene.
    let one = [(far, 1, 0.1), (near, 1, 0.1), (near, 1, 1.8)];
    assert_eq!(one.map(replaces), [false; 3]);
    let three = [(far, 3, 0.1), (near, 3, 0.1), (near, 1, 9.0)];
    assert_eq!(three.map(replaces), [true; 3]);
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

#[test]
fn a_baseline_turns_with_the_right_camera_and_not_with_the_left_one() {
    let before = rig(ROTATION, BASELINE);
    let turn = rig([0.0, 3.0, -2.0], [0.0; 2]).rotation().to_owned();
    let (r, t) = (before.rotation(), before.translation().into_inner());
    let right = Extrinsics::try_new((turn * r).matrix(), &(turn * t)).unwrap();
    let left = Extrinsics::try_new((r * turn).matrix(), &t).unwrap();
    for (knocked, kept) in [(right, false), (left, true)] {
        let mut calibrator = calibrated(rig(ROTATION, BASELINE));
        let scene = correspondences_within(&knocked, [5.0, 50.0], 250, 0.3, 1);
        for pair in 0..9_u8 {
            let by = 0.1 * f32::from(pair);
            let moved = |c: &Correspondence<f32>| Correspondence {
                left: c.left.map(|x| x + by),
                right: c.right.map(|x| x + by),
                ..*c
            };
            let _ = take(&mut calibrator, &scene.iter().map(moved).collect::<Vec<_>>());
        }
        // One scene replaces no baseline.
        let held = calibrator.proposal().unwrap().applicable;
        let in_use = calibrator.in_use().extrinsics;
        let moved = (held.translation().into_inner() - in_use.translation().into_inner()).norm();
        assert_eq!(moved < 1e-6, kept, "{moved}");
        let truth = knocked.translation().into_inner().cast::<f32>();
        let off = (held.translation().into_inner() - truth).norm();
        assert!(off < 0.01, "{off}");
    }
}

#[test]
fn a_frozen_calibrator_does_not_begin_again_with_another_lens() {
    let config = Config::robust().with_lens_tracking(LensTracking::Compensate);
    let truth = rig(ROTATION, BASELINE);
    let factory = FactoryCalibration::new(cameras(), rig(ROTATION, BASELINE));
    let mut calibrator = Calibrator::<f32, 256>::new(config, &factory);
    let pair = |seed| pair_of(&truth, 0.003, 0.002, seed);
    let corrects = |calibrator: &Calibrator<f32, 256>, seed| {
        take(&mut calibrator.clone(), &pair(seed)) == Ok(Fused::LensCorrected)
    };
    let first = (0..40).find(|seed| {
        let corrects = corrects(&calibrator, *seed);
        if !corrects {
            let _ = take(&mut calibrator, &pair(*seed));
        }
        corrects
    });
    // The caller freezes the calibrator before the last step of the pair that corrects the lens.
    fill(&mut calibrator, &pair(first.unwrap()));
    let mut frozen = calibrator.clone();
    while calibrator.advance_pair().is_none() {
        frozen = calibrator.clone();
        frozen.set_frozen(true);
    }
    let pairs = |of: &Calibrator<f32, 256>| of.proposal().map(|proposal| proposal.pairs);
    let before = pairs(&frozen);
    let fused = frozen.solve_pair().fused;
    assert_eq!((fused, pairs(&frozen)), (Ok(Fused::Added), before));
}

#[test]
fn a_calibration_applied_before_the_verdict_borrows_no_evidence() {
    let armed = [false, true].map(|early| {
        let mut calibrator = locked();
        for (degrees, seed) in [(0.3, 20), (0.3, 21), (0.0, 22)] {
            let _ = take(&mut calibrator, &pitched(degrees, seed));
        }
        fill(&mut calibrator, &pitched(0.3, 23));
        while calibrator.advance_pair().is_none() {
            // The pair has been fused and took over, and has no verdict yet.
            if early && calibrator.state() == State::Locked {
                calibrator.apply().unwrap();
            }
        }
        calibrator.apply().unwrap();
        calibrator.verdict().may_arm
    });
    assert_eq!(armed, [false; 2]);
}

/// Whether a rig with a confirmed yaw arms after a pair in spite of an error of disparities beyond three expected ones.
fn arms_wrongly(calibrator: &mut depth::Tested, yaw_degrees: f64, seed: u64) -> bool {
    let knock = [0.0, yaw_degrees, 0.0];
    let _ = take(calibrator, &depth::warped(knock, 0.0, seed));
    if calibrator.verdict().should_apply {
        let _ = calibrator.apply();
    }
    let off_px = depth::off(calibrator, knock).y.abs() * 1400.0;
    let verdict = calibrator.verdict();
    verdict.may_arm && off_px > 3.0 * verdict.depth_px
}

/// A rig whose yaw ranges have confirmed.
fn confirmed() -> depth::Tested {
    let mut calibrator = depth::with_baseline();
    depth::run(&mut calibrator, depth::NONE, 0.0, 0..30);
    let pair = depth::warped(depth::NONE, 0.0, 29);
    let ranges = pair.iter().step_by(9).take(9);
    let taken =
        ranges.filter(|c| calibrator.push_range(&depth::reading(depth::NONE, c, 1.0)).is_ok());
    assert!(taken.count() >= 5 && calibrator.verdict().may_arm);
    calibrator
}

#[test]
fn a_frozen_estimate_that_rejects_the_pairs_confirms_no_depth() {
    for yaw in [0.2, 0.3] {
        let mut frozen = confirmed();
        frozen.set_frozen(true);
        let wrong = (300..350).filter(|seed| arms_wrongly(&mut frozen, yaw, *seed)).count();
        assert!(wrong < 5, "{yaw}: {wrong}");
    }
}
