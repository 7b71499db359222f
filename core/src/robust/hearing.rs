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

#[cfg(test)]
mod tests {
    use super::super::tally::Tally;
    use super::super::weight::tukey;
    use super::*;
    use crate::correspondence::RayPair;
    use crate::lanes::Single;
    use crate::residual::row_offset;
    use crate::residual::tests::pose;

    const FOCAL: f64 = 500.0;
    const NOISE: f64 = 0.4;

    #[test]
    fn correspondences_are_counted_compared_and_weighed_as_defined() {
        let outlook = Outlook {
            focal: FOCAL,
            noise_floor: 0.1,
            needed: 8,
            start: pose([0.002, 0.0, -0.001], [0.0, 0.003]),
            pose: pose([0.01, -0.02, 0.03], [0.02, -0.01]),
            noise: NOISE,
            leverage: None,
            fitted: 0.0,
            min_disparity: -0.008,
        };
        let bench = Bench::of(Single, &outlook);
        let mut hearing = Hearing::nothing(Single);
        let (mut within, mut near_squares, mut screened) = ([0; 3], 0.0, 0);
        let (mut cost, mut squares, mut weights) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        let (mut added, mut behind) = (0, 0);
        for i in 0..200_u32 {
            // Rows up to 4 px apart, some behind infinity, every third one on a grid.
            let k = f64::from(i);
            let [u, v] = [(0.37 * k).sin() * 0.6, (0.73 * k).cos() * 0.4];
            let [d, e] = [(0.11 * k).sin() * 0.05 + 0.03, (0.057 * k).sin() * 0.008];
            let grid_step = if i % 3 == 0 { 1.5 } else { 0.0 };
            let l = outlook.pose.left().inverse() * nalgebra::Vector3::new(u, v, 1.0);
            let r = outlook.pose.right().inverse() * nalgebra::Vector3::new(u - d, v + e, 1.0);
            let [left, right] = [l, r].map(|ray| [ray.x / ray.z, ray.y / ray.z]);
            let rays = [left, right].as_flattened().try_into().unwrap();
            let judged = hearing.judge(Single, &bench, rays, grid_step);

            let pair = RayPair::try_new(left, right).unwrap();
            let frame = Frame::at(Single, &outlook.pose);
            let (Constraint { value, variance, .. }, _) = Constraint::of(Single, &frame, rays);
            let deviation = FOCAL * value / variance.sqrt();
            let expected = NOISE * NOISE + grid_step * grid_step / 12.0;
            let unit = expected.sqrt().max(0.6 * grid_step);
            for (count, units) in within.iter_mut().zip([2.0, 3.0, 4.0]) {
                *count += u32::from(deviation.abs() < units * unit);
            }
            if deviation.abs() < 2.0 * unit {
                near_squares += deviation * deviation / 0.7737 - grid_step * grid_step / 12.0;
            }
            let offsets = [&outlook.start, &outlook.pose].map(|p| row_offset(p, &pair).unwrap());
            let most = 2.0 * (TUKEY * unit / FOCAL).powi(2);
            let fits = deviation.abs() <= TUKEY * unit;
            screened += u32::from(fits);
            for ((cost, squares), e) in cost.iter_mut().zip(&mut squares).zip(offsets) {
                *cost += (e * e).min(most);
                *squares += if fits { e * e } else { 0.0 };
            }
            let w = tukey(Single, (deviation / (TUKEY * unit)).powi(2)) / expected;
            behind += u32::from(d < -0.008);
            let Some((row, seen)) = judged else {
                assert!(d < -0.008 || w == 0.0, "{d} {w}");
                continue;
            };
            assert!(d >= -0.008 && w > 0.0, "{d} {w}");
            added += 1;
            weights = [weights[0] + w, weights[1] + w * expected];
            let whole = w * FOCAL * FOCAL / variance;
            assert!((row.weight / whole - 1.0).abs() < 1e-9 && seen.weight == row.weight);
            assert!((row.value - value).abs() < 1e-15 && seen.products[0] == row.value);
        }
        assert!(added > 80 && added < 160 && behind > 5, "{added} {behind}");
        let tally = Tally::of(Single, 203, &hearing.tallies);
        assert_eq!((tally.usable, tally.skipped), (200, 3));
        assert_eq!((tally.within, tally.screened), (within, screened));
        let sums = [tally.near_squares, tally.cost[0], tally.cost[1], tally.squares[0]];
        let sums = sums.into_iter().chain([tally.squares[1]]).chain(hearing.weights);
        let expected = [near_squares, cost[0], cost[1], squares[0], squares[1]];
        for (sum, expected) in sums.zip(expected.into_iter().chain(weights)) {
            assert!((sum / expected - 1.0).abs() < 1e-9, "{sum} {expected}");
        }
    }
}
