//! Time of each stage on this host, `f32`, 256 matches of a near scene, 30 % of them wrong.
//!
//! ```sh
//! cargo bench -p host-tests --bench stages
//! cargo bench -p host-tests --bench stages --features simd
//! ```

use divan::{Bencher, black_box};
use host_tests::data::{Dataset, Match};
use host_tests::synth::{ScenarioKind, Scene, five_degrees_off};
use host_tests::wire::Sender;
use stereo_selfcal::link::{Decoder, Event};
use stereo_selfcal::{Calibrator, Config, Correspondence};

/// Pairs that lock a calibrator.
const LOCKING: usize = 20;

type Calibrator256 = Calibrator<f32, 256>;

fn main() {
    divan::main();
}

/// A generated recording: pairs that lock, then one that is measured.
fn recording() -> Dataset {
    let scene = Scene { rig: five_degrees_off(), outliers: 0.3, ..ScenarioKind::Near.scene() };
    scene.dataset(LOCKING + 1, 1).expect("the scene can be seen")
}

fn matches(set: &Dataset, pair: usize) -> Vec<Correspondence<f32>> {
    set.pairs[pair].iter().map(Match::correspondence).collect()
}

/// A calibrator with a pair in its batch, after so many fused pairs.
fn calibrator(config: Config, fused: usize) -> Box<Calibrator256> {
    let set = recording();
    let mut calibrator = Box::new(Calibrator256::new(config));
    calibrator.set_cameras(set.cameras().expect("generated cameras are valid"));
    for pair in 0..=fused {
        calibrator.clear_pair();
        for m in matches(&set, pair) {
            calibrator.push(&m).expect("generated matches are in the image");
        }
        if pair < fused {
            calibrator.solve_pair().expect("the pair has an answer");
            let _ = calibrator.fuse();
        }
    }
    calibrator
}

/// Pixels to rays through a lens of five coefficients, both sides of every match.
#[divan::bench]
fn undistort(bencher: Bencher) {
    let chess =
        Dataset::load(&Dataset::shipped().join("opencv_chess_sift")).expect("it is shipped");
    let cameras = chess.cameras::<f32>().expect("its cameras are valid");
    let pair: Vec<_> = chess.pairs.iter().flatten().map(Match::correspondence).take(256).collect();
    bencher.bench(|| pair.iter().filter_map(|m| cameras.rays(black_box(m)).ok()).count());
}

/// One pass of a search and its step.
#[divan::bench]
fn pass(bencher: Bencher) {
    let mut begun = calibrator(Config::robust(), 0);
    begun.begin_pair().expect("the pair has matches");
    bencher.with_inputs(|| begun.clone()).bench_local_refs(|c| c.advance_pair().is_ok());
}

/// A pair far from the optimum, to its report.
#[divan::bench]
fn solve_acquiring(bencher: Bencher) {
    let fresh = calibrator(Config::robust(), 0);
    bencher.with_inputs(|| fresh.clone()).bench_local_refs(|c| c.solve_pair());
}

/// A pair of a locked rig.
#[divan::bench]
fn solve_locked(bencher: Bencher) {
    let locked = calibrator(Config::robust(), LOCKING);
    bencher.with_inputs(|| locked.clone()).bench_local_refs(|c| c.solve_pair());
}

/// A pair by the paper's preset.
#[divan::bench]
fn solve_paper(bencher: Bencher) {
    let fresh = calibrator(Config::paper(), 0);
    bencher.with_inputs(|| fresh.clone()).bench_local_refs(|c| c.solve_pair());
}

/// Fusion of a solved pair.
#[divan::bench]
fn fuse(bencher: Bencher) {
    let mut locked = calibrator(Config::robust(), LOCKING);
    locked.solve_pair().expect("the pair has an answer");
    bencher.with_inputs(|| locked.clone()).bench_local_refs(|c| c.fuse());
}

/// A frame from bytes to matches.
#[divan::bench]
fn decode(bencher: Bencher) {
    let set = recording();
    let sender = Sender::of(&set).expect("the matches are on no grid");
    let (frame, _) = sender.frame(1, &set.pairs[0]);
    bencher.with_inputs(Decoder::new).bench_local_refs(|decoder| {
        let mut bytes = black_box(&frame[..]);
        let mut seen = 0;
        while let Some(event) = decoder.next(&mut bytes) {
            seen += usize::from(matches!(event, Event::Match(_)));
        }
        seen
    });
}
