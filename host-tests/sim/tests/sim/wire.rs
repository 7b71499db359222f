//! Data sets over the link: after a faulty wire the calibrator is bit-identical to one that gets only the surviving
//! frames.

use rigs::data::{Dataset, Match};
use sim::wire::{Faults, FaultyWire, Frame, FrameReader, Sender, Sent, counted, quantised};
use stereo_selfcal::link::{Decoder, Received};
use stereo_selfcal::{Calibrator, Config, FactoryCalibration};

type Controller = Calibrator<f32, 256>;

fn set(name: &str) -> Dataset {
    Dataset::load(&Dataset::shipped().join(name)).unwrap()
}

fn controller(set: &Dataset) -> Box<Controller> {
    let factory = FactoryCalibration::guess(set.cameras().unwrap());
    Box::new(Controller::new(Config::robust(), &factory))
}

fn solve_and_fuse(controller: &mut Controller) {
    let _ = controller.solve_pair();
    let _ = controller.apply();
}

/// Snapshot of the calibrator's state.
fn memory(controller: &Controller) -> Vec<u8> {
    controller.snapshot().to_vec()
}

#[test]
fn the_outcome_over_a_faulty_wire_matches_the_surviving_frames_bit_for_bit() {
    let set = set("opencv_chess_sift");
    let sender = Sender::of(&set).unwrap();
    let one_in_a_hundred = Faults { damaged: 0.01, dropped: 0.01, ..Faults::NONE };
    let ([mut damaged, mut dropped, mut taken], mut applied) = ([0; 3], 0);
    for seed in 0..20 {
        let mut wire = FaultyWire::new(one_in_a_hundred, seed);
        let mut bytes = Vec::new();
        // All pairs three times, for more faults.
        let pairs: Vec<_> = set.pairs.iter().cycle().take(39).collect();
        let send = |(sequence, pair): (u32, &&Vec<Match>)| {
            let (frame, left_out) = sender.frame(sequence, pair);
            assert_eq!(left_out, 0);
            wire.send(&frame, &mut bytes)
        };
        let sent: Vec<Sent> = (0..).zip(&pairs).map(send).collect();
        let mut direct = controller(&set);
        let mut survivors = 0;
        for frame in FrameReader::new(&bytes[..]) {
            let sequence = frame.unwrap().header.sequence as usize;
            assert_eq!(sent[sequence], Sent::Intact);
            survivors += 1;
            for m in pairs[sequence] {
                direct.push(&quantised(m)).unwrap();
            }
            solve_and_fuse(&mut direct);
        }
        let count = |fate| sent.iter().filter(|sent| **sent == fate).count();
        let now = count(Sent::Damaged);
        // A damaged frame may take the start of the next one.
        let lost = count(Sent::Intact) - survivors;
        assert!(lost <= now, "seed {seed}: {lost} lost");
        (damaged, dropped, taken) = (damaged + now, dropped + count(Sent::Dropped), taken + lost);
        let (mut linked, mut decoder) = (controller(&set), Decoder::new());
        let (mut rest, mut received) = (&bytes[..], 0);
        while let Some(Received { .. }) = decoder.feed(&mut rest, &mut *linked).unwrap() {
            received += 1;
            solve_and_fuse(&mut linked);
        }
        assert_eq!(received, survivors, "seed {seed}");
        assert_eq!(memory(&linked), memory(&direct), "seed {seed}");
        assert_eq!(&linked.in_use().extrinsics, &direct.in_use().extrinsics, "seed {seed}");
        applied += linked.in_use().generation;
    }
    println!(
        "{damaged} damaged, {dropped} dropped, {taken} more lost of 780 frames; 20 outcomes the same"
    );
    assert!(damaged > 3 && dropped > 3 && applied >= 20, "{damaged} {dropped} {applied}");
}

#[test]
fn a_recording_equals_the_data_set_to_the_resolution_of_the_wire() {
    for name in Dataset::SHIPPED {
        let set = set(name);
        let sender = Sender::of(&set).unwrap();
        let frames = (0..).zip(&set.pairs).flat_map(|(i, pair)| sender.frame(i, pair).0);
        let bytes: Vec<u8> = frames.collect();
        let mut reader = FrameReader::new(&bytes[..]);
        let pair = |frame: std::io::Result<Frame>| frame.unwrap().pair(&set.meta).unwrap();
        let back: Vec<_> = reader.by_ref().map(pair).collect();
        assert_eq!(counted(reader.counters()), format!("{} whole frames", set.pairs.len()));
        assert_eq!(back.len(), set.pairs.len());
        for (sent, seen) in set.pairs.iter().zip(&back) {
            assert_eq!(sent.len(), seen.len());
            for (a, b) in sent.iter().zip(seen) {
                let apart = [a.ul - b.ul, a.vl - b.vl, a.ur - b.ur, a.vr - b.vr];
                assert!(apart.iter().all(|d| d.abs() <= 0.54 / 256.0), "{a:?} {b:?}");
                let step = a.step.max(1.0 / 256.0);
                assert!((b.step / step - 1.0).abs() < 0.06, "{a:?} {b:?}");
            }
        }
    }
}

/// The grid steps that the matches of a frame have after the link, px.
fn steps_received(steps: &[f64]) -> Vec<f32> {
    let at = |&step: &f64| Match { ul: 100.0, vl: 90.0, ur: 80.0, vr: 90.0, score: 1.0, step };
    let pair: Vec<Match> = steps.iter().map(at).collect();
    let sender = Sender::new([640, 480], steps.iter().copied()).unwrap();
    let bytes = sender.frame(0, &pair).0;
    let mut frames: Vec<_> = FrameReader::new(&bytes[..]).collect();
    let (Some(Ok(frame)), true) = (frames.pop(), frames.is_empty()) else { panic!("{frames:?}") };
    frame.matches.iter().map(|c| c.grid_step).collect()
}

#[test]
fn a_grid_keeps_its_step_and_continuous_coordinates_get_the_step_of_the_wire() {
    for step in [1.0_f32, 0.5, 0.25, 1.0 / 256.0, 40.0] {
        assert_eq!(steps_received(&[step.into(); 2]), [step; 2]);
    }
    assert_eq!(steps_received(&[0.0, 0.0]), [1.0 / 256.0; 2]);
    assert_eq!(steps_received(&[]), [0.0_f32; 0]);
}

#[test]
fn every_level_of_a_pyramid_keeps_its_grid_step_within_2_percent() {
    for (ratio, levels) in [(1.2_f64, 8), (2.0, 5), (1.5, 3)] {
        let steps: Vec<f64> = (0..levels).rev().map(|level| ratio.powi(level)).collect();
        let received = steps_received(&steps);
        assert_eq!(received.len(), steps.len());
        for (sent, received) in steps.iter().zip(received) {
            assert!((f64::from(received) / sent - 1.0).abs() < 0.02, "{received} for {sent}");
        }
    }
    let error = Sender::new([640, 480], [1.0, 1.37, 29.0, 250.0, 255.0]).unwrap_err();
    assert!(error.to_string().contains("no pyramid has"), "{error}");
}
