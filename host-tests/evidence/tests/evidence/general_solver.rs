//! The general solver of the bench `cost` finds the rig.

#[path = "../../benches/cost/minpack.rs"]
mod minpack;

use host_tests::data::Rays;
use host_tests::synth::{Scene, five_degrees_off};
use levenberg_marquardt::{LeastSquaresProblem, differentiate_numerically};
use minpack::RowOffsets;
use nalgebra_034::Vector6;
use rivals::literal_paper::{self, Options};
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::metrics::Deviation;

fn rays(noise_px: f64) -> Vec<Rays> {
    let scene = Scene { rig: five_degrees_off(), noise_px, ..Scene::default() };
    scene.pairs(3).next().unwrap().rays(&scene)
}

fn start() -> Extrinsics<f64> {
    Extrinsics::SIDE_BY_SIDE
}

fn off(solution: &literal_paper::Solution, from: &Extrinsics<f64>) -> f64 {
    let found = Extrinsics::try_new(&solution.rotation(), &solution.translation()).unwrap();
    let off = Deviation::between(&found, from);
    off.rotation.max(off.translation)
}

#[test]
fn the_truth_is_found_on_clean_data() {
    let fit = RowOffsets::new(&start(), &rays(0.0)).minimise();
    assert!(fit.solution.converged && fit.evaluations < 20, "{fit:?}");
    assert!(off(&fit.solution, &five_degrees_off()) < 1e-9, "{fit:?}");
}

#[test]
fn the_optimum_matches_the_transcription_without_huber_weights() {
    let rays = rays(0.3);
    let fit = RowOffsets::new(&start(), &rays).minimise();
    let start = start();
    let (r, t) = (start.rotation().matrix(), start.translation().into_inner());
    let literal = literal_paper::solve(r, &t, &rays, Options::literal(f64::INFINITY));
    let literal = Extrinsics::try_new(&literal.rotation(), &literal.translation()).unwrap();
    assert!(off(&fit.solution, &literal) < 1e-7, "{fit:?}");
}

#[test]
fn jacobian_matches_numeric_differentiation() {
    let mut problem = RowOffsets::new(&start(), &rays(0.3));
    problem.set_params(&Vector6::new(0.05, -0.08, 0.02, -0.04, 0.06, 0.1));
    let numeric = differentiate_numerically(&mut problem).unwrap();
    let miss = (numeric - problem.jacobian().unwrap()).amax();
    assert!(miss < 1e-7, "{miss}");
}
