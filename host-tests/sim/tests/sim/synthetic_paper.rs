//! On generated scenes without outliers, the published method reaches the Cramer-Rao bound for a pair, and its fusion is
//! compared with the joint fit of all correspondences.

use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rigs::data::{Rays, in_f64};
use sim::bounds;
use sim::stats::rms_deviation;
use sim::synth::{Scene, SynthPair, rig};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{Extrinsics, Scalar};
use test_support::runs;

const PAIRS: usize = 100;

/// A rig with `R` turned by 5 degrees about a random axis, and `t` by 5 degrees in a random direction.
fn rig_5_degrees_off(seed: u64) -> Extrinsics<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || rng.random_range(-1.0..1.0);
    let axis = Vector3::new(uniform(), uniform(), uniform()).normalize() * 5.0;
    let baseline = Vector3::new(uniform(), uniform(), 0.0).normalize() * 5.0;
    rig(axis.into(), [baseline.x, baseline.y]).unwrap()
}

/// One trial: errors of the single pairs, their Cramer-Rao bounds, and errors of the fused estimate and of the joint
/// fit.
struct Trial {
    singles: Vec<Deviation<f64>>,
    bounds: Vec<Deviation<f64>>,
    fused: Deviation<f64>,
    joint: Deviation<f64>,
}

fn trial<T: Scalar>(scene: &Scene, seed: u64) -> Trial {
    let meta = scene.dataset(0, seed).unwrap();
    let cameras = meta.cameras().unwrap();
    let start = Extrinsics::SIDE_BY_SIDE;
    let mut calibrator = PaperCalibrator::<T, 256>::new(Settings::DEFAULT, cameras, start);
    let pairs: Vec<SynthPair> = scene.pairs(seed).take(PAIRS).collect();
    let truth = &scene.rig;
    let mut singles = Vec::new();
    for pair in &pairs {
        for m in &pair.matches {
            calibrator.push(&m.correspondence()).unwrap();
        }
        let outcome = calibrator.solve_pair();
        outcome.fused.unwrap();
        let report = outcome.pair.unwrap();
        singles.push(Deviation::between(&in_f64(&report.extrinsics), truth));
    }
    let estimate = calibrator.estimate().unwrap();
    assert!(estimate.axis_is_meaningful);
    let noise = scene.noise_px / scene.focal;
    let bounds = pairs.iter().map(|pair| {
        let clean: Vec<Rays> = pair.clean.iter().map(|&pixels| scene.rays(pixels)).collect();
        bounds::cramer_rao(truth, clean.iter(), noise)
    });
    let bounds = bounds.collect();
    let measured: Vec<Rays> = pairs.iter().flat_map(|pair| pair.rays(scene)).collect();
    Trial {
        singles,
        bounds,
        fused: Deviation::between(&in_f64(&estimate.extrinsics), truth),
        joint: Deviation::between(&bounds::joint_fit(truth, &measured), truth),
    }
}

/// Ratios of RMS errors, each of `t` and of `R`: of single pairs to their Cramer-Rao bounds, then of the fused estimate
/// to the joint fit.
fn efficiency<T: Scalar>() -> [f64; 4] {
    let trials: Vec<Trial> = (0..runs(24, 200))
        .map(|seed| {
            let scene = Scene { rig: rig_5_degrees_off(seed), ..Scene::default() };
            trial::<T>(&scene, 1000 + seed)
        })
        .collect();
    let sigma = rms_deviation(trials.iter().flat_map(|t| t.singles.iter().copied()));
    let bound = rms_deviation(trials.iter().flat_map(|t| t.bounds.iter().copied()));
    let fused = rms_deviation(trials.iter().map(|t| t.fused));
    let joint = rms_deviation(trials.iter().map(|t| t.joint));
    [
        sigma.translation / bound.translation,
        sigma.rotation / bound.rotation,
        fused.translation / joint.translation,
        fused.rotation / joint.rotation,
    ]
}

#[test]
fn the_published_method_reaches_the_cramer_rao_bound_and_its_fusion_the_joint_fit() {
    let [sigma_t, sigma_theta, e_t, e_theta] = efficiency::<f32>();
    println!("over the bound: sigma_t {sigma_t:.3}, sigma_theta {sigma_theta:.3}");
    println!("over the joint fit: e_t {e_t:.3}, e_theta {e_theta:.3}");
    // A ratio clearly below 1 would mean that the bound is wrong.
    assert!((0.97..=1.05).contains(&sigma_t) && (0.97..=1.05).contains(&sigma_theta));
    assert!(e_t <= 1.10 && e_theta <= 1.10);
}
