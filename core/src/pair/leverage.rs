//! Limit on the leverage of single correspondences on the baseline (`ESTIMATOR.md`, section 6).
//!
//! An outlier with a large disparity near its epipolar line fits any pose, and its residual is that of a near point:
//! its share of the information on the baseline is limited. The share of the information on `R` is bounded by the
//! image.

use crate::algebra::symmetric5::Symmetric5;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Value};
use crate::thresholds::{FIRST_MAX_LEVERAGE, MAX_LEVERAGE};

/// Limit on a correspondence's share of the information on the baseline, dimensionless.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leverage<T> {
    /// Covariance of the baseline: forward, mixed, down, rad^2.
    covariance: [T; 3],
    /// Largest share that keeps its full weight.
    limit: T,
}

impl<T: Scalar> Leverage<T> {
    /// Limit from the sums of the pass before: [`MAX_LEVERAGE`] mean shares. `None` where it is not finite.
    ///
    /// * `information`: of the pass, leverage limited, 1/rad^2; `weighted`: correspondences in it.
    /// * `covariance`: of the pose, prior included, rad^2.
    /// * `growth`: ratio of the residual variances of the next pass and of this one.
    pub(super) fn of(
        information: &Symmetric5<T>,
        weighted: T,
        covariance: &Symmetric5<T>,
        growth: T,
    ) -> Option<Self> {
        let [a, b, c] = baseline_block(covariance);
        let [x, y, z] = baseline_block(information);
        let sum = a * x + b * y + b * y + c * z;
        let limit = T::lit(MAX_LEVERAGE) * sum / weighted.max(T::ONE);
        let covariance = [a, b, c].map(|c| c * growth);
        limit.is_finite().then_some(Self { covariance, limit })
    }

    /// Limit before the first step of a track: [`FIRST_MAX_LEVERAGE`] median shares. `None` where it is not finite.
    ///
    /// * `median`: of the shares of a sample.
    pub(super) fn first(median: T, covariance: &Symmetric5<T>) -> Option<Self> {
        let limit = T::lit(FIRST_MAX_LEVERAGE) * median;
        limit.is_finite().then_some(Self { covariance: baseline_block(covariance), limit })
    }

    /// The same limit in every lane.
    #[inline(always)]
    pub(super) fn splat<L: Lanes<T>>(&self, lanes: L) -> Leverage<L::Value> {
        let [a, b, c] = self.covariance;
        Leverage {
            covariance: [lanes.splat(a), lanes.splat(b), lanes.splat(c)],
            limit: lanes.splat(self.limit),
        }
    }
}

impl<V: Value> Leverage<V> {
    /// Factor of a weight: 1 up to the limit, beyond it `(limit / share)^2`.
    ///
    /// * `w`: `w f^2 / V`; `jacobian`: derivatives of the constraint, 1/rad.
    #[inline(always)]
    pub(super) fn factor<T: Scalar, L: Lanes<T, Value = V>>(
        &self,
        lanes: L,
        w: V,
        jacobian: &[V; 5],
    ) -> V {
        let one = lanes.splat(T::ONE);
        let share = share(lanes, &self.covariance, w, jacobian);
        let over = lanes.lt(self.limit, share);
        if !lanes.any(over) {
            return one;
        }
        let excess = self.limit / share;
        lanes.select(over, excess * excess, one)
    }
}

/// Baseline block of a covariance or an information: forward, mixed, down.
pub(super) fn baseline_block<T: Scalar>(m: &Symmetric5<T>) -> [T; 3] {
    let h = &m.0;
    [h[9], h[13], h[14]]
}

/// Share of the information on the baseline: `w J_b^T Q_b J_b`, dimensionless.
///
/// * `[a, b, c]`: `Q_b`, covariance of the baseline, rad^2; `w`: `w f^2 / V`.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simd::Single;

    /// Rows of different leverage, their information and its inverse.
    fn rows() -> ([[f64; 5]; 40], Symmetric5<f64>, Symmetric5<f64>) {
        let rows: [[f64; 5]; 40] = core::array::from_fn(|i| {
            let k = f64::from(u8::try_from(i).unwrap());
            [1.0 + 0.1 * k.sin(), k.cos(), (2.0 * k).sin(), 0.3 * (3.0 * k).cos(), (0.7 * k).sin()]
        });
        let mut held = Symmetric5::ZERO;
        for j in &rows {
            held.add_outer(2.0, j);
        }
        (rows, held, held.inverse().unwrap())
    }

    #[test]
    fn the_limit_is_so_many_mean_shares_of_the_information_on_the_baseline() {
        let (rows, held, covariance) = rows();
        let leverage = Leverage::of(&held, 40.0, &covariance, 1.0).unwrap();
        let shares = rows.iter().map(|j| share(Single, &baseline_block(&covariance), 2.0, j));
        let mean = shares.sum::<f64>() / 40.0;
        assert!((leverage.limit / (MAX_LEVERAGE * mean) - 1.0).abs() < 1e-12);
        // The shares of all five unknowns add up to 5; two of them are the baseline's.
        assert!(mean * 40.0 >= 2.0 - 1e-12, "{mean}");
        let [j, ..] = rows;
        let [.., y, z] = j;
        let m = covariance.matrix();
        let form = y * y * m.m44 + 2.0 * y * z * m.m54 + z * z * m.m55;
        assert!((share(Single, &baseline_block(&covariance), 2.0, &j) - 2.0 * form).abs() < 1e-15);
    }

    #[test]
    fn beyond_the_limit_a_weight_falls_with_the_square_and_a_growing_variance_cancels() {
        let (_, held, covariance) = rows();
        let leverage = Leverage::of(&held, 40.0, &covariance, 1.0).unwrap();
        let j = [1.0, 0.0, 0.0, 0.2, 1.0];
        let at_limit = leverage.limit / share(Single, &leverage.covariance, 1.0, &j);
        for (excess, left) in [(0.5, 1.0), (1.0 - 1e-9, 1.0), (2.0, 0.25), (10.0, 0.01)] {
            let got = leverage.factor(Single, excess * at_limit, &j);
            assert!((got - left).abs() < 1e-6, "{excess}: {got}");
            // Weights are inverse to the variance of a residual.
            let grown = Leverage::of(&held, 40.0, &covariance, 3.0).unwrap();
            let same = grown.factor(Single, excess * at_limit / 3.0, &j);
            assert!((same - left).abs() < 1e-6, "{excess}: {same}");
        }
        assert_eq!(leverage.factor(Single, 0.0, &j), 1.0);
    }
}
