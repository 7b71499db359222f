//! Application of estimates: when it is refused, and how it is undone.

use crate::api::disturbed::garbage;
use crate::api::presets::{calibrated, robust};
use crate::api::scene::{correspondences, rig, take};
use stereo_selfcal::{ApplyError, Calibrator, Rejection, State};

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
    assert_eq!(
        (&calibrator.in_use().extrinsics, calibrator.in_use().generation),
        (&applied.extrinsics, 1)
    );

    // After a knock, which is not confirmed yet.
    let knocked = [1.3, -0.5, 0.8];
    feed(&mut calibrator, knocked, 10..11);
    assert_eq!(calibrator.apply(), Err(ApplyError::NotLocked(State::Suspect)));
    assert_eq!(
        (&calibrator.in_use().extrinsics, calibrator.in_use().generation),
        (&applied.extrinsics, 1)
    );
}

#[test]
fn applying_the_same_again_changes_no_generation() {
    let mut calibrator = locked();
    let applied = calibrator.apply().unwrap();
    assert_eq!((calibrator.apply(), calibrator.in_use().generation), (Ok(applied), 1));
    feed(&mut calibrator, ROTATION, 20..21);
    let anew = calibrator.apply().unwrap();
    assert_ne!(anew, applied);
    assert_eq!(calibrator.in_use().generation, 2);
}

#[test]
fn undo_goes_back_one_change_once_and_keeps_the_estimate() {
    let mut calibrator = locked();
    assert_eq!(calibrator.undo(), Err(ApplyError::NothingToUndo));
    let first = calibrator.apply().unwrap();
    // Applying the same estimate again changes nothing.
    calibrator.apply().unwrap();
    feed(&mut calibrator, ROTATION, 20..25);
    let second = calibrator.apply().unwrap();
    let proposal = calibrator.proposal();
    assert_eq!(calibrator.undo().unwrap().extrinsics, first.extrinsics);
    assert_eq!(
        (&calibrator.in_use().extrinsics, calibrator.in_use().generation),
        (&first.extrinsics, 3)
    );
    assert_eq!(calibrator.proposal(), proposal);
    assert_eq!(calibrator.undo(), Err(ApplyError::NothingToUndo));
    let again = calibrator.apply().unwrap();
    assert_eq!((again.extrinsics, again.generation), (second.extrinsics, 4));
    assert_eq!(calibrator.undo().unwrap().extrinsics, first.extrinsics);
}

#[test]
fn a_frozen_calibrator_solves_and_judges_and_changes_nothing() {
    let mut calibrator = locked();
    calibrator.apply().unwrap();
    feed(&mut calibrator, ROTATION, 20..21);
    calibrator.set_frozen(true);
    let before =
        (calibrator.proposal(), calibrator.in_use().extrinsics, calibrator.in_use().generation);
    let scene = correspondences(&rig(ROTATION, BASELINE), 250, 0.5, 30);
    assert_eq!(take(&mut calibrator, &scene), Err(Rejection::Frozen));
    assert_eq!(calibrator.apply(), Err(ApplyError::Frozen));
    assert_eq!(calibrator.undo(), Err(ApplyError::Frozen));
    assert_eq!(
        (calibrator.proposal(), calibrator.in_use().extrinsics, calibrator.in_use().generation),
        before
    );

    calibrator.set_frozen(false);
    take(&mut calibrator, &scene).unwrap();
    assert!(calibrator.apply().is_ok() && calibrator.undo().is_ok());
}

#[test]
fn pairs_that_fail_while_frozen_count_against_nothing() {
    let mut calibrator = locked();
    let before = calibrator.proposal();
    calibrator.set_frozen(true);
    for seed in 0..12 {
        assert!(take(&mut calibrator, &garbage(250, seed)).is_err());
        assert_eq!(calibrator.proposal(), before, "{seed}");
    }
    calibrator.set_frozen(false);
    assert_eq!(calibrator.state(), State::Locked);
}

#[test]
fn a_reset_returns_to_the_factory_and_forgets_the_rest() {
    let factory = rig::<f32>([0.5, 0.0, 0.0], [0.0, 0.3]);
    let mut calibrator = calibrated(factory);
    assert_eq!((&calibrator.in_use().extrinsics, calibrator.in_use().generation), (&factory, 0));
    feed(&mut calibrator, ROTATION, 0..6);
    calibrator.apply().unwrap();
    calibrator.set_frozen(true);
    calibrator.reset();
    assert_eq!((&calibrator.in_use().extrinsics, calibrator.in_use().generation), (&factory, 2));
    assert_eq!((calibrator.state(), calibrator.proposal()), (State::Acquiring, None));
    assert!(calibrator.batch().matches().is_empty());
    assert_eq!(calibrator.undo(), Err(ApplyError::NothingToUndo));
    // The calibrator is as new: the same pairs give the same bits.
    let mut fresh = calibrated(factory);
    for calibrator in [&mut calibrator, &mut fresh] {
        feed(calibrator, ROTATION, 40..46);
    }
    assert_eq!(calibrator.proposal(), fresh.proposal());
    assert_eq!(calibrator.verdict(), fresh.verdict());
}
