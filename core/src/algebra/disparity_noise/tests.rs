//! Compares the noise of disparities with exact noise, and tests the gains of the information on the baseline.

extern crate std;

use super::*;
use crate::algebra::change_frame::split;
use crate::algebra::information::Information;
use crate::algebra::moments::without_lens;
use crate::geometry::rectification::tests::pose;
use nalgebra::{Matrix5, Vector3, Vector5};
use std::vec::Vec;

const FOCAL: f64 = 1400.0;
const NOISE_PX: f64 = 0.3;

type Pose = RectifyingRotations<f64>;

fn frame() -> Pose {
    pose([0.05, -0.08, 0.03], [0.1, -0.06])
}

/// Returns the camera rays of a grid of points that have a common disparity, px, along the rectified rows.
fn points(frame: &Pose, disparity: f64) -> Vec<[Vector3<f64>; 2]> {
    let at = |i: usize, n: u32| 2.0 * f64::from(u32::try_from(i).unwrap()) / f64::from(n) - 1.0;
    let point = |i: usize| {
        let left = Vector3::new(0.6 * at(i % 15, 14), 0.4 * at(i / 15, 14), 1.0);
        let a = frame.left() * left;
        let b = a - Vector3::x() * (disparity * a.z / FOCAL);
        let right = frame.right().inverse() * b;
        [left, right / right.z]
    };
    (0..225).map(point).collect()
}

/// Returns the moments of the points with noise whose sample deviation in each coordinate is exactly `NOISE_PX`. Their
/// gradient is the gradient without noise, because the gradient of the whitened cost has no noise on average.
fn noisy(frame: &Pose, disparity: f64) -> Moments<f64> {
    let mut sums = Moments::ZERO;
    let moved = 2.0 * NOISE_PX / FOCAL;
    let mut clean = Vector5::zeros();
    for [left, right] in points(frame, disparity) {
        let weighted = |left: &Vector3<f64>, right: &Vector3<f64>| {
            let (a, b) = (frame.left() * left, frame.right() * right);
            let of_a = Vector3::new(0.0, -a.z, a.y).norm_squared() - axis_part(frame.right(), &a);
            let of_b = Vector3::new(0.0, b.z, -b.y).norm_squared() - axis_part(frame.left(), &b);
            (split(&(b * a.transpose())), (FOCAL / NOISE_PX).powi(2) / (of_a + of_b))
        };
        let (_, w) = weighted(&left, &right);
        for k in 0..8_usize {
            let mut rays = [left, right];
            let sign = if k % 2 == 0 { moved } else { -moved };
            rays[k / 4][(k / 2) % 2] += sign;
            let (products, _) = weighted(&rays[0], &rays[1]);
            sums.add_rows(core::iter::once((w / 8.0, &without_lens(products))));
        }
        let (products, w) = weighted(&left, &right);
        let mut alone = Moments::ZERO;
        alone.add_rows(core::iter::once((w, &without_lens(products))));
        clean += alone.at_frame().gradient;
    }
    sums.set_gradient(&clean);
    sums.set_noise(frame, (NOISE_PX / FOCAL).powi(2));
    sums
}

/// Returns the squared component of `p x (1, 0, 0)` along the optical axis of a camera. `p` and the axis are in the
/// rectified frame; `view` takes the camera frame to it.
fn axis_part(view: &nalgebra::Rotation3<f64>, p: &Vector3<f64>) -> f64 {
    p.cross(&Vector3::x()).dot(&view.matrix().column(2)).powi(2)
}

fn baseline(m: &Matrix5<f64>) -> [f64; 3] {
    [m.m44, m.m54, m.m55]
}

#[test]
fn at_infinity_all_information_on_the_baseline_is_noise_at_any_pose() {
    let frame = frame();
    let sums = noisy(&frame, 0.0);
    for step in [[0.0, 0.0], [0.2, 0.0], [0.0, -0.3], [-0.15, 0.1]] {
        let [y, z] = step;
        let at = frame.stepped_by(&Vector5::new(0.0, 0.0, 0.0, y, z)).unwrap();
        let BiasedEquations { normal, noise } = sums.in_frame_of(&frame).biased_at(&at);
        let whole = baseline(&normal.information.matrix());
        let size = whole[0].max(whole[2]);
        for (all, noise) in whole.iter().zip(noise.0) {
            assert!((all - noise).abs() < 0.02 * size, "{step:?} {whole:?} {noise:?}");
        }
        // The gradient is zero on average. Sums that include noise would have a slope towards the pose of the
        // evaluation.
        let slope = normal.gradient.w.hypot(normal.gradient.a);
        assert!(slope < 0.02 * size * y.hypot(z).max(0.1), "{step:?}: {slope} of {size}");
    }
}

#[test]
fn the_noise_in_another_frame_is_that_at_its_pose() {
    let (frame, other) = (frame(), pose([0.02, -0.1, 0.06], [0.0, 0.05]));
    let sums = noisy(&frame, 3.0);
    let mut moved = sums;
    moved.change_frame(&frame, &other);
    let (there, here) = (sums.in_frame_of(&frame).biased_at(&other), moved.biased_at_frame());
    let size = there.normal.information.matrix().amax();
    assert!(
        (there.normal.information.matrix() - here.normal.information.matrix()).amax()
            < 1e-12 * size
    );
    assert!(
        (there.normal.gradient - here.normal.gradient).amax() < 1e-9 * there.normal.gradient.amax()
    );
    for (a, b) in there.noise.0.iter().zip(here.noise.0) {
        assert!((a - b).abs() < 1e-12 * size, "{a} {b}");
    }
}

#[test]
fn information_and_gradient_without_noise_are_those_of_the_sandwich() {
    let frame = frame();
    let BiasedEquations { normal, noise } = noisy(&frame, 4.0).biased_at_frame();
    let b = normal.information.matrix();
    let mut a = b;
    let [forward, mixed, down] = noise.0.map(|n| n * DISPARITY_NOISE_MARGIN);
    (a.m44, a.m45, a.m54, a.m55) = (a.m44 - forward, a.m45 - mixed, a.m54 - mixed, a.m55 - down);
    let gain = a * b.try_inverse().unwrap();
    let got = BiasedEquations { normal, noise }.debiased();
    let expected = gain * a;
    assert!((got.information.matrix() - expected).amax() < 1e-9 * expected.amax());
    let expected = gain * normal.gradient;
    assert!((got.gradient - expected).amax() < 1e-9 * expected.amax());
}

#[test]
fn at_infinity_nothing_is_left_of_the_baseline_and_all_of_the_rotation() {
    let frame = frame();
    let biased = noisy(&frame, 0.0).biased_at_frame();
    let left = biased.debiased();
    // Marginal information on the rotation of the baseline about z, 1/rad^2. Noise alone adds about 1/rad^2 for each of
    // the 225 matches.
    let marginal = |i: &Information<f64>| i.matrix().try_inverse().map_or(0.0, |c| 1.0 / c.m55);
    assert!(marginal(&biased.normal.information) > 100.0);
    let with_prior = left.with_prior(1.0);
    assert!((with_prior.information.covariance().unwrap().m55 - 1.0).abs() < 0.01);
    let rotation = |m: Matrix5<f64>| m.fixed_view::<3, 3>(0, 0).into_owned();
    assert_eq!(rotation(left.information.matrix()), rotation(biased.normal.information.matrix()));
}

#[test]
fn near_points_keep_their_information() {
    let biased = noisy(&frame(), 400.0).biased_at_frame();
    let (left, whole) =
        (biased.debiased().information.matrix(), biased.normal.information.matrix());
    assert!((left - whole).amax() < 1e-4 * whole.m55);
}

#[test]
fn equations_with_noise_follow_a_step_and_lose_a_part() {
    let biased = noisy(&frame(), 2.0).biased_at_frame();
    let d = Vector5::new(1e-3, -2e-3, 1e-3, 0.02, -0.01);
    let mut twice = biased.about(&d);
    twice.add(&biased.about(&d));
    let back = twice.scaled(0.5).about(&-d).minus(&BiasedEquations::ZERO);
    assert!((back.normal.gradient - biased.normal.gradient).amax() < 1e-6);
    assert!(back.noise.0.iter().zip(biased.noise.0).all(|(a, b)| (a - b).abs() < 1e-9));
    let rest = twice.minus(&biased.about(&d));
    assert!((rest.normal.gradient - biased.about(&d).normal.gradient).amax() < 1e-6);
}

#[test]
fn a_gain_is_never_above_one_nor_below_zero() {
    let noise = Gain::of(-1e3, 0.0, 0.3);
    let close = |of: [f64; 3], expected: [f64; 3]| {
        of.iter().zip(expected).all(|(got, expected)| (got - expected).abs() < 1e-9)
    };
    assert!(close(noise.once, [1.0, 0.0, 0.7]), "{:?}", noise.once);
    assert!(close(noise.twice, [1.0, 0.0, 0.49]), "{:?}", noise.twice);
    let noise = Gain::of(5.0, 0.0, f64::from(f32::EPSILON));
    assert!(noise.once[0] == 0.0 && noise.once[2] > 0.99, "{:?}", noise.once);
}
