//! Cameras whose triggers differ, in a turn.

use stereo_selfcal::{Calibrator, Config, PairError, Refusal, State};

use crate::api::presets::with;
use crate::api::scene::{correspondences, fill, rig};

const LIMIT: f32 = 0.1;

/// Pairs of a rig at rest, then of a turn at 3 rad/s with a skew of 1 ms: `R` is off by 3 mrad.
fn after_a_turn(config: Config, told: Option<f32>) -> Calibrator<f32, 256> {
    let mut calibrator = with(config);
    for pair in 0..20 {
        let late = if pair < 10 { 0.0 } else { 0.003_f64.to_degrees() };
        let matches = correspondences(&rig([1.0, -0.5 + late, 0.8], [0.5, -0.4]), 250, 0.5, pair);
        fill(&mut calibrator, &matches);
        if let Some(rate) = told {
            calibrator.set_angular_rate(if pair < 10 { 0.02 } else { rate });
        }
        match calibrator.solve_pair() {
            Ok(_) => drop(calibrator.fuse()),
            Err(why) => assert_eq!(why, PairError::Turning),
        }
    }
    calibrator
}

#[test]
fn a_pair_of_a_fast_turn_is_refused_and_the_estimate_stays() {
    let limited = Config::robust().with_max_angular_rate(LIMIT).unwrap();
    let [told, untold] = [Some(-3.0), None].map(|rate| after_a_turn(limited, rate));
    let kept = told.proposal().unwrap();
    assert_eq!((kept.state, kept.pairs), (State::Locked, 10));
    // What the rate would be worth: the turn is taken for a rig that has changed.
    let followed = untold.proposal().unwrap();
    assert_ne!(followed.extrinsics, kept.extrinsics);
    // Without a limit the rate says nothing.
    let unlimited = after_a_turn(Config::robust(), Some(-3.0)).proposal().unwrap();
    assert_eq!(unlimited.extrinsics, followed.extrinsics);
}

#[test]
fn a_rate_that_is_not_finite_is_too_fast_and_holds_for_one_pair() {
    let mut calibrator = with::<f32>(Config::robust().with_max_angular_rate(LIMIT).unwrap());
    let matches = correspondences(&rig([1.0, -0.5, 0.8], [0.5, -0.4]), 250, 0.5, 1);
    for rate in [f32::NAN, f32::INFINITY, -0.11, 0.11] {
        fill(&mut calibrator, &matches);
        calibrator.set_angular_rate(rate);
        assert_eq!(calibrator.begin_pair(), Err(PairError::Turning), "{rate}");
        assert!(!calibrator.is_solving() && calibrator.batch().pairs().len() == 250);
    }
    fill(&mut calibrator, &matches);
    assert!(calibrator.solve_pair().is_ok());
}

#[test]
fn a_pair_solved_before_a_fast_turn_is_not_fused_after_it() {
    for preset in [Config::robust(), Config::paper()] {
        let mut calibrator = with::<f32>(preset.with_max_angular_rate(LIMIT).unwrap());
        let matches = correspondences(&rig([1.0, -0.5, 0.8], [0.5, -0.4]), 250, 0.5, 1);
        fill(&mut calibrator, &matches);
        calibrator.solve_pair().unwrap();
        fill(&mut calibrator, &matches);
        calibrator.set_angular_rate(2.0 * LIMIT);
        assert_eq!(calibrator.solve_pair(), Err(PairError::Turning));
        assert_eq!(calibrator.fuse(), Err(Refusal::NothingSolved));
    }
}
