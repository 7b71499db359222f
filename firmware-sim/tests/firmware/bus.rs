//! Matches over the simulated bus lead to the same estimate as matches pushed directly.

use firmware_sim::{App, Event, solve_and_fuse, start};
use rigs::data::Dataset;
use sim::wire::{Sender, quantised};
use stereo_selfcal::Extrinsics;
use stereo_selfcal::link::FpgaMatcher;
use test_support::wire::Wire;

fn bits(extrinsics: &Extrinsics<f32>) -> Vec<u32> {
    let t = extrinsics.translation().into_inner();
    extrinsics.rotation_row_major().iter().chain(t.iter()).map(|x| x.to_bits()).collect()
}

#[test]
fn the_estimate_over_the_bus_is_bit_identical_to_that_of_direct_pushes() {
    let set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
    let [mut direct, mut over_bus] = [(), ()].map(|()| Box::new(start(set.cameras().unwrap())));
    let (sender, wire) = (Sender::of(&set).unwrap(), Wire::default());
    let mut app = App::new(FpgaMatcher::new(wire.clone(), wire.clone()), &mut over_bus);
    for (sequence, pair) in (0..).zip(&set.pairs) {
        for m in pair {
            direct.push(&quantised(m)).unwrap();
        }
        let batch = direct.batch().clone();
        let before = direct.state();
        let (report, fused) = solve_and_fuse(&mut direct).unwrap();
        let verdict = *direct.verdict();

        wire.send(sender.frame(sequence, pair).0);
        let offered = pair.len();
        let read = std::iter::repeat_with(|| app.poll()).find(|event| *event != Ok(Event::Reading));
        assert_eq!(read, Some(Ok(Event::Frame { sequence, offered, taken: offered })));
        assert_eq!(app.calibrator().batch().matches(), batch.matches());
        // Each call takes one pass; two more calls fuse and judge.
        for _ in 0..=report.passes {
            assert_eq!(app.poll(), Ok(Event::Pass));
        }
        let Ok(Event::Pair(seen)) = app.poll() else { panic!("pair {sequence} has not ended") };
        assert_eq!((seen.outcome, seen.verdict), (Ok((report, fused)), verdict));
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
