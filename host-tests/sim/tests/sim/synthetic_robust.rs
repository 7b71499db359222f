//! The robust preset on generated scenes with outliers, in `f32`. Single pairs are compared with the Cramer-Rao bound
//! of their true inliers, and fused estimates with the joint fit of all true inliers.

use rigs::data::{Rays, in_f64};
use sim::bounds;
use sim::run::monte_carlo::{self, Run, nees_band};
use sim::stats::{mean, rms_deviation};
use sim::synth::{Scenario, ScenarioKind, Scene, SynthPair, five_degrees_off, rig};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Calibrator, Config, FactoryCalibration, Rejection};
use test_support::runs;

/// Number of single pairs of a scene.
fn trials() -> u16 {
    runs(400, 1000)
}

/// A scene whose `R` has a rotation vector of 5 degrees in each component, and whose `t` is turned by 5 degrees.
fn scene(outliers: f64) -> Scene {
    let rig = rig([5.0, 5.0, 5.0], [3.5, 3.5]).unwrap();
    Scene { rig, outliers, ..Scene::default() }
}

fn calibrator(scene: &Scene) -> Calibrator<f32, 256> {
    let cameras = scene.dataset(0, 0).unwrap().cameras().unwrap();
    Calibrator::new(Config::robust(), &FactoryCalibration::guess(cameras))
}

fn push(calibrator: &mut Calibrator<f32, 256>, pair: &SynthPair) {
    for m in &pair.matches {
        calibrator.push(&m.correspondence()).unwrap();
    }
}

struct Single {
    /// RMS error over RMS bound, of `t` and of `R`, of the successful trials.
    ratio: [f64; 2],
    /// Share of successful trials: errors of `t` and `R` are below four times the bound.
    success: f64,
    /// Mean of the squared error of `t` over its predicted variance, of the successful trials.
    chi2_t: f64,
}

fn single_pairs(scene: &Scene, seed: u64) -> Single {
    let mut calibrator = calibrator(scene);
    let [mut errors, mut bounds] = [Vec::new(), Vec::new()];
    let mut chi2 = 0.0;
    for pair in scene.pairs(seed).take(trials().into()) {
        // Each pair is solved alone.
        calibrator.reset();
        push(&mut calibrator, &pair);
        let outcome = calibrator.solve_pair();
        let clean: Vec<Rays> = pair.clean_inlier_rays(scene);
        let bound = bounds::cramer_rao(&scene.rig, clean.iter(), scene.noise_px / scene.focal);
        let Some(report) = outcome.pair else { continue };
        let error = Deviation::between(&in_f64(&report.extrinsics), &scene.rig);
        let success =
            error.translation < 4.0 * bound.translation && error.rotation < 4.0 * bound.rotation;
        if success {
            let sd = report.information.standard_deviations().unwrap();
            chi2 += (error.translation / f64::from(sd.translation)).powi(2);
            errors.push(error);
            bounds.push(bound);
        }
    }
    let count = f64::from(u16::try_from(errors.len()).unwrap());
    let [error, bound] = [errors, bounds].map(rms_deviation);
    Single {
        ratio: [error.translation / bound.translation, error.rotation / bound.rotation],
        success: count / f64::from(trials()),
        chi2_t: chi2 / count,
    }
}

#[test]
fn a_single_pair_is_near_the_cramer_rao_bound_whatever_the_outliers() {
    for (outliers, limit) in [(0.0, 1.10), (0.3, 1.10), (0.5, 1.15)] {
        let Single { ratio: [t, r], success, chi2_t } = single_pairs(&scene(outliers), 31);
        println!(
            "{outliers} outliers: sigma_t {t:.3}, sigma_theta {r:.3} of the bound, \
             success {success:.3}, squared error of t over prediction {chi2_t:.2}"
        );
        assert!(t <= limit && r <= limit, "{outliers}: {t} {r}");
        assert!(success >= 0.99, "{outliers}: {success}");
        assert!((0.8..1.3).contains(&chi2_t), "{outliers}: {chi2_t}");
    }
}

#[test]
fn pairs_with_six_in_ten_outliers_are_solved_from_5_degrees_off() {
    let single = single_pairs(&scene(0.6), 32);
    println!("success {:.3}", single.success);
    assert!(single.success >= 0.95);
}

/// Runs of a scenario that start 5 degrees off.
fn campaign(kind: ScenarioKind, outliers: f64, pairs: usize, trials: u64) -> Vec<Run> {
    let mut scenario = Scenario::new(kind, pairs);
    scenario.scene.outliers = outliers;
    scenario.scene.rig = five_degrees_off();
    let config = Config::default();
    monte_carlo::runs::<f32>(&scenario, config, 40_000..40_000 + trials, || ()).unwrap()
}

#[test]
fn fused_pairs_are_near_the_joint_fit_of_all_true_inliers_and_report_true_deviations() {
    let all = [
        (ScenarioKind::Heterogeneous, 0.5),
        (ScenarioKind::Far, 0.3),
        (ScenarioKind::Near, 0.5),
        (ScenarioKind::Planar, 0.3),
    ];
    for (kind, outliers) in all.into_iter().take(runs(2, all.len())) {
        // The standard error of a ratio is 0.04 over 40 runs, and 0.015 over 200.
        let (trials, pairs, limit) = runs((40, 60, 1.25), (200, 100, 1.15));
        let runs = campaign(kind, outliers, pairs, trials);
        let fused = rms_deviation(runs.iter().filter_map(Run::last).map(|m| m.error));
        let joint = rms_deviation(runs.iter().filter_map(|run| run.joint_fit));
        let [t, r] = [fused.translation / joint.translation, fused.rotation / joint.rotation];
        let nees = mean(runs.iter().filter_map(Run::last).map(|m| m.nees)).unwrap();
        let locked = runs.iter().filter_map(Run::locked_at).max().unwrap() + 1;
        println!("{kind}: e_t {t:.3}, e_theta {r:.3} of the joint fit, nees {nees:.2}, {locked}");
        assert!(t <= limit && r <= limit, "{kind}: {t} {r}");
        let [low, high] = nees_band(usize::try_from(trials).unwrap());
        assert!((low..high).contains(&nees), "{kind}: {nees}");
        assert!(runs.iter().all(|run| run.locked_at().is_some()) && locked <= 10, "{kind}");
        let [pairs, false_ones] = runs
            .iter()
            .map(Run::locked_and_overconfident)
            .fold([0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
        assert!(false_ones * 1000 < pairs, "{kind}: {false_ones} of {pairs}");
    }
}

#[test]
fn a_knock_is_followed_in_three_pairs() {
    let mut scenario = Scenario::new(ScenarioKind::Step, 60);
    scenario.scene.outliers = 0.3;
    scenario.turn_deg = 0.3;
    let config = Config::default();
    let seeds = 50_000..50_000 + runs(40, 100);
    let runs = monte_carlo::runs::<f32>(&scenario, config, seeds, || ()).unwrap();
    let in_use =
        |pair: usize| rms_deviation(runs.iter().map(|run| run.pairs[pair].unwrap().in_use));
    // The step is at pair 30, so pairs 30 to 32 are after it. A fresh estimate has three pairs after pair 2.
    let fresh = rms_deviation(runs.iter().map(|run| run.pairs[2].unwrap().error));
    let after = in_use(32);
    println!("in use three pairs after the step: {after:?}, fresh after three {fresh:?}");
    assert!(in_use(30).rotation > 5e-3);
    assert!(after.rotation < 1.5 * fresh.rotation && after.translation < 1.5 * fresh.translation);
}

#[test]
fn outliers_alone_never_lock() {
    let runs = campaign(ScenarioKind::Near, 1.0, 30, runs(20, 50));
    assert!(runs.iter().all(|run| run.locked_at().is_none()));
}

#[test]
fn pairs_of_outliers_alone_are_refused() {
    let scene = scene(0.0);
    let mut calibrator = calibrator(&scene);
    let mut solved = 0;
    for mut pair in scene.pairs(77).take(trials().into()) {
        // Each left point gets the right point of another match.
        let mut right: Vec<[f64; 2]> = pair.matches.iter().map(|m| [m.ur, m.vr]).collect();
        right.rotate_left(1);
        for (m, [ur, vr]) in pair.matches.iter_mut().zip(right) {
            (m.ur, m.vr) = (ur, vr);
        }
        push(&mut calibrator, &pair);
        solved += u32::from(calibrator.solve_pair().fused != Err(Rejection::NoConsensus));
    }
    println!("{solved} pairs of outliers were taken for a rig");
    assert_eq!(solved, 0);
}
