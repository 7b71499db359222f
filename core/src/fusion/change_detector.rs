//! Change detection: changes of the rig below the noise of a single pair (`ESTIMATOR.md`, section 14).
//!
//! The detector applies a score test to an exponential window.

use super::hypothesis::Hypothesis;
use crate::algebra::information::Information;
use crate::algebra::moments::Moments;
use crate::config::Context;
use crate::pair::evaluate::PairMeasurement;
use crate::scalar::Scalar;
use crate::thresholds::{MAX_NIS, WARM_UP_PAIRS, WINDOW_DECAY, WINDOW_PAIRS};

/// An exponential window over the last pairs.
#[derive(Debug, Clone)]
pub(super) struct ChangeDetector<T: Scalar> {
    /// Moments of the window, in the frame of the sums of the hypothesis.
    moments: Moments<T>,
    /// Covariance of the gradient of the window, 1/rad^2. It decays by the square of the window's factor, because the
    /// gradient decays by this factor.
    variance: Information<T>,
    /// Number of pairs that were added since the last restart of the window.
    pairs: u32,
    /// Number of scenes that these pairs showed.
    scenes: T,
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
    /// The window holds only pairs after a change, but the sums may still hold earlier pairs.
    Settled,
}

impl<T: Scalar> ChangeDetector<T> {
    pub(super) const NEW: Self = Self {
        moments: Moments::ZERO,
        variance: Information::ZERO,
        pairs: 0,
        scenes: T::ZERO,
        is_mixed: false,
    };

    /// Restarts the window in place. Keeps `is_mixed`, because the sums of the hypothesis stay as they are.
    #[inline(never)]
    pub(super) fn restart(&mut self) {
        *self = Self { is_mixed: self.is_mixed, ..Self::NEW };
    }

    /// Adds a pair that the hypothesis already includes. Returns the finding of the window.
    ///
    /// * `pair`: moments of the pair, in the frame of the sums of the hypothesis.
    #[inline(never)]
    pub(super) fn add(
        &mut self,
        hypothesis: &Hypothesis<T>,
        pair: &Moments<T>,
        measurement: &PairMeasurement<T>,
        context: &Context<'_, T>,
    ) -> Finding {
        let decay = T::lit(WINDOW_DECAY);
        self.moments.scale(decay);
        self.moments.add(pair);
        let whole = measurement.biased_at(hypothesis.pose()).normal.information;
        let information = whole.scaled(context.share);
        self.variance = self.variance.scaled(decay * decay);
        self.variance.add(&information.scaled(context.scatter));
        let vibration = hypothesis.vibration(context);
        if !vibration.is_zero() {
            self.variance.add(&vibration.scatter_of_gradient(&information));
        }
        self.pairs = self.pairs.saturating_add(1);
        self.scenes = self.scenes * decay + context.share;
        if self.pairs >= WARM_UP_PAIRS && self.has_changed(hypothesis, context) {
            Finding::Changed
        } else if self.is_mixed && self.pairs >= WINDOW_PAIRS {
            Finding::Settled
        } else {
            Finding::Same
        }
    }

    /// Replaces the sums of the hypothesis by the window, and restarts the window. Returns false, and changes nothing,
    /// if the window has no admissible optimum.
    ///
    /// * `is_mixed`: whether the window may hold pairs from before the change. A later renewal then drops them.
    #[inline(never)]
    pub(super) fn renew(
        &mut self,
        hypothesis: &mut Hypothesis<T>,
        is_mixed: bool,
        context: &Context<'_, T>,
    ) -> bool {
        let renewed =
            hypothesis.replace(&self.moments, self.pairs.min(WINDOW_PAIRS), self.scenes, context);
        if renewed {
            *self = Self { is_mixed, ..Self::NEW };
        }
        renewed
    }

    /// Returns whether the score statistic of the window exceeds its limit.
    fn has_changed(&self, hypothesis: &Hypothesis<T>, context: &Context<'_, T>) -> bool {
        let limit = T::lit(MAX_NIS) * hypothesis.reduced_chi_square();
        // Score test: if the hypothesis is true, the gradient at its pose has mean 0 and this variance.
        let mut variance = self.variance.0;
        variance.add_diagonal(context.prior);
        let gradient = hypothesis.normal_equations(&self.moments).gradient;
        variance.inverse_form(&gradient).is_some_and(|statistic| statistic > limit)
    }

    /// Returns the number of pairs that were added since the last restart of the window.
    #[cfg(test)]
    pub(super) fn pairs(&self) -> u32 {
        self.pairs
    }
}

#[cfg(test)]
mod tests;
