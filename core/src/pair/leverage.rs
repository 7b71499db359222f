//! Limit on the leverage of single correspondences on the baseline (`ESTIMATOR.md`, section 6).
//!
//! An outlier with a large disparity near its epipolar line fits any pose, and has the residual of a near point. So its
//! share of the information on the baseline is limited. The image bounds the share of the information on `R`.

use crate::algebra::symmetric5::Symmetric5;
use crate::scalar::Scalar;
use crate::thresholds::{FIRST_MAX_LEVERAGE, MAX_LEVERAGE, MIN_SEPARATION, PEAK_DEVIATIONS};

/// Limit on a correspondence's share of the information on the baseline, dimensionless.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leverage<T> {
    /// Covariance of the baseline: forward, mixed, down, rad^2.
    covariance: [T; 3],
    /// Largest share that keeps its full weight.
    limit: T,
    /// Share above which leverage is high: the first limit of a track, which follows the covariance.
    high: T,
}

/// Correspondences of high leverage in a pass, one class: a few near points before a far scene, or outliers.
#[derive(Debug, Clone, Copy)]
pub(super) struct HighLeverage<T> {
    /// Residuals within 2 units of the loss, and from 2 to 4.
    pub(super) bands: [T; 2],
    /// Square roots of the shares of those within 2 units, and the inverses of the roots, summed.
    pub(super) roots: T,
    pub(super) inverse_roots: T,
}

impl<T: Scalar> HighLeverage<T> {
    pub(super) const NONE: Self =
        Self { bands: [T::ZERO; 2], roots: T::ZERO, inverse_roots: T::ZERO };

    /// Adds the root of the share of a residual within 2 units.
    #[inline(always)]
    pub(super) fn add(&mut self, share: T) {
        let root = share.sqrt();
        self.roots += root;
        self.inverse_roots += T::ONE / root;
    }

    /// Square of the mean root share of those within 2 units. `None` unless they are inliers, and a class of their own:
    /// the harmonic mean root, which few large shares do not move, is far above the least.
    ///
    /// * `least`: share of high leverage; `trusted`: whether they were inliers in the last pairs.
    fn inlier_share(&self, least: T, trusted: bool) -> Option<T> {
        let [near, _] = self.bands;
        let [mean, harmonic] =
            [self.roots / near, near / self.inverse_roots].map(|root| root * root);
        let are_inliers = near > T::ZERO && (trusted || form_peak(self.bands));
        (are_inliers && harmonic > T::lit(MIN_SEPARATION) * least).then_some(mean)
    }
}

/// Whether residuals within 2 units exceed those from 2 to 4 by [`PEAK_DEVIATIONS`] of chance. Outliers fill
/// both bands alike.
pub(crate) fn form_peak<T: Scalar>([near, beside]: [T; 2]) -> bool {
    near - beside > T::lit(PEAK_DEVIATIONS) * (near + beside).sqrt()
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
        let covariance = baseline_block(covariance);
        let mean = trace(&covariance, &baseline_block(information)) / weighted.max(T::ONE);
        let limit = T::lit(MAX_LEVERAGE) * mean;
        let covariance = covariance.map(|c| c * growth);
        limit.is_finite().then_some(Self { covariance, limit, high: limit })
    }

    /// The limit after a step of a track: where correspondences of high leverage are inliers,
    /// [`MAX_LEVERAGE`] of their shares. `None` where it is not finite.
    ///
    /// * `information`: as in [`Self::of`]; `last`, `high`: limit of the pass, and its correspondences of high
    ///   leverage.
    /// * `trusted`: whether they were inliers in the last pairs.
    pub(super) fn raised(
        self,
        information: &Symmetric5<T>,
        last: &Self,
        high: &HighLeverage<T>,
        trusted: bool,
    ) -> Option<Self> {
        let block = baseline_block(information);
        // Shares of the pass are of the covariance before the step.
        let scale = trace(&self.covariance, &block) / trace(&last.covariance, &block);
        let share = high.inlier_share(last.high, trusted).unwrap_or(T::ZERO);
        let limit = (T::lit(MAX_LEVERAGE) * share * scale).max(self.limit);
        limit.is_finite().then_some(Self { limit, high: last.high * scale, ..self })
    }

    /// Limit before the first step of a track: [`FIRST_MAX_LEVERAGE`] median shares. `None` where it is not finite.
    ///
    /// * `median`: of the shares of a sample.
    pub(super) fn first(median: T, covariance: &Symmetric5<T>) -> Option<Self> {
        let limit = T::lit(FIRST_MAX_LEVERAGE) * median;
        let covariance = baseline_block(covariance);
        limit.is_finite().then_some(Self { covariance, limit, high: limit })
    }

    /// Factor of a weight: 1 up to the limit, beyond it `(limit / share)^2`.
    ///
    /// * `w`: `w f^2 / V`; `jacobian`: derivatives of the constraint, 1/rad.
    #[inline(always)]
    pub(super) fn factor(&self, w: T, jacobian: &[T; 5]) -> Limited<T> {
        let share = share(&self.covariance, w, jacobian);
        if self.limit < share {
            let excess = self.limit / share;
            Limited { factor: excess * excess, share }
        } else {
            Limited { factor: T::ONE, share }
        }
    }

    /// Whether leverage is high.
    pub(super) fn is_high(&self, share: T) -> bool {
        self.high < share
    }

    /// Whether matches of high leverage form a class of their own.
    pub(super) fn is_separate(&self, share: T) -> bool {
        T::lit(MIN_SEPARATION) * self.high < share
    }
}

/// Effect of a limit on a correspondence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limited<T> {
    /// Factor of the weight.
    pub(super) factor: T,
    /// Share of the information on the baseline, without the limit.
    pub(super) share: T,
}

/// Trace of the product of two baseline blocks.
fn trace<T: Scalar>([a, b, c]: &[T; 3], [x, y, z]: &[T; 3]) -> T {
    *a * *x + *b * *y + *b * *y + *c * *z
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
pub(super) fn share<T: Scalar>([a, b, c]: &[T; 3], w: T, jacobian: &[T; 5]) -> T {
    let [.., y, z] = *jacobian;
    w * (y * (*a * y + *b * z) + z * (*b * y + *c * z))
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let shares = rows.iter().map(|j| share(&baseline_block(&covariance), 2.0, j));
        let mean = shares.sum::<f64>() / 40.0;
        assert!((leverage.limit / (MAX_LEVERAGE * mean) - 1.0).abs() < 1e-12);
        // The shares of all five unknowns add up to 5; two of them are the baseline's.
        assert!(mean * 40.0 >= 2.0 - 1e-12, "{mean}");
        let [j, ..] = rows;
        let [.., y, z] = j;
        let m = covariance.matrix();
        let form = y * y * m.m44 + 2.0 * y * z * m.m54 + z * z * m.m55;
        assert!((share(&baseline_block(&covariance), 2.0, &j) - 2.0 * form).abs() < 1e-15);
    }

    #[test]
    fn beyond_the_limit_a_weight_falls_with_the_square_and_a_growing_variance_cancels() {
        let (_, held, covariance) = rows();
        let leverage = Leverage::of(&held, 40.0, &covariance, 1.0).unwrap();
        let j = [1.0, 0.0, 0.0, 0.2, 1.0];
        let at_limit = leverage.limit / share(&leverage.covariance, 1.0, &j);
        for (excess, left) in [(0.5, 1.0), (1.0 - 1e-9, 1.0), (2.0, 0.25), (10.0, 0.01)] {
            let got = leverage.factor(excess * at_limit, &j).factor;
            assert!((got - left).abs() < 1e-6, "{excess}: {got}");
            // Weights are inverse to the variance of a residual.
            let grown = Leverage::of(&held, 40.0, &covariance, 3.0).unwrap();
            let same = grown.factor(excess * at_limit / 3.0, &j).factor;
            assert!((same - left).abs() < 1e-6, "{excess}: {same}");
        }
        assert_eq!(leverage.factor(0.0, &j).factor, 1.0);
    }

    /// Residuals within 2 units, of these shares, and so many from 2 to 4.
    fn high(shares: &[f64], beside: f64) -> HighLeverage<f64> {
        let mut high = HighLeverage::NONE;
        high.bands = [0.0, beside];
        for share in shares {
            let [near, _] = &mut high.bands;
            *near += 1.0;
            high.add(*share);
        }
        high
    }

    #[test]
    fn the_limit_rises_for_a_class_that_forms_a_peak_and_not_for_a_flat_one() {
        let (_, held, covariance) = rows();
        let first = Leverage::first(1e-3, &covariance).unwrap();
        let limit = Leverage::of(&held, 40.0, &covariance, 1.0).unwrap();
        let share = 100.0 * limit.limit.max(first.high);
        let raised = |near: usize, beside, trusted| {
            let high = high(&[share; 20][..near], beside);
            limit.raised(&held, &first, &high, trusted).unwrap().limit
        };
        let expected = MAX_LEVERAGE * share;
        for (near, beside) in [(10, 0.0), (20, 3.0)] {
            assert!(
                (raised(near, beside, false) / expected - 1.0).abs() < 1e-12,
                "{near} {beside}"
            );
        }
        // No more than chance; none at all.
        for (near, beside) in [(9, 0.0), (20, 20.0), (20, 7.0), (0, 0.0)] {
            assert_eq!(raised(near, beside, false), limit.limit, "{near} {beside}");
        }
        // One near point, of a class that was one of inliers in the last pairs.
        assert!((raised(1, 0.0, true) / expected - 1.0).abs() < 1e-12);
        assert_eq!(raised(0, 3.0, true), limit.limit);
    }

    #[test]
    fn the_limit_does_not_rise_for_the_tail_of_one_range_of_depths_with_an_outlier_in_it() {
        let (_, held, covariance) = rows();
        let first = Leverage::first(1.0, &covariance).unwrap();
        let limit = Leverage::of(&held, 40.0, &covariance, 1.0).unwrap();
        let raised =
            |shares: &[f64]| limit.raised(&held, &first, &high(shares, 0.0), true).unwrap().limit;
        let mut tail = [2.0 * first.high; 20];
        assert_eq!(raised(&tail), limit.limit);
        tail[7] = 1e4 * first.high;
        assert_eq!(raised(&tail), limit.limit);
        assert!(raised(&[1.01 * MIN_SEPARATION * first.high; 20]) > limit.limit);
    }

    #[test]
    fn the_class_of_high_leverage_follows_the_covariance() {
        let (_, held, covariance) = rows();
        let first = Leverage::first(1e-3, &covariance).unwrap();
        assert_eq!((first.limit, first.high), (FIRST_MAX_LEVERAGE * 1e-3, first.limit));
        let mut narrower = covariance;
        narrower.0.iter_mut().for_each(|c| *c *= 0.25);
        let limit = Leverage::of(&held, 40.0, &narrower, 1.0).unwrap();
        let next = limit.raised(&held, &first, &HighLeverage::NONE, false).unwrap();
        assert!((next.high / first.high - 0.25).abs() < 1e-12);
        // A raised limit falls as well: the pass took its shares with the covariance before the step.
        let large = 100.0 * limit.limit.max(first.high);
        let raised = limit.raised(&held, &first, &high(&[large; 20], 0.0), false).unwrap();
        assert!((raised.limit / (MAX_LEVERAGE * large) - 0.25).abs() < 1e-12);
        // The same correspondences are of high leverage before and after.
        let j = [0.3, 0.0, 0.0, 0.2, 1.0];
        let at_limit = first.limit / share(&first.covariance, 1.0, &j);
        for (excess, is_high) in [(0.999, false), (1.001, true)] {
            for leverage in [&first, &next] {
                let limited = leverage.factor(excess * at_limit, &j);
                assert_eq!(leverage.is_high(limited.share), is_high);
            }
        }
    }
}
