//! A record taken after any pair of any run is read, and proposes what was proposed. In a campaign five hundred
//! times as many runs.

use clap::ValueEnum;
use host_tests::synth::{Fence, LensError, Scenario, ScenarioKind, ScenarioPair, rig};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::iter::Either::{Left, Right};
use rayon::prelude::*;
use stereo_selfcal::{Calibrator, Config, LensTracking, Proposal, State};
use test_support::runs;

const RUNS: [u64; 2] = [40, 20_000];
const PAIRS: usize = 60;
const FIRST_SEED: u64 = 60_000;
/// Runs whose records were refused once: a step of the fused pose by over a radian.
const REFUSED_ONCE: [u64; 2] = [69_844, 77_605];

/// Two parts of a run with the same cameras, and a configuration, drawn by the seed.
fn drawn(seed: u64) -> ([Scenario; 2], Config) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let lens = drawn_lens(&mut rng);
    let focal = *[500.0, 1400.0].choose(&mut rng).unwrap();
    let [turn, baseline] =
        [8.0, 4.0].map(|most| rng.random::<[f64; 3]>().map(|u| most * (2.0 * u - 1.0)));
    // In half of the runs the rig is knocked between the parts.
    let knock = if rng.random() { rng.random_range(-1.0..=1.0) } else { 0.0 };
    let parts = [0.0, knock].map(|knock| {
        let mut part = drawn_part(&mut rng);
        part.scene.focal = focal;
        part.scene.lens_errors[1] = lens;
        part.scene.rig =
            rig([turn[0] + knock, turn[1], turn[2]], [baseline[0], baseline[1] + knock]).unwrap();
        part
    });
    (parts, drawn_config(&mut rng))
}

/// A configuration, every second with other parameters than by default.
fn drawn_config(rng: &mut ChaCha8Rng) -> Config {
    let robust = Config::robust();
    let compensate = robust.with_lens_tracking(LensTracking::Compensate);
    let configs =
        [robust, robust.with_automatic_apply(true), compensate, compensate, Config::paper()];
    let config = *configs.choose(rng).unwrap();
    if rng.random() {
        return config;
    }
    let mut other = |values: [f32; 3]| *values.choose(rng).unwrap();
    let changed = config
        .with_prior_sd_rad(other([0.01, 0.1, 0.4]))
        .and_then(|config| config.with_max_correction_rad(other([0.2, 0.5, 1.2])))
        .and_then(|config| config.with_noise_floor_px(other([0.02, 0.15, 1.0])))
        .unwrap();
    let changed = changed.with_memory_pairs(*[20, 100, 1000].choose(rng).unwrap()).unwrap();
    if rng.random_bool(0.3) { changed.without_lens_prior() } else { changed }
}

/// Zero, or within `most`.
fn sometimes(rng: &mut ChaCha8Rng, share: f64, most: f64) -> f64 {
    if rng.random_bool(share) { rng.random_range(-most..=most) } else { 0.0 }
}

fn drawn_lens(rng: &mut ChaCha8Rng) -> LensError {
    let [focal, k1] = [(0.4, 0.02), (0.3, 0.03)].map(|(share, most)| sometimes(rng, share, most));
    LensError { focal, radial: [k1, 0.0], ..LensError::default() }
}

/// A scene with what disturbs it.
fn drawn_part(rng: &mut ChaCha8Rng) -> Scenario {
    let mut part = Scenario::new(*ScenarioKind::value_variants().choose(rng).unwrap(), PAIRS / 2);
    part.scene.matches = *[24, 64, 256, 400].choose(rng).unwrap();
    part.scene.outliers = *[0.0, 0.1, 0.3, 0.6].choose(rng).unwrap();
    part.scene.noise_px = *[0.05, 0.3, 1.5].choose(rng).unwrap();
    part.lens_warming = sometimes(rng, 0.1, 0.01);
    part.disturbance.vibration_deg = part.disturbance.vibration_deg.max(sometimes(rng, 0.6, 0.4));
    part.disturbance.skew_deg = sometimes(rng, 0.2, 0.5);
    part.disturbance.rolling_px = sometimes(rng, 0.2, 1.0).abs();
    if rng.random_bool(0.1) {
        part.scene.fence = Some(Fence { share: 0.3, across_px: 3.0, local: rng.random() });
    }
    part
}

/// What is proposed. Its state aside: a restored estimate waits for a pair that confirms it.
fn estimate(calibrator: &Calibrator<f32, 512>) -> Option<Proposal<f32>> {
    let mut proposal = calibrator.proposal()?;
    proposal.state = State::Suspect;
    Some(proposal)
}

/// Drives a run as a vehicle does, and restores the record of each pair. Returns how many there were, or what is wrong
/// with one.
fn drive(seed: u64) -> Result<u64, String> {
    let (parts, config) = drawn(seed);
    let [mut calibrator, mut restored] =
        [(); 2].map(|()| Box::new(Calibrator::<f32, 512>::new(config)));
    let cameras = parts[0].scene.dataset(0, 0).unwrap().cameras().unwrap();
    calibrator.set_cameras(cameras);
    let mut room = vec![0; Calibrator::<f32, 512>::SNAPSHOT_BYTES];
    let mut records = 0;
    let frames = parts.iter().flat_map(|part| part.frames(seed).unwrap());
    for (at, ScenarioPair { pair, .. }) in frames.enumerate() {
        for m in &pair.matches {
            // A pixel beyond the range of the lens is refused.
            let _ = calibrator.push(&m.correspondence());
        }
        // Not every pair is accepted, and not every estimate applied.
        let _ = calibrator.solve_pair().map(|_| calibrator.fuse());
        let _ = calibrator.apply();
        calibrator.clear_pair();
        let record = calibrator.snapshot(&mut room).unwrap();
        restored.reset();
        restored.set_cameras(cameras);
        let done = restored.restore(record);
        let same = estimate(&calibrator) == estimate(&restored)
            && calibrator.calibration_in_use() == restored.calibration_in_use();
        if done.is_err() || !same {
            let differs = if same { "" } else { ", another estimate" };
            return Err(format!(
                "{done:?}{differs}, seed {seed}, pair {at}: {parts:?}, {config:?}"
            ));
        }
        records += 1;
    }
    Ok(records)
}

#[test]
fn records_that_were_refused_once_are_read() {
    for seed in REFUSED_ONCE {
        assert_eq!(drive(seed), Ok(60));
    }
}

#[test]
fn a_record_of_any_run_is_read_and_proposes_the_same() {
    let runs = runs(RUNS[0], RUNS[1]);
    let seeds = FIRST_SEED..FIRST_SEED + runs;
    let (records, failures): (Vec<u64>, Vec<String>) =
        seeds.into_par_iter().partition_map(|seed| drive(seed).map_or_else(Right, Left));
    println!("{} records of {runs} runs", records.iter().sum::<u64>());
    assert!(failures.is_empty(), "{} runs: {}", failures.len(), failures.join("\n"));
}
