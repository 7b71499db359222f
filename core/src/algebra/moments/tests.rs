//! The sums against the matches one by one.

extern crate std;

use super::super::change_frame::split;
use super::*;
use crate::geometry::rectification::tests::pose;
use crate::paper::residual::RectifiedPair;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::vec::Vec;

const FOCAL: f64 = 1400.0;

/// A weight and two rays at unit depth in the rectified frame.
type Match<T> = (T, Vector3<T>, Vector3<T>);

/// `n` matches with these disparities, px, and `noise_px` uniform noise on every coordinate.
fn scene(
    n: usize,
    disparity_px: core::ops::Range<f64>,
    noise_px: f64,
    seed: u64,
) -> Vec<Match<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut one = || {
        let mut within = |limit: f64| rng.random_range(-limit..=limit);
        let [x, y] = [within(0.7), within(0.45)];
        let [dx, dy, ex, ey] = [(); 4].map(|()| within(noise_px) / FOCAL);
        let d = rng.random_range(disparity_px.clone()) / FOCAL;
        let w = rng.random_range(0.5..2.0) * FOCAL * FOCAL;
        (w, Vector3::new(x + dx, y + dy, 1.0), Vector3::new(x - d + ex, y + ey, 1.0))
    };
    (0..n).map(|_| one()).collect()
}

fn add<T: Scalar>(sums: &mut Moments<T>, w: T, products: [T; 9]) {
    sums.products_mut().add(crate::simd::Single, core::iter::once((w, products)));
}

fn sums<T: Scalar>(scene: &[Match<T>]) -> Moments<T> {
    let mut sums = Moments::ZERO;
    for (w, left, right) in scene {
        add(&mut sums, *w, split(&(right * left.transpose())));
    }
    sums
}

/// The same rays in the rectified frame of another pose.
fn seen_from(
    scene: &[Match<f64>],
    frame: &RectifyingRotations<f64>,
    pose: &RectifyingRotations<f64>,
) -> Vec<Match<f64>> {
    let left = pose.left() * frame.left().inverse();
    let right = pose.right() * frame.right().inverse();
    scene.iter().map(|(w, a, b)| (*w, left * a, right * b)).collect()
}

/// `w C^2` over the matches one by one, its slope and information by central differences.
fn direct(
    scene: &[Match<f64>],
    frame: &RectifyingRotations<f64>,
    pose: &RectifyingRotations<f64>,
) -> NormalEquations<f64> {
    let constraints = |pose: &RectifyingRotations<f64>| -> Vec<f64> {
        let seen = seen_from(scene, frame, pose);
        seen.iter().map(|(_, a, b)| b.dot(&Vector3::x().cross(a))).collect()
    };
    let at = constraints(pose);
    let moved =
        |i: usize, h: f64| constraints(&pose.stepped_by(&(Vector5::ith(i, 1.0) * h)).unwrap());
    let h = 1e-3;
    let around: Vec<_> = (0..5).map(|i| [-2.0, -1.0, 1.0, 2.0].map(|k| moved(i, k * h))).collect();
    let mut sum = NormalEquations::ZERO;
    for (k, (w, _, _)) in scene.iter().enumerate() {
        let slope = |i: usize| {
            let [a, b, c, d] = [0, 1, 2, 3].map(|step| around[i][step][k]);
            (8.0 * (c - b) - (d - a)) / (12.0 * h)
        };
        sum.add_row(*w, at[k], &core::array::from_fn(slope));
    }
    sum
}

/// Largest difference of information and slope, in shares of what the matches can make of them.
fn gap<T: Scalar>(a: &NormalEquations<T>, b: &NormalEquations<f64>) -> [f64; 2] {
    let exact = b.information.matrix();
    let scale = exact.diagonal().map(|h| 1.0 / h.sqrt());
    let information = a.information.matrix().map(T::to_f64) - exact;
    let information = information.component_mul(&(scale * scale.transpose())).amax();
    let slope = (a.gradient.map(T::to_f64) - b.gradient).component_mul(&scale).amax();
    [information, slope]
}

#[test]
fn information_and_slope_at_any_pose_are_those_of_the_matches_one_by_one() {
    let frame = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
    let scene = scene(60, 5.0..300.0, 0.5, 1);
    let sums = sums(&scene);
    for step in [0.0, 1e-4, 0.01, -0.1, 0.3] {
        let step = Vector5::new(1.0, -0.7, 0.4, 0.9, -0.5) * step;
        let pose = frame.stepped_by(&step).unwrap();
        let [information, slope] =
            gap(&sums.at_pose(&frame, &pose), &direct(&scene, &frame, &pose));
        // In standard deviations; those of the residuals here are up to 1e3.
        assert!(information < 1e-8 && slope < 1e-6, "{step} {information:e} {slope:e}");
    }
}

#[test]
fn the_slope_is_half_of_what_the_cost_falls_by() {
    let frame = pose([0.02, 0.01, -0.03], [0.05, 0.02]);
    let scene = scene(40, 5.0..300.0, 0.5, 2);
    let at = frame.stepped_by(&Vector5::new(0.01, 0.02, -0.01, 0.03, 0.02)).unwrap();
    let gradient = sums(&scene).at_pose(&frame, &at).gradient;
    let cost = |pose: &RectifyingRotations<f64>| -> f64 {
        let seen = seen_from(&scene, &frame, pose);
        seen.iter().map(|(w, a, b)| w * b.dot(&Vector3::x().cross(a)).powi(2)).sum()
    };
    for (i, slope) in gradient.iter().enumerate() {
        let moved = |h: f64| cost(&at.stepped_by(&(Vector5::ith(i, h))).unwrap());
        let numeric = (moved(1e-6) - moved(-1e-6)) / 2e-6;
        assert!((2.0 * slope / numeric - 1.0).abs() < 1e-6, "{i}: {slope} {numeric}");
    }
}

#[test]
fn at_the_frame_they_are_those_of_the_general_formula_and_of_sights() {
    let frame = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut sums = Moments::ZERO;
    let mut rows = NormalEquations::ZERO;
    for _ in 0..60 {
        let mut ray = || [rng.random_range(-0.6..0.6), rng.random_range(-0.4..0.4)];
        let pair = crate::RayPair::try_new(ray(), ray()).unwrap();
        let sight = RectifiedPair::of(&frame, &pair).unwrap();
        let [left, right] =
            [&sight.left, &sight.right].map(|view| Vector3::new(view.u, view.v, 1.0));
        add(&mut sums, 2.5, split(&(right * left.transpose())));
        // Without what the slope of the depths does to the row: the moments hold depths as they are.
        let (a, b) = (&sight.left, &sight.right);
        let row = sight.row(frame.gauge_slope());
        assert!((a.v - b.v - row.offset).abs() < 1e-15);
        let split = [-(a.v * b.v + 1.0), a.u * b.v, a.u];
        let [pitch, yaw, roll] = split;
        rows.add_row(2.5, row.offset, &[pitch, yaw, roll, a.u * b.v - a.v * b.u, a.u - b.u]);
    }
    let at_frame = sums.at_frame();
    let [information, slope] = gap(&at_frame, &sums.at_pose(&frame, &frame));
    assert!(information < 1e-14 && slope < 1e-13, "{information:e} {slope:e}");
    let [information, slope] = gap(&at_frame, &rows);
    assert!(information < 1e-14 && slope < 1e-13, "{information:e} {slope:e}");
}

#[test]
fn turned_sums_are_those_of_turned_rays() {
    let from = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
    let to = pose([-0.1, 0.04, 0.12], [-0.2, 0.15]);
    let scene = scene(60, 1.0..300.0, 0.5, 3);
    let mut turned = sums(&scene);
    turned.change_frame(&from, &to);
    let anew = sums(&seen_from(&scene, &from, &to));
    let size = anew.products.0.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let worst = turned.products.0.iter().zip(&anew.products.0);
    let worst = worst.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(worst < 1e-13 * size, "{worst:e} {size:e}");
}

#[test]
fn adding_sums_is_summing_over_all_matches() {
    let frame = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
    let all = scene(60, 1.0..300.0, 0.5, 4);
    let (some, rest) = all.split_at(23);
    let mut added = sums(some);
    added.set_gradient(&Vector5::new(1.0, 2.0, 3.0, 4.0, 5.0));
    let mut other = sums(rest);
    other.set_gradient(&Vector5::new(30.0, 20.0, 10.0, 5.0, 1.0));
    added.add(&other);
    let [information, _] = gap(&added.at_pose(&frame, &frame), &direct(&all, &frame, &frame));
    assert!(information < 1e-8, "{information:e}");
    let gradient = added.at_pose(&frame, &frame).gradient;
    let expected = Vector5::new(31.0, 22.0, 13.0, 9.0, 6.0);
    assert!((gradient - expected).amax() < 1e-6, "{gradient}");
}

#[test]
fn a_slope_that_was_set_is_read_back_and_keeps_its_distance_elsewhere() {
    let frame = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
    let mut moments = sums(&scene(60, 1.0..300.0, 0.5, 5));
    let plain = moments;
    let set = Vector5::new(1e3, -2e3, 3e3, -40.0, 50.0);
    moments.set_gradient(&set);
    let got = moments.at_pose(&frame, &frame).gradient;
    assert!((got - set).amax() < 1e-8, "{got}");
    let shift = got - plain.at_pose(&frame, &frame).gradient;
    let pose = frame.stepped_by(&Vector5::repeat(0.02)).unwrap();
    let there = moments.at_pose(&frame, &pose).gradient - plain.at_pose(&frame, &pose).gradient;
    assert!((there - shift).amax() < 1e-8 * shift.amax());
    // Set again, it is not set on top.
    moments.set_gradient(&set);
    assert!((moments.at_pose(&frame, &frame).gradient - got).amax() < 1e-8);
}

#[test]
fn f32_is_f64_to_a_thousandth_of_a_deviation_where_disparities_are_1_px() {
    let frame = pose([0.0; 3], [0.0; 2]);
    let cut = |v: Vector3<f64>| v.map(f32::lit);
    // Poses both can hold.
    let single = |pose: &RectifyingRotations<f64>| {
        let e = pose.extrinsics().unwrap();
        let t = cut(e.translation().into_inner());
        let e = crate::Extrinsics::try_new(&e.rotation().matrix().map(f32::lit), &t).unwrap();
        RectifyingRotations::from(&e)
    };
    let mut worst = [0.0_f64; 2];
    for seed in 0..20 {
        let far: Vec<Match<f32>> = scene(256, 0.9..1.1, 0.3, seed)
            .iter()
            .map(|(w, a, b)| (f32::lit(*w), cut(*a), cut(*b)))
            .collect();
        let same: Vec<Match<f64>> = far
            .iter()
            .map(|(w, a, b)| (f64::from(*w), a.map(f64::from), b.map(f64::from)))
            .collect();
        // Half a degree: the row offsets of this pose are of the size of a mounted rig's.
        let at = frame.stepped_by(&Vector5::new(1.0, -1.0, 1.0, 1.0, -1.0).scale(1e-4)).unwrap();
        let got = sums(&far).at_pose(&single(&frame), &single(&at));
        let exact = sums(&same).at_pose(&frame, &at);
        let [information, slope] = gap(&got, &exact);
        worst = [worst[0].max(information), worst[1].max(slope)];
    }
    std::println!("information {:e}, slope {:e}", worst[0], worst[1]);
    assert!(worst[0] < 1e-4 && worst[1] < 1e-3, "{worst:?}");
}

#[test]
fn at_infinity_disparities_are_noise_and_say_nothing_of_the_baseline() {
    // Uniform noise of +-0.5 px.
    let variance = 1.0 / 12.0 / FOCAL / FOCAL;
    let speaks = |disparity: core::ops::Range<f64>, seed| {
        sums(&scene(200, disparity, 0.5, seed)).baseline_observable(variance)
    };
    assert_eq!((0..1000).filter(|&seed| speaks(0.0..1e-9, seed)).count(), 0);
    assert!((0..100).all(|seed| speaks(20.0..200.0, seed)));
    // All alike, but more than an error of yaw could be.
    assert!((0..100).all(|seed| speaks(50.0..50.1, seed)));
}

#[test]
fn a_sum_that_is_no_number_says_nothing_of_the_baseline() {
    let mut broken = sums(&scene(20, 20.0..200.0, 0.5, 6));
    assert!(broken.baseline_observable(1e-8));
    broken.products.0[CY_CY] = f64::NAN;
    assert!(!broken.is_finite() && !broken.baseline_observable(1e-8));
}

#[test]
fn at_the_frame_each_of_the_twenty_expressions_matches_central_differences() {
    let frame = pose([0.05, -0.08, 0.03], [0.1, -0.06]);
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    // Rays that do not correspond: no expression is small.
    let mut one = || {
        let mut within = |limit: f64| rng.random_range(-limit..=limit);
        let [a, b] = [(); 2].map(|()| Vector3::new(within(0.7), within(0.5), 1.0 + within(0.2)));
        (1.0, a, b)
    };
    let scene: Vec<Match<f64>> = (0..9).map(|_| one()).collect();
    let (ours, numeric) = (sums(&scene).at_frame(), direct(&scene, &frame, &frame));
    for (k, (ours, numeric)) in
        ours.information.0.0.iter().zip(&numeric.information.0.0).enumerate()
    {
        assert!((ours - numeric).abs() < 1e-10, "information {k}: {ours} {numeric}");
    }
    for (k, (ours, numeric)) in ours.gradient.iter().zip(numeric.gradient.iter()).enumerate() {
        assert!((ours - numeric).abs() < 1e-10, "slope {k}: {ours} {numeric}");
    }
}
