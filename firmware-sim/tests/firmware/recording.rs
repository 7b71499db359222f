//! The recording of the build script equals that of the simulated matcher.

use firmware_sim::recording::{FRAMES, NAME, PAIRS, ReplayBus, cameras, truth};
use firmware_sim::{App, Event, start};
use rigs::data::Dataset;
use sim::wire::Sender;
use stereo_selfcal::link::FpgaMatcher;
use test_support::wire::Wire;

fn set() -> Dataset {
    Dataset::load(&Dataset::shipped().join(NAME)).unwrap()
}

/// The frames of the simulated matcher.
fn sent() -> Vec<u8> {
    let set = set();
    let sender = Sender::of(&set).unwrap();
    (0..).zip(&set.pairs).flat_map(|(i, pair)| sender.frame(i, pair).0).collect()
}

#[test]
fn the_frames_match_the_simulated_matcher_byte_for_byte() {
    assert!(sent() == FRAMES);
}

#[test]
fn cameras_and_truth_match_the_data_set() {
    let set = set();
    assert_eq!(PAIRS as usize, set.pairs.len());
    assert_eq!(cameras().unwrap(), set.cameras().unwrap());
    assert_eq!(truth().unwrap(), set.truth().unwrap());
}

#[test]
fn the_recording_and_the_simulated_matcher_lead_to_the_same_estimate() {
    let mut calibrators = [(), ()].map(|()| Box::new(start(cameras().unwrap())));
    let [from_recording, from_matcher] = &mut calibrators;
    let bus = ReplayBus::new(FRAMES);
    let mut app = App::new(bus.driver(), from_recording);
    while app.poll().unwrap() != Event::Idle {}
    let wire = Wire::default();
    wire.send(sent());
    let mut app = App::new(FpgaMatcher::new(wire.clone(), wire), from_matcher);
    while app.poll().unwrap() != Event::Idle {}
    let [a, b] = calibrators.map(|calibrator| calibrator.proposal().unwrap());
    assert_eq!(a, b);
}
