//! A vehicle that stands still for 200 pairs, with constant matching errors of its landmarks, then drives on. Repeated
//! pairs count as one measurement, and cast no doubt on the estimate.

use rigs::data::{Rays, in_f64};
use sim::bounds::joint_fit;
use sim::stats::rms_deviation;
use sim::synth::{Scenario, ScenarioKind, ScenarioPair, rig};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Calibrator, Config, FactoryCalibration, Fused, Reason, State};
use test_support::runs;

const PARKED: usize = 200;
const DRIVEN: usize = 100;
const SEED: u64 = 40_000;

/// The case `parked/landmarks` of `cargo evidence campaign`.
fn scenario() -> Scenario {
    let mut scenario = Scenario::new(ScenarioKind::ParkedLandmarks, PARKED + DRIVEN);
    scenario.scene.outliers = 0.1;
    scenario.scene.rig = rig([3.0, -2.0, 4.0], [3.0, -3.0]).unwrap();
    scenario
}

/// Reads the verdict and applies the estimate after every pair. After the first estimate is applied, both always
/// succeed.
fn drive(seed: u64, frames: &[ScenarioPair]) -> Calibrator<f32, 256> {
    let cameras = frames[0].scene.dataset(0, 0).unwrap().cameras().unwrap();
    let mut calibrator = Calibrator::new(Config::robust(), &FactoryCalibration::guess(cameras));
    let mut applied = false;
    for (at, frame) in frames.iter().enumerate() {
        for m in &frame.pair.matches {
            calibrator.push(&m.correspondence()).unwrap();
        }
        let fused = calibrator.solve_pair().fused.unwrap();
        if applied {
            let expected = if at < PARKED { Fused::Repeated } else { Fused::Added };
            assert_eq!(fused, expected, "{seed}: pair {at}");
            let verdict = calibrator.verdict();
            assert!(verdict.rows_ok, "{seed}: pair {at}: {verdict}");
            let halves = verdict.reasons.contains(Reason::ImageHalves);
            assert!(!halves, "{seed}: pair {at}: {verdict}");
        }
        match calibrator.apply() {
            Ok(_) => applied = true,
            Err(why) => assert!(!applied && at < 10, "{seed}: pair {at}: {why}"),
        }
    }
    assert_eq!(calibrator.state(), State::Locked, "{seed}");
    calibrator
}

#[test]
fn a_parked_vehicle_stays_armed_and_its_repeated_errors_fade_once_it_drives() {
    let scenario = scenario();
    let truth = &scenario.scene.rig;
    let (mut in_use, mut fits) = (Vec::new(), Vec::new());
    for seed in SEED..SEED + runs(4, 8) {
        let frames: Vec<ScenarioPair> = scenario.frames(seed).unwrap().collect();
        let calibrator = drive(seed, &frames);
        in_use.push(Deviation::between(&in_f64(&calibrator.in_use().extrinsics), truth));
        // While the vehicle drives, every landmark is new in every pair, so the matching errors are noise.
        let driven = frames[PARKED..].iter();
        let rays: Vec<Rays> = driven.flat_map(|f| f.pair.inlier_rays(&f.scene)).collect();
        fits.push(Deviation::between(&joint_fit(truth, &rays), truth));
    }
    let (in_use, fit) = (rms_deviation(in_use), rms_deviation(fits));
    let [t, r] = [in_use.translation / fit.translation, in_use.rotation / fit.rotation];
    println!("in use: {in_use:?}, {t:.2} and {r:.2} of the joint fit");
    assert!(t < 2.0 && r < 2.0, "{t} {r} of the joint fit");
}
