//! What a judgement makes of a correspondence. Written once for one of them and for several side by side.

use super::TUKEY;
use super::constraint::{Constraint, Frame};
use super::outlook::Outlook;
use super::tallies::{Compared, Tallies};
use super::weighing::{Loss, Weighed, Weighing};
use super::weight::Spread;
use crate::lanes::{Lanes, Value};
use crate::moments::Seen;
use crate::scalar::Scalar;

/// What correspondences are judged by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bench<V> {
    by: Weighing<V>,
    start: Frame<V>,
}

/// What was heard so far, beside what the sums of the evidence hold.
#[derive(Debug, Clone, Copy)]
pub(super) struct Hearing<V> {
    pub(super) tallies: Tallies<V>,
    /// Of the weights, 1/px^2, and of the weights times the variance of a coordinate.
    pub(super) weights: [V; 2],
}

impl<V: Value> Bench<V> {
    #[inline(always)]
    pub(super) fn of<T: Scalar, L: Lanes<T, Value = V>>(lanes: L, outlook: &Outlook<T>) -> Self {
        Self { by: outlook.weighing(lanes, Loss::Polish), start: Frame::at(lanes, &outlook.start) }
    }
}

impl<V: Value> Hearing<V> {
    #[inline(always)]
    pub(super) fn nothing<T: Scalar, L: Lanes<T, Value = V>>(lanes: L) -> Self {
        Self { tallies: Tallies::zero(lanes), weights: [lanes.all(T::ZERO); 2] }
    }

    /// Counts correspondences; what they add to the sums, `None` if none of them adds anything.
    ///
    /// * `rays`: `x_l`, `y_l`, `x_r`, `y_r`, unit depth.
    /// * `grid_step`: px.
    #[inline(always)]
    pub(super) fn judge<T: Scalar, L: Lanes<T, Value = V>>(
        &mut self,
        lanes: L,
        Bench { by, start }: &Bench<V>,
        rays: [V; 4],
        grid_step: V,
    ) -> Option<(Weighed<V>, Seen<V>)> {
        let (constraint, in_front) = Constraint::of(lanes, &by.frame, rays);
        if !lanes.is_any(in_front) {
            return None;
        }
        let (at_start, in_front_before) = Constraint::of(lanes, start, rays);
        let spread = Spread::of(lanes, by.noise_squared, grid_step);
        let (value, offset) = (constraint.value, constraint.offset());
        let precision = by.precision(lanes, &constraint, in_front);
        let squared = value * value * precision;
        self.tallies.count(lanes, in_front, squared, &spread);
        let limit = lanes.all(T::lit(TUKEY * TUKEY)) * spread.unit_squared;
        let compared = Compared {
            before: at_start.offset() * at_start.offset(),
            after: offset * offset,
            in_front_before,
            most: lanes.all(T::lit(2.0)) * limit * by.unit_squared,
            fit: lanes.at_least(limit, squared),
        };
        self.tallies.compare(lanes, in_front, &compared);
        let ahead = lanes.both(in_front, constraint.has_disparity(lanes, by.min_disparity));
        let w = lanes.keep(ahead, spread.tukey(lanes, squared));
        if !lanes.is_any(lanes.below(lanes.all(T::ZERO), w)) {
            return None;
        }
        let jacobian = constraint.whole(lanes, &by.frame, value * precision * by.unit_squared);
        let w = match &by.leverage {
            Some(leverage) => w * leverage.left_of(lanes, w * precision, &jacobian),
            None => w,
        };
        let [sum, variances] = &mut self.weights;
        *sum = *sum + w;
        *variances = lanes.mul_add(w, spread.variance, *variances);
        let weight = w * precision;
        let seen = Seen { weight, products: constraint.products(lanes) };
        Some((Weighed { weight, value, jacobian }, seen))
    }
}
