//! An evaluation on vector lanes against one correspondence at a time, to rounding.

use super::super::leverage::Leverage;
use super::super::sweep::simd_tests::rounding_scale;
use super::*;
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::Batch;
use crate::geometry::rectification::tests::pose;
use crate::pair::scenes::{CENTRE, FOCAL, batch, rays, rounded};
use crate::thresholds::{MIN_DEPTH, TIGHT_TUKEY, TUKEY};
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

const MIN_DISPARITY: f64 = -0.008;

/// Rays in the rectified frame of the pose (`u`, `v`, disparity, row offset; unit depth), or anywhere in the images.
#[derive(Debug, Clone, Copy)]
struct Drawn {
    seen: [f64; 4],
    anywhere: Option<[f64; 4]>,
}

#[derive(Debug, Clone, Copy)]
struct Scene<'a> {
    drawn: &'a [Drawn],
    pose: RectifyingRotations<f64>,
    start: RectifyingRotations<f64>,
    noise: f64,
    tukey: f64,
    mean_root: Option<f64>,
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let seen = [-0.6..0.6, -0.4..0.4, -0.05..0.3, -0.006..0.006_f64];
    let anywhere = prop::option::weighted(0.1, [-7.9..7.9, -7.9..7.9, -7.9..7.9, -7.9..7.9_f64]);
    (seen, anywhere).prop_map(|(seen, anywhere)| Drawn { seen, anywhere })
}

impl Scene<'_> {
    /// Whether the signs of depths and disparity are clear of rounding.
    fn is_clear(&self, [x_l, y_l, x_r, y_r]: [f64; 4]) -> bool {
        let turned = |by: &Rotation3<f64>, x, y| by * Vector3::new(x, y, 1.0);
        let poses = [&self.pose, &self.start];
        let [(a, b), (c, d)] =
            poses.map(|pose| (turned(pose.left(), x_l, y_l), turned(pose.right(), x_r, y_r)));
        let depths = [a.z, b.z, c.z, d.z];
        depths.into_iter().all(|z| (z - MIN_DEPTH).abs() > 0.02)
            && (a.x / a.z - b.x / b.z - MIN_DISPARITY).abs() > 1e-4
    }

    fn batch<T: Scalar>(&self) -> Batch<T, 100> {
        let rays = |drawn: &Drawn| drawn.anywhere.unwrap_or_else(|| rays(&self.pose, drawn.seen));
        let clear = self.drawn.iter().map(rays).filter(|rays| self.is_clear(*rays));
        batch(clear.map(|rays| rays.map(|x| FOCAL * x + CENTRE)))
    }

    fn iterate<T: Scalar>(&self) -> Iterate<T> {
        let covariance = Symmetric5::of_diagonal([T::lit(1e-6); 5]);
        let first = |root| Leverage::first(T::lit(root), &covariance).unwrap();
        Iterate {
            focal: T::lit(FOCAL),
            noise_floor: T::lit(0.1),
            needed: 8,
            start: rounded(&self.start),
            pose: rounded(&self.pose),
            noise: T::lit(self.noise),
            tukey: T::lit(self.tukey),
            leverage: self.mean_root.map(first),
            fitted: T::ZERO,
            min_disparity: T::lit(MIN_DISPARITY),
        }
    }

    fn agree<T: Scalar>(&self, rounding: f64) {
        let (batch, iterate) = (self.batch::<T>(), self.iterate());
        let ([mut one, mut wide], pose) = ([EvaluatedPose::NONE; 2], &iterate.pose);
        let sums = EvaluationSums { gradient: Vector5::zeros(), weights: [T::ZERO; 2] };
        let mut by_one = EvaluationPass { iterate: &iterate, evaluated: &mut one, sums };
        by_one.sweep_single(batch.pairs().iter().map(sweep::sample));
        let by_one = by_one.sums;
        let mut by_many = EvaluationPass { iterate: &iterate, evaluated: &mut wide, sums };
        assert!(
            sweep::wide::run(&mut by_many, batch.matches()),
            "no vector lanes: nothing to test"
        );
        let by_many = by_many.sums;
        let n = one.stats.usable.to_f64();
        stats_agree(&one.stats, &wide.stats, rounding);
        let [one, wide] = [one, wide].map(|evaluated| evaluated.measurement);
        for (a, b) in by_one.weights.into_iter().zip(by_many.weights) {
            near(a, b, rounding * n / self.noise.powi(2));
        }
        let squared = iterate.noise * iterate.noise;
        let most = |largest| rounding_scale(&iterate, batch.pairs(), squared, largest);
        let largest_here = largest(&one.moments.at_frame());
        let scale =
            [most(largest_here), (22.0 * largest_here * n).sqrt()].map(|scale| rounding * scale);
        let [_, of_gradient] = scale;
        for (a, b) in by_one.gradient.iter().zip(&by_many.gradient) {
            near(*a, *b, of_gradient);
        }
        for (a, b) in one.halves.iter().zip(&wide.halves) {
            normal_equations_agree(a, b, scale);
        }
        // Normal equations at two poses cover all moments.
        normal_equations_agree(&one.moments.at_frame(), &wide.moments.at_frame(), scale);
        let [a, b] = [one, wide].map(|e| e.moments.at_pose(pose, &iterate.start));
        let largest = largest_here.max(largest(&a));
        normal_equations_agree(&a, &b, [rounding * most(largest); 2]);
    }
}

fn near<T: Scalar>(a: T, b: T, tolerance: f64) {
    assert!((a - b).to_f64().abs() <= tolerance, "{a:?} {b:?} within {tolerance}");
}

fn largest<T: Scalar>(of: &NormalEquations<T>) -> f64 {
    of.information.0.diagonal().iter().fold(0.0, |m, d| d.to_f64().max(m))
}

fn normal_equations_agree<T: Scalar>(
    a: &NormalEquations<T>,
    b: &NormalEquations<T>,
    tolerance: [f64; 2],
) {
    let [of_information, of_gradient] = tolerance;
    for (a, b) in a.information.0.0.iter().zip(&b.information.0.0) {
        near(*a, *b, of_information);
    }
    for (a, b) in a.gradient.iter().zip(&b.gradient) {
        near(*a, *b, of_gradient);
    }
}

/// Rounding may move two correspondences across the edge of a count.
fn stats_agree<T: Scalar>(a: &ResidualStats<T>, b: &ResidualStats<T>, rounding: f64) {
    assert_eq!(a.usable, b.usable);
    for (a, b) in a.within.into_iter().zip(b.within).chain([(a.screened, b.screened)]) {
        near(a, b, 2.0);
    }
    let n = a.usable.to_f64();
    let by_chance = (a.near() - b.near()).to_f64().abs();
    near(a.near_squares, b.near_squares, 20.0 * (rounding * n + by_chance));
    let squares = a.squares.into_iter().zip(b.squares).filter(|_| a.screened == b.screened);
    for (a, b) in squares.chain(a.cost.into_iter().zip(b.cost)) {
        near(a, b, rounding * (a.to_f64() + 1e-5 * n));
    }
}

proptest! {
    #[test]
    fn an_evaluation_on_vector_lanes_is_that_one_at_a_time_to_rounding(
        drawn in prop::collection::vec(drawn(), 0..100),
        rotation in [-0.1..0.1, -0.3..0.3, -0.1..0.1], t in [-0.1..0.1, -0.1..0.1],
        off in [-0.02..0.02, -0.1..0.1, -0.02..0.02],
        noise in 0.2..0.8_f64, tukey in prop::sample::select(&[TUKEY, TIGHT_TUKEY]),
        mean_root in prop::option::of(0.01..0.06),
    ) {
        let [x, y, z] = rotation;
        let [dx, dy, dz] = off;
        let start = pose([x + dx, y + dy, z + dz], t);
        let pose = pose(rotation, t);
        let scene = Scene { drawn: &drawn, pose, start, noise, tukey, mean_root };
        scene.agree::<f64>(1e-11);
        scene.agree::<f32>(2e-3);
    }
}
