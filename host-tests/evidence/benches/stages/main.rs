//! Time of each stage on this host, `f32`, 256 matches of a near scene, 30 % of them wrong.
//!
//! ```sh
//! cargo bench -p evidence --bench stages
//! ```

use std::hint::black_box;
use std::time::Instant;

use rigs::data::{Dataset, Match};
use sim::stats::median;
use sim::synth::{ScenarioKind, Scene, five_degrees_off};
use sim::wire::Sender;
use stereo_selfcal::link::{Decoder, Event};
use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{Calibrator, Config, Correspondence, Extrinsics, FactoryCalibration};

/// Pairs that lock a calibrator.
const LOCKING: usize = 20;

/// Timed runs of a stage.
const RUNS: usize = 1000;

type Calibrator256 = Calibrator<f32, 256>;

fn main() {
    undistort();
    let fresh = calibrator(0);
    let mut begun = fresh.clone();
    assert_eq!(begun.advance_pair(), None, "the pair has matches");
    stage("one pass and its step", || begun.clone(), |c| c.advance_pair());
    stage("a pair far from the optimum", || fresh.clone(), |c| c.solve_pair());
    let locked = calibrator(LOCKING);
    stage("a pair of a locked rig", || locked.clone(), |c| c.solve_pair());
    let pair = matches(&recording(), LOCKING);
    stage("all calls of that pair", || locked.clone(), |c| all_calls(c, &pair));
    let paper = published();
    stage("a pair by the published method", || paper.clone(), |c| c.solve_pair());
    let solved = solved(locked);
    stage("fusion of a solved pair", || solved.clone(), |c| c.advance_pair());
    decode();
}

/// All calls of `Calibrator.fuse` in Python, for comparison with its time.
fn all_calls(calibrator: &mut Calibrator256, pair: &[Correspondence<f32>]) -> bool {
    let outcome = calibrator.take_pair(pair.iter().copied());
    let _ = black_box((calibrator.proposal(), calibrator.details()));
    outcome.fused.is_ok()
}

/// Prints the median time of a stage. Its input is made before the clock starts.
fn stage<I, O>(name: &str, input: impl Fn() -> I, work: impl Fn(&mut I) -> O) {
    let us = (0..RUNS).map(|_| {
        let mut input = black_box(input());
        let start = Instant::now();
        black_box(work(&mut input));
        start.elapsed().as_secs_f64() * 1e6
    });
    println!("{name:<32} {:>9.2} us", median(us).unwrap_or(f64::NAN));
}

/// A generated recording: pairs that lock, then one to measure.
fn recording() -> Dataset {
    let scene = Scene { rig: five_degrees_off(), outliers: 0.3, ..ScenarioKind::Near.scene() };
    scene.dataset(LOCKING + 1, 1).expect("the scene can be seen")
}

fn matches(set: &Dataset, pair: usize) -> Vec<Correspondence<f32>> {
    set.pairs[pair].iter().map(Match::correspondence).collect()
}

/// A calibrator with a pair in its batch, after so many fused pairs.
fn calibrator(fused: usize) -> Box<Calibrator256> {
    let set = recording();
    let cameras = set.cameras().expect("generated cameras are valid");
    let factory = FactoryCalibration::guess(cameras);
    let mut calibrator = Box::new(Calibrator256::new(Config::robust(), &factory));
    for pair in 0..=fused {
        calibrator.discard_pair();
        for m in matches(&set, pair) {
            calibrator.push(&m).expect("generated matches are in the image");
        }
        if pair < fused {
            calibrator.solve_pair().pair.expect("the pair has an answer");
        }
    }
    calibrator
}

/// The published method with a pair in its batch.
fn published() -> Box<PaperCalibrator<f32, 256>> {
    let set = recording();
    let cameras = set.cameras().expect("generated cameras are valid");
    let start = Extrinsics::SIDE_BY_SIDE;
    let mut calibrator = Box::new(PaperCalibrator::new(Settings::DEFAULT, cameras, start));
    for m in matches(&set, 0) {
        calibrator.push(&m).expect("generated matches are in the image");
    }
    calibrator
}

/// The calibrator before the last step of its pair.
fn solved(mut calibrator: Box<Calibrator256>) -> Box<Calibrator256> {
    let mut before = calibrator.clone();
    while calibrator.advance_pair().is_none() {
        before.clone_from(&calibrator);
    }
    before
}

/// Pixels to rays through a lens of five coefficients, both sides of every match.
fn undistort() {
    let chess =
        Dataset::load(&Dataset::shipped().join("opencv_chess_sift")).expect("it is shipped");
    let cameras = chess.cameras::<f32>().expect("its cameras are valid");
    let pair: Vec<_> = chess.pairs.iter().flatten().map(Match::correspondence).take(256).collect();
    let rays = |pair: &mut &Vec<_>| pair.iter().filter_map(|m| cameras.rays(m).ok()).count();
    stage("256 matches through a lens", || &pair, rays);
}

/// A frame from bytes to matches.
fn decode() {
    let set = recording();
    let sender = Sender::of(&set).expect("the matches are on no grid");
    let (frame, _) = sender.frame(1, &set.pairs[0]);
    let matches = |decoder: &mut Decoder| {
        let mut bytes = &frame[..];
        std::iter::from_fn(|| decoder.next(&mut bytes))
            .filter(|event| matches!(event, Event::Match(..)))
            .count()
    };
    stage("a frame from bytes to matches", Decoder::new, matches);
}
