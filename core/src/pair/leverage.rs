//! Limit on the leverage of single correspondences on the baseline (`ESTIMATOR.md`, section 6).
//!
//! An outlier with a large disparity near its epipolar line has a small residual at any pose, like a near point.
//! Therefore this module limits the share of each correspondence in the information on the baseline. The share in the
//! information on `R` needs no limit, because the field of view bounds it.

use crate::algebra::symmetric5::Symmetric5;
use crate::scalar::Scalar;
use crate::thresholds::{FIRST_MAX_LEVERAGE, MAX_LEVERAGE, MIN_SEPARATION, SIGNIFICANT};

/// Limit on a correspondence's share of the information on the baseline, dimensionless.
#[derive(Debug, Clone, Copy)]
pub(super) struct Leverage<T> {
    /// Covariance of the baseline, rad^2: forward variance, covariance, down variance. [`Self::of`] multiplies it by
    /// the growth of the residual variance.
    covariance: [T; 3],
    /// Largest share at which a correspondence keeps its full weight.
    limit: T,
    /// Share above which leverage is high. In a track this is the first limit, rescaled as the covariance changes; in a
    /// search it equals `limit`.
    high: T,
}

/// Correspondences of high leverage in a pass. They are judged as one class: either a few near points before a far
/// scene, or outliers.
#[derive(Debug, Clone, Copy)]
pub(super) struct HighLeverage<T> {
    /// Numbers of residuals below 2 units of the loss, and from 2 to 4 units.
    pub(super) bands: [T; 2],
    /// Sum of the square roots of the shares of the correspondences with residuals within 2 units.
    pub(super) roots: T,
    /// Sum of the inverses of these square roots.
    pub(super) inverse_roots: T,
}

impl<T: Scalar> HighLeverage<T> {
    pub(super) const NONE: Self =
        Self { bands: [T::ZERO; 2], roots: T::ZERO, inverse_roots: T::ZERO };

    /// Adds the share of a correspondence whose residual is within 2 units.
    #[inline(always)]
    pub(super) fn add(&mut self, share: T) {
        let root = share.sqrt();
        self.roots += root;
        self.inverse_roots += T::ONE / root;
    }

    /// Returns the squared mean of the root shares of the correspondences with residuals within 2 units. `None` unless
    /// these correspondences are inliers and form a class of their own. They are inliers if `trusted`, or if they form
    /// a peak ([`form_peak`]). They form a class if the squared harmonic mean of their root shares is above
    /// [`MIN_SEPARATION`] times `least`. A few large shares hardly change the harmonic mean.
    ///
    /// * `least`: share above which leverage is high; `trusted`: whether correspondences of high leverage were inliers
    ///   in the last pairs.
    fn inlier_share(&self, least: T, trusted: bool) -> Option<T> {
        let [near, _] = self.bands;
        let [mean, harmonic] =
            [self.roots / near, near / self.inverse_roots].map(|root| root * root);
        let are_inliers = near > T::ZERO && (trusted || form_peak(self.bands));
        (are_inliers && harmonic > T::lit(MIN_SEPARATION) * least).then_some(mean)
    }
}

/// Returns whether the residuals within 2 units outnumber those from 2 to 4 units by [`SIGNIFICANT`] standard
/// deviations. Outliers fill both bands equally.
pub(crate) fn form_peak<T: Scalar>([near, beside]: [T; 2]) -> bool {
    near - beside > T::lit(SIGNIFICANT) * (near + beside).sqrt()
}

fn is_limit<T: Scalar>(limit: T) -> bool {
    limit > T::ZERO && limit.is_finite()
}

impl<T: Scalar> Leverage<T> {
    /// Returns the limit for the next pass, from the sums of this pass: [`MAX_LEVERAGE`] times the mean share of a
    /// weighted correspondence in the information on the baseline. `None` if the limit is not finite or not above 0: if
    /// no correspondence was weighted, a limit of 0 would leave the next pass without weights, too.
    ///
    /// * `information`: information of this pass, after its own limit on leverage, 1/rad^2.
    /// * `weighted`: number of correspondences that have a weight above 0 in this pass.
    /// * `covariance`: covariance of the pose after this pass, prior included, rad^2.
    /// * `growth`: residual variance of the next pass over that of this pass.
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
        is_limit(limit).then_some(Self { covariance, limit, high: limit })
    }

    /// Returns the limit after a step of a track. If the correspondences of high leverage are inliers and form a class
    /// of their own ([`HighLeverage::inlier_share`]), the limit is at least [`MAX_LEVERAGE`] times their mean share.
    /// `None` if the limit is not finite.
    ///
    /// * `information`: as in [`Self::of`]; `last`: limit of the pass; `high`: its correspondences of high leverage.
    /// * `trusted`: whether correspondences of high leverage were inliers in the last pairs.
    pub(super) fn raised(
        self,
        information: &Symmetric5<T>,
        last: &Self,
        high: &HighLeverage<T>,
        trusted: bool,
    ) -> Option<Self> {
        let block = baseline_block(information);
        // The shares of the pass were computed with the covariance before the step, so they are rescaled.
        let scale = trace(&self.covariance, &block) / trace(&last.covariance, &block);
        let share = high.inlier_share(last.high, trusted).unwrap_or(T::ZERO);
        let limit = (T::lit(MAX_LEVERAGE) * share * scale).max(self.limit);
        limit.is_finite().then_some(Self { limit, high: last.high * scale, ..self })
    }

    /// Returns the limit before the first step of a track: [`FIRST_MAX_LEVERAGE`] times the median share. `None` if the
    /// limit is not finite or not above 0.
    ///
    /// * `median`: median share of a sample; `covariance`: covariance of the pose, rad^2.
    pub(super) fn first(median: T, covariance: &Symmetric5<T>) -> Option<Self> {
        let limit = T::lit(FIRST_MAX_LEVERAGE) * median;
        let covariance = baseline_block(covariance);
        is_limit(limit).then_some(Self { covariance, limit, high: limit })
    }

    /// Returns the factor of a weight: 1 up to the limit, and `(limit / share)^2` beyond it.
    ///
    /// * `w`: `w f^2 / V`, dimensionless; `jacobian`: derivatives of the constraint, 1/rad.
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

    /// Returns whether a correspondence with this share has high leverage.
    pub(super) fn is_high(&self, share: T) -> bool {
        self.high < share
    }

    /// Returns whether a share is above [`MIN_SEPARATION`] times the share of high leverage. Such correspondences form
    /// a separate class.
    pub(super) fn is_separate(&self, share: T) -> bool {
        T::lit(MIN_SEPARATION) * self.high < share
    }
}

/// Effect of the limit on the weight of a correspondence.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limited<T> {
    /// Factor of the weight.
    pub(super) factor: T,
    /// Share of the information on the baseline before the limit.
    pub(super) share: T,
}

/// Returns the trace of the product of two baseline blocks.
fn trace<T: Scalar>([a, b, c]: &[T; 3], [x, y, z]: &[T; 3]) -> T {
    *a * *x + *b * *y + *b * *y + *c * *z
}

/// Returns the baseline block of a covariance or information matrix: forward, mixed and down elements.
pub(super) fn baseline_block<T: Scalar>(m: &Symmetric5<T>) -> [T; 3] {
    let h = &m.0;
    [h[9], h[13], h[14]]
}

/// Returns the share in the information on the baseline: `w J_b^T Q_b J_b`, dimensionless.
///
/// * `[a, b, c]`: `Q_b`, covariance of the baseline, rad^2; `w`: `w f^2 / V`, dimensionless.
#[inline(always)]
pub(super) fn share<T: Scalar>([a, b, c]: &[T; 3], w: T, jacobian: &[T; 5]) -> T {
    let [.., y, z] = *jacobian;
    w * (y * (*a * y + *b * z) + z * (*b * y + *c * z))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns rows of different leverage, their information, and the inverse of the information.
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
        // The shares add up to the trace of a block of the covariance times the same block of the information. This
        // trace is at least the size of the block, 2.
        assert!(mean * 40.0 >= 2.0 - 1e-12, "{mean}");
        let [j, ..] = rows;
        let [.., y, z] = j;
        let m = covariance.matrix();
        let form = y * y * m.m44 + 2.0 * y * z * m.m54 + z * z * m.m55;
        assert!((share(&baseline_block(&covariance), 2.0, &j) - 2.0 * form).abs() < 1e-15);
    }

    #[test]
    fn without_a_weighted_correspondence_there_is_no_limit() {
        let (_, _, covariance) = rows();
        assert!(Leverage::of(&Symmetric5::ZERO, 0.0, &covariance, 1.0).is_none());
        assert!(Leverage::first(0.0, &covariance).is_none());
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
            // At three times the residual variance, a weight is a third.
            let grown = Leverage::of(&held, 40.0, &covariance, 3.0).unwrap();
            let same = grown.factor(excess * at_limit / 3.0, &j).factor;
            assert!((same - left).abs() < 1e-6, "{excess}: {same}");
        }
        assert_eq!(leverage.factor(0.0, &j).factor, 1.0);
    }

    /// Returns a class of correspondences with the given shares and residuals within 2 units, and of `beside`
    /// correspondences with residuals from 2 to 4 units.
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
        // Three classes whose peak does not exceed chance, and one without near residuals.
        for (near, beside) in [(9, 0.0), (20, 20.0), (20, 7.0), (0, 0.0)] {
            assert_eq!(raised(near, beside, false), limit.limit, "{near} {beside}");
        }
        // One near point suffices if its class consisted of inliers in the last pairs.
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
        // A raised limit falls with the covariance too, because the shares of the pass belong to the covariance before
        // the step.
        let large = 100.0 * limit.limit.max(first.high);
        let raised = limit.raised(&held, &first, &high(&[large; 20], 0.0), false).unwrap();
        assert!((raised.limit / (MAX_LEVERAGE * large) - 0.25).abs() < 1e-12);
        // The same correspondences have high leverage before and after.
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
