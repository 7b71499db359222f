//! The history of a rig that is calibrated, knocked and calibrated again.

use crate::api::presets::robust;
use crate::api::scene::{correspondences, rig, take};
use stereo_selfcal::outcome::{Change, Event, History};
use stereo_selfcal::{Calibrator, State};

type Ring = History<f32, 32>;

/// Takes a pair as a vehicle does, and notes it; the clock counts 100 ms a pair.
fn drive(rig_: &mut Calibrator<f32, 256>, history: &mut Ring, rotation: [f64; 3], pair: u32) {
    let matches = correspondences(&rig(rotation, [0.5, -0.4]), 250, 0.5, pair.into());
    let _ = take(rig_, &matches);
    if rig_.verdict().should_apply {
        let _ = rig_.apply();
    }
    let time = u64::from(pair) * 100;
    let _ = history.note(time, pair, rig_.verdict(), rig_.in_use().generation);
}

#[test]
fn a_history_tells_when_a_rig_was_calibrated_knocked_and_calibrated_again() {
    let (mut calibrator, mut history) = (robust::<f32>(), Ring::new());
    for pair in 0..40 {
        let pitch = if pair < 20 { 1.0 } else { 1.3 };
        drive(&mut calibrator, &mut history, [pitch, -0.5, 0.8], pair);
    }
    let events: Vec<&Event<f32>> = history.events().collect();
    assert!(events.iter().all(|event| event.time == u64::from(event.pair) * 100));
    let first = |changed: Change, from: u32| {
        events.iter().find(|event| event.pair >= from && event.changes.contains(changed)).unwrap()
    };
    let (locked, applied) = (first(Change::State, 0), first(Change::Generation, 0));
    assert_eq!((locked.pair, locked.verdict.state), (3, State::Locked));
    assert_eq!((applied.pair, applied.generation), (3, 1));
    let knocked = first(Change::State, 20);
    assert_eq!((knocked.pair, knocked.verdict.state), (20, State::Suspect));
    let again = first(Change::Generation, 20);
    assert_eq!((again.pair, again.generation), (22, 2));
    let text = again.to_string();
    assert!(
        text.starts_with("pair 22, ") && text.contains(": locked, generation 2, rows "),
        "{text}"
    );
    assert!(again.changes.to_string().contains("generation"), "{text}");
    let last = events.last().unwrap();
    assert_eq!((last.verdict.state, last.generation), (State::Locked, 2));
    assert_eq!(last.verdict.reasons, calibrator.verdict().reasons);
}

#[test]
fn the_events_of_a_still_rig_end() {
    let (mut calibrator, mut history) = (robust::<f32>(), Ring::new());
    (0..30).for_each(|pair| drive(&mut calibrator, &mut history, [1.0, -0.5, 0.8], pair));
    let total = history.total();
    (30..60).for_each(|pair| drive(&mut calibrator, &mut history, [1.0, -0.5, 0.8], pair));
    assert!((1..10).contains(&total) && history.total() == total, "{total} {}", history.total());
}
