//! What goes over the simulated bus comes to the same estimate as what is fed directly.

#[path = "../src/sim/matcher.rs"]
mod matcher;

use firmware_sim::{App, Event, solve_and_fuse, start};
use host_tests::dataset::{Dataset, Match};
use matcher::SimMatcher;
use stereo_selfcal::link::{Decoder, Event as LinkEvent};
use stereo_selfcal::{Correspondence, Extrinsics};

/// As the wire carries it, by other arithmetic than the frame's.
fn quantised(m: &Match) -> Correspondence<f32> {
    let exact: Correspondence<f32> = m.correspondence();
    let px = |x: f32| (x * 256.0).round() / 256.0;
    Correspondence {
        left: exact.left.map(px),
        right: exact.right.map(px),
        score: (exact.score * 65_535.0).round() / 65_535.0,
        grid_step: 1.0 / 256.0,
    }
}

fn bits(extrinsics: &Extrinsics<f32>) -> Vec<u32> {
    let t = extrinsics.translation().into_inner();
    extrinsics.rotation_row_major().iter().chain(t.iter()).map(|x| x.to_bits()).collect()
}

#[test]
fn the_fused_estimate_over_the_bus_is_that_of_direct_feeding_bit_for_bit() {
    let set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
    let [mut direct, mut over_bus] = [(), ()].map(|()| Box::new(start(set.cameras().unwrap())));
    let matcher = SimMatcher::new([set.meta.width, set.meta.height]);
    let mut app = App::new(matcher.driver(), &mut over_bus);
    for (sequence, pair) in (0..).zip(&set.pairs) {
        for m in pair {
            direct.push(&quantised(m)).unwrap();
        }
        let batch = direct.batch().clone();
        let before = direct.state();
        let (report, fused) = solve_and_fuse(&mut direct).unwrap();
        let health = direct.health();
        direct.clear_pair();

        matcher.send(sequence, pair);
        let offered = pair.len();
        let read = std::iter::repeat_with(|| app.poll()).find(|event| *event != Ok(Event::Reading));
        assert_eq!(read, Some(Ok(Event::Frame { sequence, offered, taken: offered })));
        assert_eq!(app.calibrator().batch().pairs(), batch.pairs());
        // The last one ends the pair.
        for _ in 1..report.passes {
            assert_eq!(app.poll(), Ok(Event::Pass));
        }
        let Ok(Event::Pair(seen)) = app.poll() else { panic!("pair {sequence} has not ended") };
        assert_eq!((seen.outcome, seen.health), (Ok((report, fused)), health));
        let after = direct.state();
        if after != before {
            assert_eq!(app.poll(), Ok(Event::StateChanged { before, after }));
        }
        assert_eq!(app.poll(), Ok(Event::Idle));
        let [a, b] = [direct.proposal(), app.calibrator().proposal()].map(Option::unwrap);
        assert_eq!(bits(&a.extrinsics), bits(&b.extrinsics), "after pair {sequence}");
    }
    assert_eq!(app.calibrator().proposal().unwrap().pairs, 13);
}

/// The grid steps that a receiver is told of.
fn steps_received(steps: &[f64]) -> Vec<f32> {
    let at = |&step: &f64| Match { ul: 100.0, vl: 90.0, ur: 80.0, vr: 90.0, score: 1.0, step };
    let pair: Vec<Match> = steps.iter().map(at).collect();
    let sent = SimMatcher::new([640, 480]).frame(0, &pair);
    let (mut bytes, mut decoder) = (sent.as_slice(), Decoder::new());
    let events = std::iter::from_fn(|| decoder.next(&mut bytes));
    let steps = events.filter_map(|event| match event {
        LinkEvent::Match(c) => Some(c.grid_step),
        _ => None,
    });
    steps.collect()
}

#[test]
fn one_grid_comes_over_the_bus_as_it_is_and_none_as_that_of_the_wire() {
    for step in [1.0_f32, 0.5, 0.25, 1.0 / 256.0, 40.0] {
        assert_eq!(steps_received(&[step.into(); 2]), [step; 2]);
    }
    assert_eq!(steps_received(&[0.0, 0.0]), [1.0 / 256.0; 2]);
    assert_eq!(steps_received(&[]), [0.0_f32; 0]);
}

#[test]
fn a_pyramid_comes_over_the_bus_within_2_percent() {
    for (ratio, levels) in [(1.2_f64, 8), (2.0, 5), (1.5, 3)] {
        let steps: Vec<f64> = (0..levels).rev().map(|level| ratio.powi(level)).collect();
        let received = steps_received(&steps);
        assert_eq!(received.len(), steps.len());
        for (sent, received) in steps.iter().zip(received) {
            assert!((f64::from(received) / sent - 1.0).abs() < 0.02, "{received} for {sent}");
        }
    }
}
