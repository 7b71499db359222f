//! Compares the moments with sums over single matches.

extern crate std;

use super::super::change_frame::split;
use super::*;
use crate::geometry::rectification::tests::pose;
use core::ops::Range;
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::vec::Vec;

const FOCAL: f64 = 1400.0;

/// A weight and two rays at unit depth in the rectified frame.
type Match<T> = (T, Vector3<T>, Vector3<T>);

/// Returns `n` matches with random weights, disparities in a range, px, and uniform noise of up to `noise_px` on every
/// coordinate.
fn scene(n: usize, disparity_px: Range<f64>, noise_px: f64, seed: u64) -> Vec<Match<f64>> {
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
    sums.add_rows(core::iter::once((w, &without_lens(products))));
}

fn sums<T: Scalar>(scene: &[Match<T>]) -> Moments<T> {
    let mut sums = Moments::ZERO;
    for (w, left, right) in scene {
        add(&mut sums, *w, split(&(right * left.transpose())));
    }
    sums
}

type Pose = RectifyingRotations<f64>;

/// Returns the pose whose rectified frame most tests use.
fn frame() -> Pose {
    pose([0.05, -0.08, 0.03], [0.1, -0.06])
}

/// Transforms the rays to the rectified frame of another pose.
fn seen_from(scene: &[Match<f64>], frame: &Pose, pose: &Pose) -> Vec<Match<f64>> {
    let left = pose.left() * frame.left().inverse();
    let right = pose.right() * frame.right().inverse();
    scene.iter().map(|(w, a, b)| (*w, left * a, right * b)).collect()
}

/// Returns the normal equations of `sum w C^2`, summed over single matches, with derivatives by central differences.
fn direct(scene: &[Match<f64>], frame: &Pose, pose: &Pose) -> NormalEquations<f64> {
    let constraints = |pose: &Pose| -> Vec<f64> {
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

/// Returns the largest differences of information and gradient, scaled to a unit diagonal of the information.
fn gap<T: Scalar>(a: &NormalEquations<T>, b: &NormalEquations<f64>) -> [f64; 2] {
    let exact = b.information.matrix();
    let scale = exact.diagonal().map(|h| 1.0 / h.sqrt());
    let information = a.information.matrix().map(T::to_f64) - exact;
    let information = information.component_mul(&(scale * scale.transpose())).amax();
    let gradient = (a.gradient.map(T::to_f64) - b.gradient).component_mul(&scale).amax();
    [information, gradient]
}

#[test]
fn normal_equations_at_any_pose_match_the_sum_over_the_matches() {
    let frame = frame();
    let scene = scene(60, 5.0..300.0, 0.5, 1);
    let sums = sums(&scene);
    for step in [0.0, 1e-4, 0.01, -0.1, 0.3] {
        let step = Vector5::new(1.0, -0.7, 0.4, 0.9, -0.5) * step;
        let pose = frame.stepped_by(&step).unwrap();
        let [information, gradient] =
            gap(&sums.in_frame_of(&frame).at(&pose), &direct(&scene, &frame, &pose));
        // The gap of the gradient is in standard deviations; the residuals reach 1e3 of them.
        assert!(information < 1e-8 && gradient < 1e-6, "{step} {information:e} {gradient:e}");
    }
}

#[test]
fn sums_after_a_change_of_frame_equal_those_of_rotated_rays() {
    let from = frame();
    let to = pose([-0.1, 0.04, 0.12], [-0.2, 0.15]);
    let scene = scene(60, 1.0..300.0, 0.5, 3);
    let mut turned = sums(&scene);
    turned.change_frame(&from, &to);
    let anew = sums(&seen_from(&scene, &from, &to));
    let size = anew.products.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let gaps = turned.products.iter().zip(&anew.products).map(|(a, b)| (a - b).abs());
    let worst = gaps.fold(0.0, f64::max);
    assert!(worst < 1e-13 * size, "{worst:e} {size:e}");
}

#[test]
fn added_sums_are_the_sums_over_all_matches() {
    let frame = frame();
    let all = scene(60, 1.0..300.0, 0.5, 4);
    let (some, rest) = all.split_at(23);
    let mut added = sums(some);
    added.set_gradient(&Vector5::new(1.0, 2.0, 3.0, 4.0, 5.0));
    let mut other = sums(rest);
    other.set_gradient(&Vector5::new(30.0, 20.0, 10.0, 5.0, 1.0));
    added.add(&other);
    let joint = added.in_frame_of(&frame).at(&frame);
    let [information, _] = gap(&joint, &direct(&all, &frame, &frame));
    assert!(information < 1e-8, "{information:e}");
    let expected = Vector5::new(31.0, 22.0, 13.0, 9.0, 6.0);
    assert!((joint.gradient - expected).amax() < 1e-6, "{}", joint.gradient);
}

#[test]
fn a_gradient_that_is_set_holds_at_the_frame_and_its_offset_by_the_baseline_turns_with_the_frame() {
    let frame = frame();
    let mut moments = sums(&scene(60, 1.0..300.0, 0.5, 5));
    let plain = moments;
    let set = Vector5::new(1e3, -2e3, 3e3, -40.0, 50.0);
    moments.set_gradient(&set);
    let got = moments.in_frame_of(&frame).at(&frame).gradient;
    assert!((got - set).amax() < 1e-8, "{got}");
    let shift = |pose: &Pose| {
        moments.in_frame_of(&frame).at(pose).gradient - plain.in_frame_of(&frame).at(pose).gradient
    };
    let other = frame.stepped_by(&Vector5::repeat(0.02)).unwrap();
    let (here, there) = (shift(&frame), shift(&other));
    let by_rotation = |shift: Vector5<f64>| shift.fixed_rows::<3>(0).into_owned();
    assert!((by_rotation(there) - by_rotation(here)).amax() < 1e-8 * here.amax());
    // The baseline part of the offset is in the first row and column of the noise tensor. The other elements of the
    // tensor are zero here, because `set_noise` has not been called.
    let (xy, xz) = (here.a, -here.w);
    let tensor = Matrix3::new(0.0, xy, xz, xy, 0.0, 0.0, xz, 0.0, 0.0);
    let turn = (other.left() * frame.left().inverse()).into_inner();
    let turned = turn * tensor * turn.transpose();
    assert!((there.w + turned.m31).abs() < 1e-8 * here.amax(), "{there} {turned}");
    assert!((there.a - turned.m21).abs() < 1e-8 * here.amax(), "{there} {turned}");
    assert!((there - here).amax() > 1e-3 * here.amax());
    // Setting the gradient again replaces the offset.
    moments.set_gradient(&set);
    assert!((moments.in_frame_of(&frame).at(&frame).gradient - got).amax() < 1e-8);
}

#[test]
fn f32_matches_f64_to_a_thousandth_of_a_standard_deviation_at_disparities_of_1_px() {
    let frame = Pose::SIDE_BY_SIDE;
    let cut = |v: Vector3<f64>| v.map(f32::lit);
    let single = |pose: &Pose| {
        let e = pose.extrinsics().unwrap();
        let t = cut(e.translation().into_inner());
        let e = crate::Extrinsics::try_new(&e.rotation().matrix().map(f32::lit), &t).unwrap();
        RectifyingRotations::from(&e)
    };
    let mut worst = [0.0_f64; 2];
    for seed in 0..20 {
        let far = scene(256, 0.9..1.1, 0.3, seed);
        let far: Vec<_> = far.iter().map(|(w, a, b)| (f32::lit(*w), cut(*a), cut(*b))).collect();
        let exact = far.iter().map(|(w, a, b)| (f64::from(*w), a.map(f64::from), b.map(f64::from)));
        let exact = sums(&exact.collect::<Vec<_>>());
        let at = frame.stepped_by(&Vector5::new(1.0, -1.0, 1.0, 1.0, -1.0).scale(1e-4)).unwrap();
        let got = sums(&far).in_frame_of(&single(&frame)).at(&single(&at));
        let [information, gradient] = gap(&got, &exact.in_frame_of(&frame).at(&at));
        worst = [worst[0].max(information), worst[1].max(gradient)];
    }
    assert!(worst[0] < 1e-4 && worst[1] < 1e-3, "{worst:?}");
}

#[test]
fn sums_with_a_nan_are_not_finite() {
    let mut broken = sums(&scene(20, 20.0..200.0, 0.5, 6));
    assert!(broken.is_finite());
    broken.products[2] = f64::NAN;
    assert!(!broken.is_finite());
}

#[test]
fn each_of_the_twenty_expressions_at_the_frame_matches_central_differences_and_the_general_formula()
{
    let frame = frame();
    let mut rng = ChaCha8Rng::seed_from_u64(9);
    // The rays do not correspond, so that no expression is small.
    let mut one = || {
        let mut within = |limit: f64| rng.random_range(-limit..=limit);
        let [a, b] = [(); 2].map(|()| Vector3::new(within(0.7), within(0.5), 1.0 + within(0.2)));
        (1.0, a, b)
    };
    let scene: Vec<Match<f64>> = (0..9).map(|_| one()).collect();
    let sums = sums(&scene);
    let all = |n: NormalEquations<f64>| n.information.0.0.into_iter().chain(n.gradient.data.0[0]);
    let numeric = all(direct(&scene, &frame, &frame));
    for (k, (ours, numeric)) in all(sums.at_frame()).zip(numeric).enumerate() {
        assert!((ours - numeric).abs() < 1e-10, "expression {k}: {ours} {numeric}");
    }
    let [information, gradient] = gap(&sums.at_frame(), &sums.in_frame_of(&frame).at(&frame));
    assert!(information < 1e-14 && gradient < 1e-13, "{information:e} {gradient:e}");
}
