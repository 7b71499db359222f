//! A record taken after any pair of any run is read, and proposes what was proposed. With `RECORDS_CAMPAIGN=1` fifty
//! times as many runs.

use std::env;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use clap::ValueEnum;
use host_tests::synth::{Fence, LensError, Scenario, ScenarioKind, ScenarioPair, rig};
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stereo_selfcal::{Calibrator, Config, LensTracking, Proposal, State};

const RUNS: u64 = 400;
const MANY: u64 = 50;
const PAIRS: usize = 50;
const FIRST_SEED: u64 = 60_000;

/// A scenario and a configuration, drawn by the seed.
fn drawn(seed: u64) -> (Scenario, Config) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut scenario =
        Scenario::new(*ScenarioKind::value_variants().choose(&mut rng).unwrap(), PAIRS);
    let mut degrees = |most: f64| rng.random_range(-most..=most);
    let turn = [degrees(8.0), degrees(8.0), degrees(8.0)];
    let scene = &mut scenario.scene;
    scene.rig = rig(turn, [degrees(4.0), degrees(4.0)]).unwrap();
    scene.matches = *[24, 64, 256, 400].choose(&mut rng).unwrap();
    scene.outliers = *[0.0, 0.1, 0.3, 0.6].choose(&mut rng).unwrap();
    scene.noise_px = *[0.05, 0.3, 1.5].choose(&mut rng).unwrap();
    scene.focal = *[500.0, 1400.0].choose(&mut rng).unwrap();
    let mut wrong = |share: f64, most: f64| {
        if rng.random_bool(share) { rng.random_range(-most..=most) } else { 0.0 }
    };
    scene.lens_errors[1] = LensError {
        focal: wrong(0.4, 0.02),
        radial: [wrong(0.3, 0.03), 0.0],
        ..LensError::default()
    };
    scenario.lens_warming = wrong(0.1, 0.01);
    if let Some(lasting) = Some(wrong(0.4, 0.4).abs()).filter(|&deg| deg > 0.0) {
        scenario.disturbance.vibration_deg = lasting;
    }
    scenario.disturbance.skew_deg = wrong(0.2, 0.5);
    scenario.disturbance.rolling_px = wrong(0.2, 1.0).abs();
    if rng.random_bool(0.1) {
        scenario.scene.fence = Some(Fence { share: 0.3, across_px: 3.0, local: rng.random() });
    }
    let robust = Config::robust();
    let compensate = robust.with_lens_tracking(LensTracking::Compensate);
    let configs = [robust, compensate, compensate, Config::paper()];
    (scenario, *configs.choose(&mut rng).unwrap())
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
    let (scenario, config) = drawn(seed);
    let [mut calibrator, mut restored] =
        [(); 2].map(|()| Box::new(Calibrator::<f32, 512>::new(config)));
    let cameras = scenario.scene.dataset(0, 0).unwrap().cameras().unwrap();
    calibrator.set_cameras(cameras);
    let mut room = vec![0; Calibrator::<f32, 512>::SNAPSHOT_BYTES];
    let mut records = 0;
    for (at, ScenarioPair { pair, .. }) in scenario.frames(seed).unwrap().enumerate() {
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
                "{done:?}{differs}, seed {seed}, pair {at}: {scenario:?}, {config:?}"
            ));
        }
        records += 1;
    }
    Ok(records)
}

#[test]
fn a_record_of_any_run_is_read_and_proposes_the_same() {
    let runs = RUNS * if env::var_os("RECORDS_CAMPAIGN").is_some() { MANY } else { 1 };
    let (next, records) = (AtomicU64::new(0), AtomicU64::new(0));
    let failures = Mutex::new(Vec::new());
    let drive_some = || {
        let seeds = std::iter::repeat_with(|| next.fetch_add(1, Ordering::Relaxed));
        for run in seeds.take_while(|&run| run < runs) {
            match drive(FIRST_SEED + run) {
                Ok(read) => _ = records.fetch_add(read, Ordering::Relaxed),
                Err(why) => failures.lock().unwrap().push(why),
            }
        }
    };
    thread::scope(|scope| {
        let cores = thread::available_parallelism().map_or(1, usize::from);
        (0..cores).for_each(|_| _ = scope.spawn(drive_some));
    });
    println!("{} records of {runs} runs", records.into_inner());
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{} runs: {}", failures.len(), failures.join("\n"));
}
