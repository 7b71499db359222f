//! Compares statistics, weights and products of an evaluation with their definitions.

use super::super::loss::tukey;
use super::*;
use crate::batch::Batch;
use crate::batch::correspondence::RayPair;
use crate::batch::row_offset::row_offset;
use crate::geometry::rectification::tests::pose;
use crate::pair::scenes::{FOCAL, rays};
use crate::thresholds::TUKEY;

const NOISE: f64 = 0.4;

fn iterate(start: RectifyingRotations<f64>) -> Iterate<f64> {
    Iterate {
        focal: FOCAL,
        noise_floor: 0.1,
        needed: 8,
        start,
        pose: pose([0.01, -0.02, 0.03], [0.02, -0.01]),
        noise: NOISE,
        tukey: TUKEY,
        leverage: None,
        fitted: 0.0,
        min_disparity: -0.008,
    }
}

#[test]
fn a_pose_at_which_few_of_the_matches_that_fit_have_weight_has_no_inliers() {
    let iterate = iterate(pose([0.0; 3], [0.0; 2]));
    let evaluated = |ahead: u32| {
        let one = |i: u32| {
            let k = f64::from(i);
            // All points but the first `ahead` lie behind infinity.
            let d = if i < ahead { 0.05 + 0.02 * (0.91 * k).sin() } else { -0.02 };
            let at = [(0.37 * k).sin() * 0.6, (0.73 * k).cos() * 0.4, d, (0.57 * k).sin() * 3e-4];
            let [x_l, y_l, x_r, y_r] = rays(&iterate.pose, at);
            RayPair::try_new([x_l, y_l], [x_r, y_r]).unwrap()
        };
        let pairs: [_; 100] = core::array::from_fn(|i| one(u32::try_from(i).unwrap()));
        let mut evaluated = EvaluatedPose::NONE;
        iterate.evaluate(Batch::<f64, 100>::of(&pairs).matches(), &mut evaluated).unwrap();
        assert_eq!(evaluated.stats.near(), 100.0);
        let is_scene = evaluated.is_found(12) && evaluated.no_scene(12).is_none();
        (evaluated.measurement.inlier_share, evaluated.has_peak(), is_scene)
    };
    assert_eq!(evaluated(4), (0.0, false, false));
    // The weight suffices, but most points are behind the cameras, so there is no scene.
    assert_eq!(evaluated(8), (1.0, false, false));
    assert_eq!([66, 67].map(evaluated), [(1.0, false, false), (1.0, true, true)]);
}

#[test]
fn correspondences_are_counted_compared_and_weighted_as_defined() {
    let iterate = iterate(pose([0.002, 0.0, -0.001], [0.0, 0.003]));
    let mut pass = Evaluation::at(&iterate);
    let (mut within, mut near_squares, mut screened) = ([0.0; 3], 0.0, 0.0);
    let (mut cost, mut squares, mut weights) = ([0.0; 2], [0.0; 2], [0.0; 2]);
    let (mut added, mut behind) = (0, 0);
    for i in 0..200_u32 {
        // Matches with row offsets of up to 4 px; some lie behind infinity, and every third one is on a grid.
        let k = f64::from(i);
        let [u, v] = [(0.37 * k).sin() * 0.6, (0.73 * k).cos() * 0.4];
        let [d, e] = [(0.11 * k).sin() * 0.05 + 0.03, (0.057 * k).sin() * 0.008];
        let grid_step = if i % 3 == 0 { 1.5 } else { 0.0 };
        let rays = rays(&iterate.pose, [u, v, d, e]);
        let mut pair = RayPair::of_rays(rays).with_scale(if i % 4 == 0 { 2.5 } else { 1.0 });
        pair.widen_grid(grid_step);
        let scale = pair.scale();
        let added_row = pass.row(&pair);

        let frame = PoseTerms::at(&iterate.pose);
        let Constraint { value, variance, .. } = Constraint::of(&frame, &pair).unwrap();
        let deviation = FOCAL * value / variance.sqrt();
        let expected = NOISE * NOISE + grid_step * grid_step / 12.0;
        let unit = expected.sqrt().max(0.6 * grid_step);
        for (count, units) in within.iter_mut().zip([2.0, 3.0, 4.0]) {
            *count += f64::from(deviation.abs() < units * unit);
        }
        if deviation.abs() < 2.0 * unit {
            near_squares += deviation * deviation / 0.7737 - grid_step * grid_step / 12.0;
        }
        let offsets =
            [&iterate.start, &iterate.pose].map(|p| row_offset(p, &pair).unwrap() / scale);
        let most = 2.0 * (TUKEY * unit / FOCAL).powi(2);
        let fits = deviation.abs() <= TUKEY * unit;
        screened += f64::from(fits);
        for ((cost, squares), e) in cost.iter_mut().zip(&mut squares).zip(offsets) {
            *cost += (e * e).min(most);
            *squares += if fits { e * e } else { 0.0 };
        }
        let w = tukey((deviation / (TUKEY * unit)).powi(2)) / expected;
        let least = -0.008 * scale;
        behind += u32::from(d < least);
        let Some(EvaluatedRow { row, coordinates, .. }) = added_row else {
            assert!(d < least || w == 0.0, "{d} {w}");
            continue;
        };
        assert!(d >= least && w > 0.0, "{d} {w}");
        added += 1;
        weights = [weights[0] + w / (scale * scale), weights[1] + w * expected];
        let whole = w * FOCAL * FOCAL / variance;
        assert!((row.weight / whole - 1.0).abs() < 1e-9);
        assert!((row.value - value).abs() < 1e-15 && coordinates[0] == row.value);
    }
    assert!(added > 80 && added < 160 && behind > 5, "{added} {behind}");
    let Evaluation { stats, weights: sums, .. } = pass;
    assert_eq!((stats.usable, stats.within, stats.screened), (200.0, within, screened));
    let stats =
        [stats.near_squares, stats.cost[0], stats.cost[1], stats.squares[0], stats.squares[1]];
    let sums = stats.into_iter().chain(sums);
    let expected = [near_squares, cost[0], cost[1], squares[0], squares[1]];
    for (sum, expected) in sums.zip(expected.into_iter().chain(weights)) {
        assert!((sum / expected - 1.0).abs() < 1e-9, "{sum} {expected}");
    }
}

#[test]
fn an_evaluation_has_the_slope_of_the_whitened_cost_with_fixed_weights() {
    let iterate = iterate(pose([0.0; 3], [0.0; 2]));
    let mut pass = Evaluation::at(&iterate);
    let mut moments = Moments::ZERO;
    let mut sums =
        QuadrantSums { moments: &mut moments, quadrants: [[NormalEquations::ZERO; 2]; 2] };
    let terms = PoseTerms::at(&iterate.pose);
    let mut rows = NormalEquations::ZERO;
    let mut added = heapless::Vec::<(RayPair<f64>, f64), 100>::new();
    for i in 0..100_u32 {
        let k = f64::from(i);
        let [u, v] = [(0.37 * k).sin() * 0.6, (0.73 * k).cos() * 0.4];
        let [d, e] = [(0.11 * k).sin() * 0.05 + 0.06, (0.57 * k).sin() * 0.002];
        let rays = rays(&iterate.pose, [u, v, d, e]);
        let pair = RayPair::of_rays(rays).with_scale(0.5 + f64::from(i % 3));
        let Some(evaluated) = pass.row(&pair) else {
            continue;
        };
        let WeightedRow { weight, value, jacobian } = evaluated.row;
        rows.add_row(weight, value, &jacobian);
        sums.add(&[evaluated]);
        added.push((pair, weight * Constraint::of(&terms, &pair).unwrap().variance)).unwrap();
    }
    assert!(added.len() > 80, "{}", added.len());
    let cost = |pose: &RectifyingRotations<f64>| -> f64 {
        let terms = PoseTerms::at(pose);
        let one = |(pair, w): &(RayPair<f64>, f64)| {
            let Constraint { value, variance, .. } = Constraint::of(&terms, pair).unwrap();
            w * value * value / variance / 2.0
        };
        added.iter().map(one).sum()
    };
    let plain = moments.at_frame().gradient;
    moments.set_gradient(&rows.gradient);
    let corrected = moments.at_frame().gradient;
    for i in 0..5 {
        let at = |h: f64| cost(&iterate.pose.stepped_by(&Vector5::ith(i, h)).unwrap());
        let h = 1e-4;
        let numeric = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
        let scale = rows.information.matrix()[(i, i)].sqrt();
        assert!((corrected[i] - numeric).abs() < 1e-10 * scale, "{i}: {numeric}");
        assert!((plain[i] - numeric).abs() > 1e-7 * scale, "{i}: {numeric}");
    }
}

#[test]
fn a_pose_is_found_by_its_near_residuals_those_beside_them_and_the_noise() {
    let found = |near: f64, beside: f64, noise: f64, crowd: f64| {
        let mut evaluated = EvaluatedPose::<f64>::NONE;
        evaluated.stats.usable = 200.0;
        evaluated.stats.within = [near, near, near + beside];
        evaluated.stats.inner = 0.4 * near;
        evaluated.measurement =
            PairMeasurement { noise, inlier_share: 0.4, crowd, ..evaluated.measurement };
        evaluated.is_found(20)
    };
    // The near residuals must be 15 % of the matches plus 25 % per px of noise, at most 60 %.
    assert_eq!([79.0, 81.0].map(|near| found(near, 0.0, 1.0, 0.0)), [false, true]);
    assert_eq!([119.0, 121.0].map(|near| found(near, 0.0, 3.0, 0.0)), [false, true]);
    assert_eq!([19.0, 31.0].map(|near| found(near, 0.0, 0.0, 0.0)), [false, true]);
    // They must be twice the residuals beside them, and exceed chance.
    assert_eq!([51.0, 49.0].map(|beside| found(100.0, beside, 0.0, 0.0)), [false, true]);
    assert_eq!([16.0, 7.0].map(|beside| found(32.0, beside, 0.0, 0.0)), [false, true]);
    assert_eq!([5.6, 5.4].map(|noise| found(190.0, 0.0, noise, 0.0)), [false, true]);
    assert_eq!(
        [-0.41, 0.41, 0.39].map(|crowd| found(190.0, 0.0, 1.0, crowd)),
        [false, false, true]
    );
}

#[test]
fn a_pose_between_two_crowds_of_equal_size_is_no_optimum() {
    let iterate = iterate(pose([0.0; 3], [0.0; 2]));
    // Two crowds with row offsets of `apart` and `-apart`, each with a scatter of up to 1, in units of the noise.
    let evaluated = |apart: f64| {
        let one = |i: u32| {
            let k = f64::from(i);
            let side = if i.is_multiple_of(2) { apart } else { -apart };
            let row = (side + (0.57 * k).sin()) * NOISE / FOCAL;
            let d = 0.05 + 0.02 * (0.91 * k).sin();
            let at = [(0.37 * k).sin() * 0.6, (0.73 * k).cos() * 0.4, d, row];
            let [x_l, y_l, x_r, y_r] = rays(&iterate.pose, at);
            RayPair::try_new([x_l, y_l], [x_r, y_r]).unwrap()
        };
        let pairs: [_; 100] = core::array::from_fn(|i| one(u32::try_from(i).unwrap()));
        let mut evaluated = EvaluatedPose::NONE;
        iterate.evaluate(Batch::<f64, 100>::of(&pairs).matches(), &mut evaluated).unwrap();
        [evaluated.stats.is_hollow(), !evaluated.has_peak(), !evaluated.is_found(12)]
    };
    assert_eq!([0.0, 0.5].map(evaluated), [[false; 3]; 2]);
    assert_eq!(evaluated(2.0), [true; 3]);
}

#[test]
fn most_of_the_points_that_fit_are_more_than_half_of_them() {
    let is_clearly_in_front = |ahead: f64| {
        let mut evaluated = EvaluatedPose::<f64>::NONE;
        evaluated.stats.within = [30.0; 3];
        evaluated.stats.sides = [ahead, 0.0];
        evaluated.is_clearly_in_front()
    };
    assert_eq!([15.0, 16.0].map(is_clearly_in_front), [false, true]);
}

#[test]
fn statistics_without_residuals_show_no_gap() {
    assert!(!EvaluatedPose::<f64>::NONE.stats.is_hollow());
}
