//! Tests single steps: the cost of a match behind a camera, rejected steps, and the noise of a polish. Other tests check
//! the results of the solver.

use core::f64::consts::SQRT_2;

use super::*;
use crate::pair::scale::LevelCounts;
use crate::pair::scenes::FOCAL;
use crate::thresholds::MAX_RISE;

/// A pass of 100 matches at an optimum, of which 90 fit.
fn pass() -> PassSums<f64> {
    let information = Information(Symmetric5::of_diagonal([1e6; 5]));
    let normal = NormalEquations { information, gradient: Vector5::zeros() };
    PassSums { normal, usable: 100.0, near: 90.0, near_squares: 90.0, ..PassSums::ZERO }
}

/// Returns a solver in its polish that has accepted the start.
///
/// * `max_passes`: largest number of passes, evaluation included.
fn polish(max_passes: u16) -> PairSolver<f64> {
    let start = RectifyingRotations::SIDE_BY_SIDE;
    let mut solver = PairSolver::search(&Config::robust(), FOCAL, start, max_passes);
    solver.phase = Phase::Polish;
    let best = Point::of(&start, &solver.moved, &pass().normal, pass().cost, &solver.prior);
    solver.descent.accept(best);
    solver
}

/// Returns whether the solver accepts a pass that has the same sums as the last accepted point, but `behind` of 100
/// matches behind a camera.
fn is_accepted(behind: f64) -> bool {
    let mut solver = polish(12);
    solver.step(&PassSums { usable: 100.0 - behind, ..pass() }, 100);
    solver.descent.damping == 0.0
}

#[test]
fn a_match_behind_a_camera_costs_as_much_as_an_outlier() {
    // Tukey's cost is at most `TUKEY^2 / 6`.
    let allowed = MAX_RISE / (TUKEY * TUKEY / 6.0);
    assert_eq!([0.99, 1.01].map(|part| is_accepted(allowed * part)), [true, false]);
}

#[test]
fn a_rejected_step_is_taken_again_with_more_damping_until_the_passes_are_spent() {
    let mut solver = polish(4);
    // The gradient of the accepted point, for steps that are not zero.
    let best = solver.descent.best.as_mut().unwrap();
    best.joint.gradient = Vector5::repeat(-1e3);
    let start = best.pose;
    let mut last = f64::INFINITY;
    for rejected in 1..=3 {
        solver.step(&PassSums { cost: 1e3, ..pass() }, 100);
        let length = solver.iterate.pose.unknowns_to(&start).norm();
        if rejected < 3 {
            assert_eq!(solver.phase, Phase::Polish);
            assert!(length > 1e-5 && length < 0.6 * last, "{length} {last}");
        } else {
            assert_eq!((solver.phase, length), (Phase::Done(Stop::PassesSpent), 0.0));
        }
        last = length;
    }
}

#[test]
fn the_noise_of_a_polish_is_the_peak_if_that_is_clearly_narrower_than_the_near_residuals() {
    let noise = |peak: f64| {
        let mut solver = polish(12);
        let mut levels = LevelCounts::NONE;
        (0..90).for_each(|_| levels.add(0.99 * peak * peak));
        // Near residuals with a deviation of 1 px.
        solver.tighten(&PassSums { levels, ..pass() });
        solver.iterate.noise
    };
    // The levels are 0.25 px times powers of the square root of 2.
    let noises = [0.5, SQRT_2 / 2.0].map(noise);
    assert!((noises[0] - 0.5).abs() < 1e-12 && noises[1] == 1.0, "{noises:?}");
}
