//! The leverage that is held against single correspondences.

use crate::lanes::{Lanes, Value};
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;

/// Information on the baseline that a correspondence may carry, in mean shares.
const MAX_SHARE: f64 = 8.0;

/// The same in squares of the mean root, which mismatches can hardly move.
const MAX_ROOTS: f64 = 20.0;

/// What a correspondence's share of the information on the baseline is judged by: sums of the pass
/// before. Its share of that on `R` is bounded by the image.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leverage<T> {
    /// Of the baseline: forward, both, down.
    covariance: [T; 3],
    limit: T,
}

impl<T: Scalar> Leverage<T> {
    /// * `held`: information of a pass, as held down in it; `weighted`: correspondences in it.
    /// * `covariance`: of the pose, from that and the prior.
    /// * `growth`: of the variance that residuals are weighed by, from this pass to the next.
    pub(super) fn of(
        held: &Symmetric<T>,
        weighted: u32,
        covariance: &Symmetric<T>,
        growth: T,
    ) -> Option<Self> {
        let [a, b, c] = of_baseline(covariance);
        let [x, y, z] = of_baseline(held);
        let sum = a * x + b * y + b * y + c * z;
        let limit = T::lit(MAX_SHARE) * sum / T::count(weighted.max(1));
        let covariance = [a, b, c].map(|c| c * growth);
        limit.is_finite().then_some(Self { covariance, limit })
    }

    /// Before anything has been held down.
    ///
    /// * `mean_root`: of the shares by the covariance of the pose.
    pub(super) fn first(mean_root: T, covariance: &Symmetric<T>) -> Option<Self> {
        let limit = T::lit(MAX_ROOTS) * mean_root * mean_root;
        limit.is_finite().then_some(Self { covariance: of_baseline(covariance), limit })
    }

    /// For so many correspondences at a time.
    #[inline(always)]
    pub(super) fn beside<L: Lanes<T>>(&self, lanes: L) -> Leverage<L::Value> {
        let [a, b, c] = self.covariance;
        Leverage {
            covariance: [lanes.all(a), lanes.all(b), lanes.all(c)],
            limit: lanes.all(self.limit),
        }
    }
}

impl<V: Value> Leverage<V> {
    /// What is left of a weight `w`, as a part of it: falling with the square of the excess.
    #[inline(always)]
    pub(super) fn left_of<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        w: V,
        j: &[V; 5],
    ) -> V {
        let one = lanes.all(T::ONE);
        let share = share(lanes, &self.covariance, w, j);
        let over = lanes.below(self.limit, share);
        if !lanes.is_any(over) {
            return one;
        }
        let excess = self.limit / share;
        lanes.choose(over, excess * excess, one)
    }
}

/// The baseline's part of a covariance or an information: forward, both, down.
pub(super) fn of_baseline<T: Scalar>(m: &Symmetric<T>) -> [T; 3] {
    let h = &m.0;
    [h[9], h[13], h[14]]
}

/// Information on the baseline that a row of weight `w` carries, in units of what is known of it.
///
/// * `covariance`: of the baseline.
#[inline(always)]
pub(super) fn share<T: Scalar, L: Lanes<T>>(
    lanes: L,
    [a, b, c]: &[L::Value; 3],
    w: L::Value,
    jacobian: &[L::Value; 5],
) -> L::Value {
    let [.., y, z] = *jacobian;
    let (of_y, of_z) = (lanes.mul_add(*b, z, *a * y), lanes.mul_add(*c, z, *b * y));
    w * lanes.mul_add(z, of_z, y * of_y)
}
