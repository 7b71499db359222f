//! Vector lanes against one correspondence at a time, to rounding.

use super::super::constraint::{Constraint, PoseTerms};
use super::super::iterate::Iterate;
use super::super::pass::{PassOver, PassSums};
use super::super::weighting::Loss;
use super::*;
use crate::pair::scenes::{batch, pixels, solvers};
use proptest::prelude::*;

/// Scale of the rounding errors of sums. Near the edge of the loss a weight is a difference from 1: its error is the
/// geometric mean of that of the weight and that of a full weight.
///
/// * `variance`: of the loss, px^2.
/// * `largest`: element of the sums.
pub(in crate::pair) fn rounding_scale<T: Scalar>(
    iterate: &Iterate<T>,
    pairs: &[RayPair<T>],
    variance: T,
    largest: f64,
) -> f64 {
    let pose = PoseTerms::at(Single, &iterate.pose);
    let full = |pair: &RayPair<T>| {
        let (Constraint { variance: v, jacobian, .. }, in_front) =
            Constraint::of(Single, &pose, pair.rays());
        let squares = jacobian.iter().map(|j| (*j * *j / v).to_f64());
        if in_front { squares.fold(0.0, f64::max) } else { 0.0 }
    };
    let unit = (iterate.focal * iterate.focal / variance).to_f64();
    largest + (largest * unit * pairs.iter().map(full).sum::<f64>()).sqrt()
}

/// Whether rounding decides if a correspondence is in front of the cameras, or behind infinity.
fn is_on_edge<T: Scalar>(iterate: &Iterate<T>, pairs: &[RayPair<T>], rounding: f64) -> bool {
    let by = iterate.weighting(Single, Loss::Polish);
    let edge = T::lit(0.01 * rounding);
    let sides = |pair: &RayPair<T>, edge: T| {
        let mut pose = by.pose;
        pose.min_depth += edge;
        let (constraint, in_front) = Constraint::of(Single, &pose, pair.rays());
        (in_front, constraint.has_disparity(Single, by.min_disparity + edge))
    };
    pairs.iter().any(|pair| sides(pair, edge) != sides(pair, -edge))
}

fn agree<T: Scalar>(pixels: &[[f64; 4]], rotation: [f64; 3], t: [f64; 2], rounding: f64) {
    let batch = batch::<T>(pixels.iter().copied());
    for solver in solvers(&batch, rotation, t) {
        if is_on_edge(&solver.iterate, batch.pairs(), rounding) {
            continue;
        }
        let (iterate, schedule) = (&solver.iterate, &solver.schedule);
        let [mut one, mut wide] =
            [(); 2].map(|()| PassOver { iterate, schedule, sums: PassSums::ZERO });
        one.sweep_single(batch.pairs().iter().map(sample));
        assert!(wide::run(&mut wide, batch.matches()), "no vector lanes: nothing to test");
        let (one, wide) = (one.sums, wide.sums);
        assert_eq!(one.usable, wide.usable);
        // Rounding decides at a weight of zero and at two deviations.
        assert!((one.weighted - wide.weighted).abs() <= T::ONE, "{one:?} {wide:?}");
        assert!((one.near - wide.near).abs() <= T::ONE, "{one:?} {wide:?}");
        let (a, b) = (&one.normal.information.0, &wide.normal.information.0);
        let scale = a.diagonal().map(|d| d.to_f64().sqrt());
        let largest = scale.iter().fold(0.0_f64, |m, s| m.max(*s)).powi(2);
        let scale = rounding_scale(&solver.iterate, batch.pairs(), solver.variance(), largest);
        let most = rounding * scale;
        for (a, b) in a.0.iter().zip(&b.0) {
            assert!((*a - *b).to_f64().abs() <= most, "{one:?} {wide:?}");
        }
        // A weight above zero means a residual within 4.7 deviations.
        let pulls = 4.7 * (largest * one.weighted.to_f64()).sqrt();
        for (a, b) in one.normal.gradient.iter().zip(&wide.normal.gradient) {
            assert!((*a - *b).to_f64().abs() <= rounding * pulls, "{one:?} {wide:?}");
        }
        if one.near == wide.near {
            let most = rounding * 10.0 * one.near.to_f64();
            let [a, b] = [&one, &wide].map(|pass| pass.near_squares.to_f64());
            assert!((a - b).abs() <= most, "{one:?} {wide:?}");
        }
    }
}

proptest! {
    #[test]
    fn a_pass_on_vector_lanes_is_that_one_at_a_time_to_rounding(
        pixels in pixels(), rotation in [-0.1..0.1, -0.3..0.3, -0.1..0.1],
        t in [-0.1..0.1, -0.1..0.1],
    ) {
        agree::<f64>(&pixels, rotation, t, 1e-12);
        agree::<f32>(&pixels, rotation, t, 1e-3);
    }
}
