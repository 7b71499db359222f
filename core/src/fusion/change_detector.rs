//! Change detection: changes of the rig below the noise of a single pair (`ESTIMATOR.md`, section 14).
//!
//! The detector applies score tests to two exponential windows.

use nalgebra::Vector5;

use super::hypothesis::Hypothesis;
use crate::algebra::information::Information;
use crate::algebra::moments::Moments;
use crate::algebra::normal_equations::NormalEquations;
use crate::config::Context;
use crate::pair::evaluate::PairMeasurement;
use crate::scalar::Scalar;
use crate::thresholds::{LONG_DECAY, MAX_NIS, SHORT_DECAY, SHORT_PAIRS, WARM_UP_PAIRS};

/// Two windows over the last pairs.
#[derive(Debug, Clone)]
pub(super) struct ChangeDetector<T: Scalar> {
    /// Moments of the short window, in the frame of the sums of the hypothesis.
    short: Moments<T>,
    /// Covariance of the gradient of the short window, 1/rad^2. It decays by the square of the window's factor, because
    /// the gradient decays by this factor.
    short_variance: Information<T>,
    /// Normal equations of the long window, about the pose of the hypothesis.
    long: NormalEquations<T>,
    /// Covariance of the gradient of the long window, 1/rad^2.
    long_variance: Information<T>,
    /// Number of pairs in the windows since their last restart.
    pairs: u32,
    /// Whether the sums of the hypothesis may still hold pairs from before the last change.
    is_mixed: bool,
}

/// Finding after a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Finding {
    /// All pairs agree.
    Same,
    /// The rig has changed.
    Changed,
    /// The short window holds only pairs after a change, but the sums still hold earlier pairs.
    Settled,
}

impl<T: Scalar> ChangeDetector<T> {
    pub(super) const NEW: Self = Self {
        short: Moments::ZERO,
        short_variance: Information::ZERO,
        long: NormalEquations::ZERO,
        long_variance: Information::ZERO,
        pairs: 0,
        is_mixed: false,
    };

    /// Restarts the windows in place. Keeps `is_mixed`, because the sums of the hypothesis stay as they are.
    #[inline(never)]
    pub(super) fn restart(&mut self) {
        *self = Self { is_mixed: self.is_mixed, ..Self::NEW };
    }

    /// Adds a pair that the hypothesis already includes. Returns the finding of the windows.
    ///
    /// * `pair`: moments of the pair, in the frame of the sums of the hypothesis; `moved`: step of the hypothesis, rad.
    #[inline(never)]
    pub(super) fn add(
        &mut self,
        hypothesis: &Hypothesis<T>,
        pair: &Moments<T>,
        measurement: &PairMeasurement<T>,
        moved: &Vector5<T>,
        context: &Context<'_, T>,
    ) -> Finding {
        self.short.scale(T::lit(SHORT_DECAY));
        self.short.add(pair);
        let biased = measurement.biased_at(hypothesis.pose());
        // A step of the pose changes the gradient of the long window by information times step, so this information
        // must not contain the noise of disparities.
        let debiased = biased.debiased();
        let [decay, long_decay] = [T::lit(SHORT_DECAY), T::lit(LONG_DECAY)];
        self.long = self.long.about(moved).scaled(long_decay).plus(&debiased);
        let vibration = hypothesis.vibration(context);
        let add = |before: &Information<T>, decay: T, pair: &NormalEquations<T>| {
            let mut variance = before.scaled(decay * decay);
            variance.add(&pair.information);
            if !vibration.is_zero() {
                variance.add(&vibration.scatter_of_gradient(&pair.information));
            }
            variance
        };
        self.short_variance = add(&self.short_variance, decay, &biased.normal);
        self.long_variance = add(&self.long_variance, long_decay, &debiased);
        self.pairs = self.pairs.saturating_add(1);
        if self.pairs >= WARM_UP_PAIRS && self.has_changed(hypothesis, context) {
            Finding::Changed
        } else if self.is_mixed && self.pairs >= SHORT_PAIRS {
            Finding::Settled
        } else {
            Finding::Same
        }
    }

    /// Replaces the sums of the hypothesis by the short window. Returns false, and changes nothing, if the short window
    /// has no admissible optimum.
    ///
    /// * `is_mixed`: whether the short window may hold pairs from before the change. A later renewal then drops them.
    #[inline(never)]
    pub(super) fn renew(
        &mut self,
        hypothesis: &mut Hypothesis<T>,
        is_mixed: bool,
        context: &Context<'_, T>,
    ) -> bool {
        let renewed = hypothesis.replace(&self.short, self.pairs.min(SHORT_PAIRS), context);
        if renewed {
            *self = Self { is_mixed, ..Self::NEW };
        }
        renewed
    }

    /// Returns whether the statistic of a window exceeds its limit.
    fn has_changed(&self, hypothesis: &Hypothesis<T>, context: &Context<'_, T>) -> bool {
        let limit = T::lit(MAX_NIS) * hypothesis.reduced_chi_square();
        // Score test: if the hypothesis is true, the gradient at its pose has mean 0 and this variance.
        let rejects = |window: &NormalEquations<T>, variance: &Information<T>| {
            let mut variance = variance.0;
            variance.add_diagonal(context.prior);
            let statistic = variance.inverse_form(&window.gradient);
            statistic.is_some_and(|statistic| statistic > limit)
        };
        let short = hypothesis.normal_equations(&self.short);
        rejects(&short, &self.short_variance) || rejects(&self.long, &self.long_variance)
    }

    /// Returns the number of pairs in the windows since their last restart.
    #[cfg(test)]
    pub(super) fn pairs(&self) -> u32 {
        self.pairs
    }
}

#[cfg(test)]
mod tests;
