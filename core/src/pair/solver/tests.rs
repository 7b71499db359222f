//! Tests the cost of a match behind a camera. Other tests check the results of the solver.

use super::*;
use crate::pair::scenes::FOCAL;
use crate::thresholds::MAX_RISE;

/// Returns whether the solver accepts a pass that has the same sums as the last accepted point, but `behind` of 100
/// matches behind a camera.
fn is_accepted(behind: f64) -> bool {
    let start = RectifyingRotations::SIDE_BY_SIDE;
    let mut solver = PairSolver::search(&Config::robust(), FOCAL, start, 12);
    solver.schedule = Schedule::Polish;
    let information = Information(Symmetric5::of_diagonal([1e6; 5]));
    let normal = NormalEquations { information, gradient: Vector5::zeros() };
    let pass = PassSums { normal, usable: 100.0, near: 90.0, near_squares: 90.0, ..PassSums::ZERO };
    let best = Point::of(&start, &solver.moved, &normal, pass.cost, &solver.prior);
    solver.descent.accept(best);
    solver.step(&PassSums { usable: 100.0 - behind, ..pass }, 100);
    solver.descent.damping == 0.0
}

#[test]
fn a_match_behind_a_camera_costs_as_much_as_an_outlier() {
    // Tukey's cost is at most `TUKEY^2 / 6`.
    let allowed = MAX_RISE / (TUKEY * TUKEY / 6.0);
    assert_eq!([0.99, 1.01].map(|part| is_accepted(allowed * part)), [true, false]);
}
