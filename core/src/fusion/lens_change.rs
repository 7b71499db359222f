//! When the lens correction of the rays changes, and the knowledge of the lens that stays when sums are dropped
//! (`ESTIMATOR.md`, section 17).

use super::hypothesis::Hypothesis;
use super::lens::HypothesisLens;
use super::lens_reference::LensReference;
use crate::algebra::information::StandardDeviations;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::scalar::Scalar;
use crate::thresholds::{
    COMPENSATION_GAIN, KNOWN_LENS_WIDENING, MAX_HIDDEN_LENS, MAX_REFERENCE_CHANGES,
    MIN_REFERENCE_PAIRS,
};

impl<T: Scalar> LensReference<T> {
    /// The reference with the knowledge of a hypothesis about the lens, for when its sums are dropped; unchanged
    /// without such knowledge.
    #[inline(never)]
    pub(super) fn with_knowledge_of(
        &self,
        hypothesis: &Hypothesis<T>,
        context: &Context<'_, T>,
    ) -> Self {
        let mut lens = HypothesisLens::EXACT;
        let found = context.has_lens_prior().then(|| lens.estimate(hypothesis, self, context));
        found.flatten().and_then(|()| self.knowing(&lens)).unwrap_or(*self)
    }

    /// The reference with an estimate of the lens in place of its knowledge; `None` if the estimate is beyond any lens.
    #[inline(never)]
    fn knowing(&self, lens: &HypothesisLens<T>) -> Option<Self> {
        let known = self.correction.plus(&lens.difference());
        // Held parameters have no variance, and keep no knowledge.
        let weights = lens.variances().map(|variance| {
            let wide = variance * T::lit(KNOWN_LENS_WIDENING);
            if wide > T::ZERO { T::ONE / wide } else { T::ZERO }
        });
        let next = Self { known, weights, ..*self };
        next.is_valid().then_some(next)
    }

    /// The reference to restart the sums with, or `None` if a restart gains nothing. The first restart must halve the
    /// deviation of `t`. A later one is due where the weights may hide more than [`MAX_HIDDEN_LENS`] of it.
    #[inline(never)]
    pub(super) fn next(
        &self,
        hypothesis: &Hypothesis<T>,
        context: &Context<'_, T>,
    ) -> Option<Self> {
        let waiting = MIN_REFERENCE_PAIRS << self.changes.min(MAX_REFERENCE_CHANGES);
        if hypothesis.pairs() < waiting {
            return None;
        }
        let mut lens = HypothesisLens::EXACT;
        lens.estimate(hypothesis, self, context)?;
        let widened = hypothesis.reported_covariance(context)?;
        let gains = if self.compensates() {
            hides_much(&lens, &widened, context)
        } else {
            // A wrong lens also makes halves disagree, so their disagreement must not keep a significantly wrong lens.
            let noise = hypothesis.covariance_of_noise(context)?;
            self.halves_deviation(&lens, &widened, context)
                || lens.is_significant() && self.halves_deviation(&lens, &noise, context)
        };
        let next = self.knowing(&lens).filter(|_| gains)?;
        Some(Self { correction: next.known, changes: self.changes.saturating_add(1), ..next })
    }

    /// Whether compensation divides the deviation of `t` with the given lens by more than [`COMPENSATION_GAIN`].
    fn halves_deviation(
        &self,
        lens: &HypothesisLens<T>,
        given: &Symmetric5<T>,
        context: &Context<'_, T>,
    ) -> bool {
        let [without, with] = [lens.of_given(&self.correction), lens.left_over()]
            .map(|off| deviation(&lens.widen(given, &off, context)));
        without > T::lit(COMPENSATION_GAIN) * with
    }
}

/// Whether the weights may hide more than [`MAX_HIDDEN_LENS`] of the deviation of `t`.
fn hides_much<T: Scalar>(
    lens: &HypothesisLens<T>,
    given: &Symmetric5<T>,
    context: &Context<'_, T>,
) -> bool {
    let hidden = lens.hidden();
    let with = deviation(&lens.widen(given, &lens.left_over(), context));
    // Not `hypot`: for `f32` it computes in `f64`, which a controller emulates in software.
    (hidden.w * hidden.w + hidden.a * hidden.a).sqrt() > T::lit(MAX_HIDDEN_LENS) * with
}

/// Deviation of `t`, rad.
fn deviation<T: Scalar>(covariance: &Symmetric5<T>) -> T {
    StandardDeviations::of(covariance).translation
}
