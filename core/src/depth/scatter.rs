//! Scatter of the yaw of the rows from pair to pair, learnt from the pairs (`ESTIMATOR.md`, section 20).
//!
//! A lens that its model does not describe moves the yaw from scene to scene, on one recorded rig four times as far as on others.
//! Half the squared difference of neighbours has the variance of scatter and noise as its mean, and a mount that drifts
//! hardly adds to it: the mean square successive difference of von Neumann, Kent, Bellinson and Hart (1941). A knock is
//! one large difference, so each counts up to [`SIGNIFICANT`] deviations.

use super::yaw::RowsYaw;
use crate::scalar::Scalar;
use crate::thresholds::{SCATTER_PAIRS, SIGNIFICANT};

/// Running mean of the variance of the scatter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Scatter<T> {
    /// The mean, rad^2.
    variance: T,
    /// Number of pairs without noise of their own that would tell as much.
    pairs: T,
    /// The pair before.
    last: Option<RowsYaw<T>>,
}

impl<T: Scalar> Scatter<T> {
    /// Returns the state before any pair.
    pub(super) const fn new() -> Self {
        Self { variance: T::ZERO, pairs: T::ZERO, last: None }
    }

    /// Returns the variance of the scatter, rad^2.
    ///
    /// * `least`: the least variance, which holds before the first pair, rad^2.
    pub(super) fn variance(&self, least: T) -> T {
        self.variance.max(least)
    }

    /// Adds the yaw of one more pair and the variance of its noise. Both are finite, and their sum with the least
    /// variance is above 0.
    pub(super) fn add(&mut self, pair: &RowsYaw<T>, least: T) {
        let Some(last) = self.last.replace(*pair) else { return };
        let known = self.variance(least);
        let noise = (pair.variance + last.variance) * T::HALF;
        let off = pair.turn - last.turn;
        let most = T::lit(SIGNIFICANT * SIGNIFICANT) * (known + noise);
        let shown = (off * off * T::HALF).min(most) - noise;
        // The variance of `shown` is in proportion to `(known + noise)^2`.
        let share = known / (known + noise);
        let weight = share * share;
        let [first, memory] = SCATTER_PAIRS.map(T::lit);
        self.pairs = (self.pairs.max(first) + weight).min(memory);
        self.variance = known + (shown - known) * (weight / self.pairs);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::algebra::normal_equations::tests::normal;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    const NOISE: f64 = 3e-4;
    const LEAST: f32 = 1e-8;

    /// Scatter after 300 pairs, rad, root mean square over 40 runs.
    fn learnt(scatter: f64, turn: impl Fn(u32) -> f64) -> f64 {
        learnt_with(scatter, |_| NOISE, turn)
    }

    /// The same, with the noise that each pair states, rad.
    fn learnt_with(scatter: f64, stated: impl Fn(u32) -> f64, turn: impl Fn(u32) -> f64) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut normal = || normal(&mut rng);
        let mut run = || {
            let mut found = Scatter::<f32>::new();
            for pair in 0..300 {
                let yaw = turn(pair) + scatter * normal() + NOISE * normal();
                let variance = f32::lit(stated(pair) * stated(pair));
                found.add(&RowsYaw { turn: f32::lit(yaw), variance }, LEAST);
            }
            f64::from(found.variance(LEAST))
        };
        ((0..40).map(|_| run()).sum::<f64>() / 40.0).sqrt()
    }

    #[test]
    fn the_scatter_is_learnt_whether_the_mount_rests_or_drifts() {
        for scatter in [6e-4, 2e-3] {
            for rate in [0.0, 1e-5, 3e-4] {
                let found = learnt(scatter, |pair| rate * f64::from(pair)) / scatter;
                assert!((found - 1.0).abs() < 0.15, "{scatter} {rate}: {found}");
            }
        }
    }

    #[test]
    fn noise_is_no_scatter_and_the_least_one_stays() {
        let found = learnt(0.0, |_| 0.0);
        assert!(found < 0.6 * NOISE, "{found}");
        assert_eq!(Scatter::<f32>::new().variance(LEAST), LEAST);
    }

    #[test]
    fn a_knock_counts_as_one_large_difference() {
        let knocked = |pair| if pair < 290 { 0.0 } else { 0.05 };
        let found = learnt(1e-3, knocked) / 1e-3;
        assert!(found > 1.0 && found < 1.3, "{found}");
    }

    #[test]
    fn pairs_that_state_too_much_noise_hardly_count() {
        let stated = |pair| if pair % 8 < 4 { 4e-3 } else { NOISE };
        let found = learnt_with(2e-3, stated, |_| 0.0) / 2e-3;
        assert!((found - 1.0).abs() < 0.25, "{found}");
    }
}
