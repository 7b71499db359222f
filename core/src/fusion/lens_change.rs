//! When the lens that the rays are corrected by changes, and what is kept of a lens estimate whose sums are dropped
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
    /// The reference with what a hypothesis says of the lens, for when its sums are dropped; as it is where that is
    /// nothing.
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

    /// The reference with an estimate of the lens in place of what was known; `None` where no lens can be so.
    // Out of line: a second copy took 0.3 kB at opt-level 3.
    #[inline(never)]
    fn knowing(&self, lens: &HypothesisLens<T>) -> Option<Self> {
        let known = self.correction.plus(&lens.difference());
        // Held parameters have no variance, and need no knowledge.
        let weights = lens.variances().map(|variance| {
            let wide = variance * T::lit(KNOWN_LENS_WIDENING);
            if wide > T::ZERO { T::ONE / wide } else { T::ZERO }
        });
        let next = Self { known, weights, ..*self };
        next.is_valid().then_some(next)
    }

    /// The reference to begin again with, where that gains: in the beginning, where compensation halves the deviation
    /// of `t`; later, where the weights may hide much of a further correction.
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
            // Halves disagree by a wrong lens as well: against a significant one that is no reason to keep it.
            let noise = hypothesis.covariance_of_noise(context)?;
            self.halves_deviation(&lens, &widened, context)
                || lens.is_significant() && self.halves_deviation(&lens, &noise, context)
        };
        let next = self.knowing(&lens).filter(|_| gains)?;
        Some(Self { correction: next.known, changes: self.changes.saturating_add(1), ..next })
    }

    /// Whether compensation brings the deviation of `t` below one over [`COMPENSATION_GAIN`] of that with the given
    /// lens.
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
    // Not `hypot`: that of `f32` computes in `f64`, 2.6 kB of software on a controller.
    (hidden.w * hidden.w + hidden.a * hidden.a).sqrt() > T::lit(MAX_HIDDEN_LENS) * with
}

/// Deviation of `t`, rad.
fn deviation<T: Scalar>(covariance: &Symmetric5<T>) -> T {
    StandardDeviations::of(covariance).translation
}
