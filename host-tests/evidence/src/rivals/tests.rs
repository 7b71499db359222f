//! Requirements on every method.

use nalgebra::{Matrix5, Vector3};
use stereo_selfcal::Extrinsics;
use stereo_selfcal::geometry::metrics::Deviation;

use super::{Front, LingShen, Method, Range, Setting, Tuning, all, all_variants, by_name};
use rigs::data::Rays;
use sim::bounds::cramer_rao;
use sim::synth::{Depth, Scene, rig};

const FOCAL: f64 = 1400.0;

/// Noise of 0.3 px at unit depth.
pub(super) const NOISE: f64 = 0.3 / FOCAL;

/// A rig, and one pair of it without noise.
pub(super) fn clean_pair() -> (Extrinsics<f64>, Vec<Rays>) {
    let scene = scene(0.0, 0.0);
    (scene.rig, pairs(&scene, 1).remove(0))
}

/// Asserts that a covariance of the five unknowns is within 1 % of the Cramer-Rao bound at [`NOISE`].
pub(super) fn assert_covariance_is_the_bound(
    covariance: &Matrix5<f64>,
    rig: &Extrinsics<f64>,
    rays: &[Rays],
) {
    let bound = cramer_rao(rig, rays.iter(), NOISE);
    let variance = covariance.diagonal();
    let rotation = variance.fixed_rows::<3>(0).sum().sqrt() / bound.rotation;
    let translation = variance.fixed_rows::<2>(3).sum().sqrt() / bound.translation;
    assert!((rotation - 1.0).abs() < 0.01, "{rotation}");
    assert!((translation - 1.0).abs() < 0.01, "{translation}");
}

pub(super) fn setting() -> Setting {
    let tuning = Tuning::default();
    Setting { start: Extrinsics::SIDE_BY_SIDE, focal: FOCAL, noise_px: 0.3, tuning }
}

/// A scene whose rig is 3 to 4 degrees off the start, in `R` and in `t`.
pub(super) fn scene(noise_px: f64, outliers: f64) -> Scene {
    let rig = rig([2.0, -2.0, 1.5], [3.0, -2.0]).unwrap();
    Scene { rig, noise_px, outliers, ..Scene::default() }
}

pub(super) fn pairs(scene: &Scene, count: usize) -> Vec<Vec<Rays>> {
    scene.check().unwrap();
    scene.pairs(5).take(count).map(|pair| pair.rays(scene)).collect()
}

/// The worse of both errors, degrees.
fn error(found: Option<Extrinsics<f64>>, scene: &Scene) -> f64 {
    let error = Deviation::between(&found.expect("an estimate"), &scene.rig);
    error.translation.max(error.rotation).to_degrees()
}

#[test]
fn all_methods_have_names_of_their_own_and_are_found_by_them() {
    for method in all() {
        assert_eq!(by_name(method.name()).unwrap().source(), method.source());
    }
    let Err(error) = by_name("guesswork") else { panic!("found") };
    assert!(error.to_string().contains("ling-shen"), "{error}");
}

#[test]
fn every_method_finds_the_rig_from_one_pair_without_noise() {
    let scene = scene(0.0, 0.0);
    let pairs = pairs(&scene, 1);
    for method in all() {
        let error = error(method.fused(&pairs, &setting()), &scene);
        assert!(error < 0.02, "{}: {error}", method.name());
    }
}

#[test]
fn every_method_finds_the_rig_from_several_pairs_with_little_noise() {
    let scene = scene(0.05, 0.0);
    let pairs = pairs(&scene, 6);
    for method in all() {
        let error = error(method.fused(&pairs, &setting()), &scene);
        assert!(error < 0.05, "{}: {error}", method.name());
    }
}

#[test]
fn every_method_but_the_one_without_rejection_finds_the_rig_among_outliers() {
    let scene = scene(0.3, 0.3);
    let pairs = pairs(&scene, 8);
    for method in all().iter().filter(|method| method.name() != LingShen.name()) {
        let error = error(method.fused(&pairs, &setting()), &scene);
        assert!(error < 0.3, "{}: {error}", method.name());
    }
}

#[test]
fn every_method_with_every_setting_finds_the_rig_among_outliers_that_ransac_removes() {
    let [clean, dirty] = [scene(0.05, 0.0), scene(0.3, 0.3)];
    let methods = all();
    for (scene, limit) in [(clean, 0.05), (dirty, 0.3)] {
        let pairs = pairs(&scene, 8);
        let front = Front::new(&pairs, &setting());
        for variant in all_variants(&methods, Range::All).unwrap() {
            let without_rejection = variant.method.name() == LingShen.name();
            if without_rejection && !variant.tuning.prefiltered && scene.outliers > 0.0 {
                continue;
            }
            // A filter that expects motion averages over few pairs, so its errors are larger.
            let limit = if variant.tuning.agile { 3.0 * limit } else { limit };
            let error = error(variant.fused(&pairs, &front, &setting()), &scene);
            assert!(error < limit, "{}: {error}", variant.name());
        }
    }
}

#[test]
fn every_method_finds_the_rig_from_a_slanted_plane() {
    let plane = Depth::Plane { on_axis: 10.0, slope: [-0.4, 0.3] };
    let scene = Scene { depth: plane, ..scene(0.05, 0.0) };
    let pairs = pairs(&scene, 6);
    for method in all() {
        let error = error(method.fused(&pairs, &setting()), &scene);
        assert!(error < 0.5, "{}: {error}", method.name());
    }
}

#[test]
fn every_method_gives_one_estimate_a_pair_and_the_last_is_the_fused_one() {
    let scene = scene(0.3, 0.1);
    let pairs = pairs(&scene, 3);
    for method in all() {
        let running = method.running(&pairs, &setting());
        assert_eq!(running.len(), 3, "{}", method.name());
        assert_eq!(running[2], method.fused(&pairs, &setting()), "{}", method.name());
    }
}

#[test]
fn no_method_panics_or_returns_a_number_that_is_not_finite() {
    for rays in unreasonable() {
        for method in all() {
            for pairs in [vec![rays.clone()], vec![rays.clone(), Vec::new(), rays.clone()]] {
                let running = method.running(&pairs, &setting());
                assert_eq!(running.len(), pairs.len(), "{}", method.name());
                for found in running.iter().flatten() {
                    let finite = found.rotation().matrix().iter().all(|x| x.is_finite())
                        && found.translation().iter().all(|x| x.is_finite());
                    assert!(finite, "{}: {found:?}", method.name());
                }
            }
        }
    }
}

/// Pairs with no information, with little, and with invalid numbers.
fn unreasonable() -> Vec<Vec<Rays>> {
    let p = |x: f64, y: f64| Vector3::new(x, y, 1.0);
    let one = [p(0.1, 0.2), p(0.05, 0.2)];
    let line = |i: i32| [p(0.01 * f64::from(i), 0.0), p(0.01 * f64::from(i) - 0.02, 0.0)];
    let plane =
        Scene { depth: Depth::Plane { on_axis: 10.0, slope: [0.0, 0.0] }, ..scene(0.0, 0.0) };
    // Arbitrary but repeatable numbers.
    let mut state = 1_u32;
    let mut any = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(state) / f64::from(u32::MAX) * 2.0 - 1.0
    };
    let garbage = (0..100).map(|_| [p(any(), any()), p(any(), any())]).collect();
    let bad = [f64::NAN, f64::INFINITY, 1e300, 1e-300, 0.0];
    let not_finite = bad.iter().flat_map(|&x| [[p(x, 0.1), p(0.1, x)], [p(-x, x), one[1]]]);
    let behind = [Vector3::new(0.1, 0.1, -1.0), Vector3::zeros()];
    vec![
        Vec::new(),
        vec![one],
        vec![one; 50],
        vec![[p(0.0, 0.0), p(0.0, 0.0)]; 50],
        (0..50).map(line).collect(),
        pairs(&plane, 1).remove(0),
        garbage,
        not_finite.cycle().take(60).collect(),
        vec![behind; 20],
        pairs(&scene(0.3, 1.0), 1).remove(0),
    ]
}
