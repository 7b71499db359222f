//! Levenberg-Marquardt at a fixed scale: acceptance by the robust cost, and damping (`ESTIMATOR.md`, section 5).
//!
//! While the scale changes from pass to pass, costs are not comparable, and steps are undamped. These steps need no
//! damping: with weights that fall with the residual, the quadratic model of a pass is an upper bound of its cost.

use nalgebra::Vector5;

use crate::algebra::information::Information;
use crate::algebra::normal_equations::NormalEquations;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::MAX_RISE;

/// A pose with the sums of its pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Point<T: Scalar> {
    pub(super) pose: RectifyingRotations<T>,
    /// Sum of the steps from the start, rad.
    pub(super) moved: Vector5<T>,
    /// Normal equations, prior included.
    pub(super) joint: NormalEquations<T>,
    /// Robust cost, prior included, in variances.
    pub(super) cost: T,
}

impl<T: Scalar> Point<T> {
    /// Returns the point of a pass.
    ///
    /// * `moved`: sum of the steps from the start, rad; `normal`, `cost`: normal equations and robust cost of the pass,
    ///   without the prior; `prior`: prior information, about the start, 1/rad^2.
    pub(super) fn of(
        pose: &RectifyingRotations<T>,
        moved: &Vector5<T>,
        normal: &NormalEquations<T>,
        cost: T,
        prior: &Information<T>,
    ) -> Self {
        let pull = prior.times(moved);
        let mut joint = normal.with(prior);
        joint.gradient += pull;
        Self { pose: *pose, moved: *moved, joint, cost: cost + moved.dot(&pull) * T::HALF }
    }
}

/// Descent at a fixed scale.
#[derive(Debug, Clone)]
pub(super) struct Descent<T: Scalar> {
    /// The last accepted point at this scale; `None` while the scale changes.
    pub(super) best: Option<Point<T>>,
    /// Damping relative to the diagonal of the information, dimensionless.
    pub(super) damping: T,
}

impl<T: Scalar> Descent<T> {
    pub(super) const NEW: Self = Self { best: None, damping: T::ZERO };

    /// Returns the last accepted point if `here` exceeds its cost by more than [`MAX_RISE`]; `None` if `here` is
    /// acceptable, or if there is no accepted point.
    pub(super) fn rejects(&self, here: &Point<T>) -> Option<Point<T>> {
        // Negated `<=`, so that a NaN cost is rejected.
        self.best.filter(|best| !(here.cost <= best.cost + T::lit(MAX_RISE)))
    }

    /// Accepts a point. The next pass must have the same scale. The next step is undamped.
    pub(super) fn accept(&mut self, here: Point<T>) {
        *self = Self { best: Some(here), damping: T::ZERO };
    }

    /// Raises the damping after a rejection: to 1, 3, 7 and so on.
    pub(super) fn damp(&mut self) {
        self.damping = T::lit(2.0) * self.damping + T::ONE;
    }

    /// Forgets the accepted point and the damping, because the scale changes.
    pub(super) fn restart(&mut self) {
        *self = Self::NEW;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(cost: f64) -> Point<f64> {
        let pose = RectifyingRotations::SIDE_BY_SIDE;
        let moved = Vector5::zeros();
        Point { pose, moved, joint: NormalEquations::ZERO, cost }
    }

    #[test]
    fn a_clearly_higher_cost_is_rejected() {
        let mut descent = Descent::NEW;
        assert!(descent.rejects(&point(f64::INFINITY)).is_none(), "no point to compare with");
        descent.accept(point(10.0));
        assert_eq!(descent.rejects(&point(13.7)).map(|best| best.cost), Some(10.0));
        assert!(descent.rejects(&point(f64::NAN)).is_some());
        for cost in [13.6, 10.0, 9.0] {
            assert!(descent.rejects(&point(cost)).is_none(), "{cost}");
        }
    }

    #[test]
    fn damping_begins_at_zero_rises_with_rejections_and_ends_with_an_acceptance() {
        let mut descent = Descent::<f64>::NEW;
        assert_eq!(descent.damping, 0.0);
        for expected in [1.0, 3.0, 7.0] {
            descent.damp();
            assert_eq!(descent.damping, expected);
        }
        descent.accept(point(1.0));
        assert_eq!(descent.damping, 0.0);
    }

    #[test]
    fn the_cost_of_the_prior_rises_with_the_distance_from_the_start() {
        let prior = Information(crate::algebra::symmetric5::Symmetric5::of_diagonal([100.0; 5]));
        let moved = Vector5::new(0.1, 0.0, 0.0, -0.2, 0.0);
        let pose = RectifyingRotations::SIDE_BY_SIDE;
        let here = Point::of(&pose, &moved, &NormalEquations::ZERO, 3.0, &prior);
        let expected: f64 = 3.0 + 0.5 * 100.0 * 0.05;
        assert!((here.cost - expected).abs() < 1e-12);
        assert_eq!(here.joint.gradient, moved * 100.0);
    }
}
