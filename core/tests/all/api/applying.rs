//! Putting estimates into use: when it is refused, and how it is taken back.

use crate::api::presets::{robust, with};
use crate::api::scene::{correspondences, fill, rig, take};
use stereo_selfcal::{
    ApplyError, Calibrator, Config, Extrinsics, PairError, Refusal, Rejection, State,
};

const ROTATION: [f64; 3] = [1.0, -0.5, 0.8];
const BASELINE: [f64; 2] = [0.5, -0.4];

fn feed(calibrator: &mut Calibrator<f32, 256>, rotation: [f64; 3], seeds: core::ops::Range<u64>) {
    let truth = rig(rotation, BASELINE);
    for seed in seeds {
        take(calibrator, &correspondences(&truth, 250, 0.5, seed)).unwrap();
    }
}

fn locked() -> Calibrator<f32, 256> {
    let mut calibrator = robust();
    feed(&mut calibrator, ROTATION, 0..6);
    assert_eq!(calibrator.state(), State::Locked);
    calibrator
}

#[test]
fn only_a_locked_estimate_is_applied() {
    let mut calibrator = robust::<f32>();
    assert_eq!(calibrator.apply(), Err(ApplyError::NoProposal));
    feed(&mut calibrator, ROTATION, 0..1);
    assert_eq!(calibrator.apply(), Err(ApplyError::NotLocked(State::Acquiring)));
    feed(&mut calibrator, ROTATION, 1..6);
    let applied = calibrator.apply().unwrap();
    assert_eq!(applied.extrinsics, calibrator.proposal().unwrap().extrinsics);
    assert_eq!((calibrator.in_use(), calibrator.generation()), (&applied.extrinsics, 1));

    // A knock that is not yet confirmed.
    let knocked = [1.3, -0.5, 0.8];
    feed(&mut calibrator, knocked, 10..11);
    assert_eq!(calibrator.apply(), Err(ApplyError::NotLocked(State::Suspect)));
    assert_eq!((calibrator.in_use(), calibrator.generation()), (&applied.extrinsics, 1));
}

#[test]
fn applying_the_same_again_changes_no_generation() {
    let mut calibrator = locked();
    let applied = calibrator.apply().unwrap();
    assert_eq!((calibrator.apply(), calibrator.generation()), (Ok(applied), 1));
    feed(&mut calibrator, ROTATION, 20..21);
    let anew = calibrator.apply().unwrap();
    assert_ne!(anew, applied);
    assert_eq!(calibrator.generation(), 2);
}

#[test]
fn undo_goes_back_one_change_once_and_keeps_the_estimate() {
    let mut calibrator = locked();
    assert_eq!(calibrator.undo(), Err(ApplyError::NothingToUndo));
    let first = calibrator.apply().unwrap();
    // The same again is no change.
    calibrator.apply().unwrap();
    feed(&mut calibrator, ROTATION, 20..25);
    let second = calibrator.apply().unwrap();
    let proposal = calibrator.proposal();
    assert_eq!(calibrator.undo(), Ok(first));
    assert_eq!((calibrator.in_use(), calibrator.generation()), (&first.extrinsics, 3));
    assert_eq!(calibrator.proposal(), proposal);
    assert_eq!(calibrator.undo(), Err(ApplyError::NothingToUndo));
    assert_eq!((calibrator.apply(), calibrator.generation()), (Ok(second), 4));
    assert_eq!(calibrator.undo(), Ok(first));
}

#[test]
fn a_frozen_calibrator_solves_and_judges_and_changes_nothing() {
    let mut calibrator = locked();
    calibrator.apply().unwrap();
    feed(&mut calibrator, ROTATION, 20..21);
    calibrator.set_frozen(true);
    assert!(calibrator.is_frozen());
    let before = (calibrator.proposal(), *calibrator.in_use(), calibrator.generation());
    let scene = correspondences(&rig(ROTATION, BASELINE), 250, 0.5, 30);
    assert_eq!(take(&mut calibrator, &scene), Err(Rejection::Refused(Refusal::Frozen)));
    assert_eq!(calibrator.apply(), Err(ApplyError::Frozen));
    assert_eq!(calibrator.undo(), Err(ApplyError::Frozen));
    let health = calibrator.health().unwrap();
    assert_eq!(health.rejection, Some(Rejection::Refused(Refusal::Frozen)));
    assert_eq!((calibrator.proposal(), *calibrator.in_use(), calibrator.generation()), before);

    calibrator.set_frozen(false);
    assert!(!calibrator.is_frozen());
    take(&mut calibrator, &scene).unwrap();
    assert!(calibrator.apply().is_ok() && calibrator.undo().is_ok());
}

#[test]
fn a_frozen_calibrator_takes_the_report_once_it_is_let_go() {
    let mut calibrator = locked();
    fill(&mut calibrator, &correspondences(&rig(ROTATION, BASELINE), 250, 0.5, 30));
    calibrator.solve_pair().unwrap();
    calibrator.set_frozen(true);
    assert_eq!(calibrator.fuse(), Err(Refusal::Frozen));
    calibrator.set_frozen(false);
    assert!(calibrator.fuse().is_ok());
}

#[test]
fn a_reset_returns_to_the_factory_and_forgets_the_rest() {
    let factory = rig::<f32>([0.5, 0.0, 0.0], [0.0, 0.3]);
    let mut calibrator = robust::<f32>();
    calibrator.set_factory(factory);
    assert_eq!((calibrator.in_use(), calibrator.generation()), (&factory, 1));
    feed(&mut calibrator, ROTATION, 0..6);
    calibrator.apply().unwrap();
    calibrator.set_frozen(true);
    calibrator.reset();
    assert_eq!((calibrator.in_use(), calibrator.generation()), (&factory, 3));
    assert_eq!((calibrator.state(), calibrator.proposal()), (State::Acquiring, None));
    assert!(!calibrator.is_frozen() && calibrator.batch().pairs().is_empty());
    assert_eq!(calibrator.undo(), Err(ApplyError::NothingToUndo));
    assert_eq!(calibrator.advance_pair(), Err(PairError::NotBegun));
    // As new: the same pairs give the same bits.
    let mut fresh = robust::<f32>();
    fresh.set_factory(factory);
    for calibrator in [&mut calibrator, &mut fresh] {
        feed(calibrator, ROTATION, 40..46);
    }
    assert_eq!(calibrator.proposal(), fresh.proposal());
    assert_eq!(calibrator.health(), fresh.health());
}

#[test]
fn by_configuration_every_pair_of_a_locked_estimate_is_applied_at_once() {
    let mut calibrator = with::<f32>(Config::robust().with_automatic_apply(true));
    let mut generation = 0;
    for seed in 0..12 {
        feed(&mut calibrator, ROTATION, seed..seed + 1);
        let proposal = calibrator.proposal().unwrap();
        if calibrator.state() == State::Locked {
            generation += 1;
            assert_eq!(calibrator.in_use(), &proposal.extrinsics);
        } else {
            assert_eq!(calibrator.in_use(), &Extrinsics::SIDE_BY_SIDE);
        }
        assert_eq!(calibrator.generation(), generation);
    }
    assert!(generation >= 8);

    // A knock: nothing new until it is confirmed.
    let knocked = [1.3, -0.5, 0.8];
    let before = *calibrator.in_use();
    feed(&mut calibrator, knocked, 20..22);
    assert_eq!((calibrator.in_use(), calibrator.generation()), (&before, generation));
    feed(&mut calibrator, knocked, 22..23);
    assert_eq!(calibrator.in_use(), &calibrator.proposal().unwrap().extrinsics);
    assert_eq!(calibrator.generation(), generation + 1);
    assert_eq!(calibrator.undo().unwrap().extrinsics, before);
}
