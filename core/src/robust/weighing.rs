//! The inner loop: what a correspondence is worth in a pass. Written once for one of them and for
//! several side by side.

use super::TUKEY;
use super::constraint::{Constraint, Frame};
use super::leverage::Leverage;
use super::weight::{Spread, geman_mcclure, tukey};
use crate::lanes::{Lanes, Value};
use crate::scalar::Scalar;
use crate::symmetric::form;

/// The loss of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) enum Loss<V> {
    /// Geman-McClure at a scale: one over its square, 1/px^2.
    Anneal(V),
    /// Tukey, as wide as the estimate's own uncertainty (covariance, rad^2) asks for.
    Follow([V; 15]),
    /// Tukey at the noise.
    Polish,
}

/// What the correspondences of a pass are weighed with.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighing<V> {
    pub(super) frame: Frame<V>,
    pub(super) loss: Loss<V>,
    pub(super) leverage: Option<Leverage<V>>,
    /// Square of the focal length, px^2, and one over it.
    pub(super) focal_squared: V,
    pub(super) unit_squared: V,
    /// Of a coordinate, px^2.
    pub(super) noise_squared: V,
    /// Unit depth.
    pub(super) min_disparity: V,
}

/// A correspondence as it enters the sums.
#[derive(Debug, Clone, Copy)]
pub(super) struct Weighed<V> {
    /// What it counts, with high leverage held down: `f^2 / V` over px^2; zero: not at all.
    pub(super) weight: V,
    /// `C`.
    pub(super) value: V,
    /// Derivatives of `C / sqrt V`, times `sqrt V`.
    pub(super) jacobian: [V; 5],
}

/// Counts of a pass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Counts<V> {
    /// Correspondences in front of both cameras, those with a weight at all, and those within 2
    /// standard deviations.
    pub(super) usable: V,
    pub(super) weighted: V,
    pub(super) near: V,
    /// What of the squares of the near ones is not the grid's, px^2.
    pub(super) near_squares: V,
}

/// Correspondences at a pose.
struct Seen<'a, V, M> {
    constraint: &'a Constraint<V>,
    in_front: M,
    /// px^2, one over the variance of the constraint where that of a coordinate is 1 px^2.
    precision: V,
}

impl<V: Value> Weighing<V> {
    /// One over the variance of the constraint where that of a coordinate is 1 px^2, px^2. Behind a
    /// camera there may be none: what counts for nothing must not become no number.
    #[inline(always)]
    pub(super) fn precision<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        constraint: &Constraint<V>,
        in_front: L::Mask,
    ) -> V {
        self.focal_squared / lanes.choose(in_front, constraint.variance, lanes.all(T::ONE))
    }
}

impl<V: Value> Weighed<V> {
    #[inline(always)]
    pub(super) fn nothing<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let zero = lanes.all(T::ZERO);
        Self { weight: zero, value: zero, jacobian: [zero; 5] }
    }
}

impl<V: Value> Counts<V> {
    pub(super) fn zero<T: Scalar>(lanes: impl Lanes<T, Value = V>) -> Self {
        let zero = lanes.all(T::ZERO);
        Self { usable: zero, weighted: zero, near: zero, near_squares: zero }
    }

    /// The sums over the lanes.
    pub(super) fn total<T: Scalar>(&self, lanes: impl Lanes<T, Value = V>) -> Counts<T> {
        let Self { usable, weighted, near, near_squares } = *self;
        let [usable, weighted, near] = [usable, weighted, near].map(|count| lanes.total(count));
        Counts { usable, weighted, near, near_squares: lanes.total(near_squares) }
    }

    /// Counts and weighs correspondences; `None` if none of them counts.
    ///
    /// * `rays`: `x_l`, `y_l`, `x_r`, `y_r`, unit depth.
    /// * `grid_step`: px.
    #[inline(always)]
    pub(super) fn weigh<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        by: &Weighing<V>,
        rays: [V; 4],
        grid_step: V,
    ) -> Option<Weighed<V>> {
        let (constraint, in_front) = Constraint::of(lanes, &by.frame, rays);
        if !lanes.is_any(in_front) {
            return None;
        }
        let one = lanes.all(T::ONE);
        self.usable = self.usable + lanes.keep(in_front, one);
        let precision = by.precision(lanes, &constraint, in_front);
        let seen = Seen { constraint: &constraint, in_front, precision };
        let by_loss = self.by_loss(lanes, by, &seen, grid_step);
        let counts = lanes.below(lanes.all(T::ZERO), by_loss);
        if !lanes.is_any(counts) {
            return None;
        }
        self.weighted = self.weighted + lanes.keep(counts, one);
        let value = constraint.value;
        let jacobian = match by.loss {
            // The few steps of a track can do without: what they lead to is judged with it.
            Loss::Follow(_) => constraint.jacobian,
            Loss::Anneal(_) | Loss::Polish => {
                constraint.whole(lanes, &by.frame, value * precision * by.unit_squared)
            }
        };
        let weight = by_loss * precision;
        let weight = match &by.leverage {
            Some(leverage) => weight * leverage.left_of(lanes, weight, &jacobian),
            None => weight,
        };
        Some(Weighed { weight, value, jacobian })
    }

    /// What the loss makes of correspondences, 1/px^2.
    #[inline(always)]
    fn by_loss<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        by: &Weighing<V>,
        &Seen { constraint, in_front, precision }: &Seen<'_, V, L::Mask>,
        grid_step: V,
    ) -> V {
        let squared = constraint.value * constraint.value * precision;
        if let Loss::Anneal(scale) = &by.loss {
            return lanes.keep(in_front, geman_mcclure(lanes, squared * *scale) * *scale);
        }
        let ahead = lanes.both(in_front, constraint.has_disparity(lanes, by.min_disparity));
        if !lanes.is_any(ahead) {
            return lanes.all(T::ZERO);
        }
        let spread = Spread::of(lanes, by.noise_squared, grid_step);
        if let Loss::Follow(covariance) = &by.loss {
            let x = following(lanes, covariance, constraint, precision, &spread);
            return lanes.keep(ahead, tukey(lanes, x) / spread.variance);
        }
        let near = lanes.both(ahead, spread.is_within(lanes, T::lit(2.0), squared));
        self.near = self.near + lanes.keep(near, lanes.all(T::ONE));
        self.near_squares =
            self.near_squares + lanes.keep(near, spread.noise_squared(lanes, squared));
        lanes.keep(ahead, spread.tukey(lanes, squared))
    }
}

/// Square of a residual over that of Tukey's limit, where the estimate's own uncertainty adds to the
/// noise.
///
/// * `precision`: px^2, one over the variance of the constraint where a coordinate's is 1 px^2.
#[inline(always)]
pub(super) fn following<T: Scalar, L: Lanes<T>>(
    lanes: L,
    covariance: &[L::Value; 15],
    constraint: &Constraint<L::Value>,
    precision: L::Value,
    spread: &Spread<L::Value>,
) -> L::Value {
    let Constraint { value, jacobian, .. } = constraint;
    let of_pose = form(lanes, covariance, jacobian);
    let wide = lanes.mul_add(of_pose, precision, spread.unit_squared);
    *value * *value * precision / (wide * lanes.all(T::lit(TUKEY * TUKEY)))
}
