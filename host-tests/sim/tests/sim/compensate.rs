//! Runs as on a vehicle, with lens compensation: a wrong focal length is corrected, a correct one stays.

use rigs::data::in_f64;
use sim::stats::quantile;
use sim::synth::{LensErrors, Scenario, ScenarioKind, ScenarioPair, rig};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{
    Calibration, Calibrator, Config, FactoryCalibration, Fused, LensTracking, Outcome, Proposal,
    State,
};

const PAIRS: usize = 200;
const SEEDS: std::ops::Range<u64> = 50_000..50_008;

/// Largest ratio of the error of a locked estimate to its reported deviation.
const MOST_SD: f64 = 5.0;

/// Results after one pair.
struct After {
    outcome: Outcome<f32>,
    proposal: Option<Proposal<f32>>,
    error: Option<Deviation<f64>>,
    state: State,
    armed: bool,
    in_use: Calibration<f32>,
}

/// The case `lens/...` of `cargo evidence campaign`.
fn scenario(errors: LensErrors) -> Scenario {
    let mut scenario = Scenario::new(ScenarioKind::Near, PAIRS);
    scenario.scene.outliers = 0.1;
    scenario.scene.rig = rig([3.0, -2.0, 4.0], [3.0, -3.0]).unwrap();
    scenario.scene.lens_errors = errors.given;
    scenario
}

/// Reads the verdict and applies the estimate after every pair.
fn drive(scenario: &Scenario, tracking: LensTracking, seed: u64) -> Vec<After> {
    // A guess confirms no depth.
    let config = Config::robust().with_depth_limit_px(f32::INFINITY).unwrap();
    let config = config.with_lens_tracking(tracking);
    let cameras = scenario.scene.dataset(0, 0).unwrap().cameras().unwrap();
    let factory = FactoryCalibration::guess(cameras);
    let mut calibrator = Box::new(Calibrator::<f32, 512>::new(config, &factory));
    let frames = scenario.frames(seed).unwrap();
    let take = |frame: ScenarioPair| {
        for m in &frame.pair.matches {
            calibrator.push(&m.correspondence()).unwrap();
        }
        let outcome = calibrator.solve_pair();
        let armed = calibrator.verdict().may_arm;
        // `apply` refuses an estimate that is not locked.
        let _ = calibrator.apply();
        let proposal = calibrator.proposal();
        let error =
            |p: &Proposal<f32>| Deviation::between(&in_f64(&p.extrinsics), &frame.scene.rig);
        let error = proposal.as_ref().map(error);
        After {
            outcome,
            proposal,
            error,
            state: calibrator.state(),
            armed,
            in_use: calibrator.in_use(),
        }
    };
    frames.map(take).collect()
}

/// Error over reported deviation with the lens uncertain, the larger of those of `R` and `t`; 0 without an estimate.
fn in_sd(after: &After) -> f64 {
    let (Some(proposal), Some(error)) = (&after.proposal, after.error) else { return 0.0 };
    let sd = proposal.sd_lens;
    (error.translation / f64::from(sd.translation)).max(error.rotation / f64::from(sd.rotation))
}

fn corrects(after: &After) -> bool {
    after.outcome.fused == Ok(Fused::LensCorrected)
}

#[test]
fn a_right_focal_length_off_by_a_thousandth_is_found_and_leaves_little_error() {
    let scenario = scenario("f_r=0.1%".parse().unwrap());
    let mut e_t = Vec::new();
    for seed in SEEDS {
        let run = drive(&scenario, LensTracking::Compensate, seed);
        assert!(run.iter().any(corrects), "{seed}");
        for (at, after) in run.iter().enumerate() {
            assert!(after.state != State::Locked || in_sd(after) <= MOST_SD, "{seed}: pair {at}");
        }
        let last = run.last().unwrap();
        assert!(last.armed, "{seed}");
        let proposal = last.proposal.as_ref().unwrap();
        let (found, sd) = (proposal.correction.focal, proposal.lens.unwrap().focal.sd);
        assert!((found - 0.001).abs() <= 3.0 * sd, "{seed}: {found} +- {sd}");
        e_t.push(last.error.unwrap().translation);
    }
    let [median, worst] = [0.5, 1.0].map(|share| quantile(e_t.iter().copied(), share).unwrap());
    println!("e_t: median {median}, worst {worst}");
    assert!(median <= 0.35e-3 && worst <= 0.8e-3, "{e_t:?}");
}

#[test]
fn a_correct_lens_is_never_corrected_and_every_bit_equals_a_run_that_only_reports() {
    let scenario = scenario(LensErrors::default());
    for seed in SEEDS {
        let compensating = drive(&scenario, LensTracking::Compensate, seed);
        let reporting = drive(&scenario, LensTracking::Report, seed);
        for (at, (c, r)) in compensating.iter().zip(&reporting).enumerate() {
            assert!(!corrects(c), "{seed}: pair {at}");
            assert_eq!((&c.outcome, &c.proposal), (&r.outcome, &r.proposal), "{seed}: pair {at}");
            assert_eq!((c.state, c.armed, c.in_use), (r.state, r.armed, r.in_use), "{seed}: {at}");
        }
    }
}
