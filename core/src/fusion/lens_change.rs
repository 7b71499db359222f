//! Conditions for a change of the lens correction of the rays, and the knowledge of the lens that remains when the sums
//! over the pairs are dropped (`ESTIMATOR.md`, section 17).

use super::hypothesis::Hypothesis;
use super::lens::{HypothesisLens, Knowledge};
use super::lens_reference::LensReference;
use crate::algebra::information::StandardDeviations;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::{Context, LensTracking};
use crate::geometry::lens_correction::LensCorrection;
use crate::scalar::Scalar;
use crate::thresholds::{
    COMPENSATION_GAIN, KNOWN_LENS_WIDENING, MAX_HIDDEN_LENS, MAX_REFERENCE_CHANGES,
    MIN_REFERENCE_PAIRS, SIGNIFICANT,
};

impl<T: Scalar> LensReference<T> {
    /// Returns the reference with the knowledge about the lens in a hypothesis, for sums that are to be dropped and for
    /// a record. Unchanged if the hypothesis has no such knowledge.
    #[inline(never)]
    pub(super) fn with_knowledge_of(
        &self,
        hypothesis: &Hypothesis<T>,
        context: &Context<'_, T>,
    ) -> Self {
        let mut lens = HypothesisLens::EXACT;
        let found = context
            .has_lens_prior()
            .then(|| lens.estimate(hypothesis, self, Knowledge::Included, context));
        found.flatten().and_then(|()| self.knowing(&lens)).unwrap_or(*self)
    }

    /// Returns whether the pairs of a hypothesis contradict the knowledge of the lens from dropped sums: the lens has
    /// changed.
    pub(super) fn is_contradicted_by(
        &self,
        hypothesis: &Hypothesis<T>,
        context: &Context<'_, T>,
    ) -> bool {
        let mut lens = HypothesisLens::EXACT;
        let knows = self.weights.iter().any(|weight| *weight > T::ZERO);
        let found = (knows && context.has_lens_prior())
            .then(|| lens.estimate(hypothesis, self, Knowledge::Origin, context));
        found.flatten().is_some_and(|()| self.is_far_from(&lens))
    }

    /// Returns whether an estimate of the lens relative to the known one exceeds [`SIGNIFICANT`] deviations of both.
    pub(super) fn is_far_from(&self, lens: &HypothesisLens<T>) -> bool {
        let LensCorrection { focal, k1 } = lens.difference();
        let differences = [focal, k1].into_iter().zip(lens.variances()).zip(self.weights);
        differences.into_iter().any(|((off, variance), weight)| {
            let most = T::lit(SIGNIFICANT * SIGNIFICANT) * (variance + T::ONE / weight);
            weight > T::ZERO && off * off > most
        })
    }

    /// Forgets the knowledge of the lens from dropped sums, and the corrections so far: the next one is as early as that
    /// after the first.
    pub(super) fn forget_known(&mut self) {
        (self.weights, self.is_doubted) = ([T::ZERO; 2], true);
        self.changes = self.changes.min(1);
    }

    /// Returns whether the lens has changed, and a correction is not due yet. The yaw of the rows is then that of a wrong
    /// lens.
    pub(super) fn awaits_correction(&self, pairs: u32, context: &Context<'_, T>) -> bool {
        let compensates = context.config.lens_tracking == LensTracking::Compensate;
        compensates && self.is_doubted && pairs <= self.waiting()
    }

    /// Returns the number of pairs before the next change of the correction.
    fn waiting(&self) -> u32 {
        MIN_REFERENCE_PAIRS << self.changes.min(MAX_REFERENCE_CHANGES)
    }

    /// Returns the reference with its knowledge replaced by an estimate of the lens that already includes this
    /// knowledge. `None` if the estimate is out of range.
    fn knowing(&self, lens: &HypothesisLens<T>) -> Option<Self> {
        let known = self.correction.plus(&lens.difference());
        // Parameters that are held fixed have a variance of 0, and get no weight.
        let weights = lens.variances().map(|variance| {
            let wide = variance * T::lit(KNOWN_LENS_WIDENING);
            if wide > T::ZERO { T::ONE / wide } else { T::ZERO }
        });
        let next = Self { known, weights, is_doubted: false, ..*self };
        next.is_valid().then_some(next)
    }

    /// Returns the reference with which the sums restart. `None` before [`MIN_REFERENCE_PAIRS`] pairs, without a valid
    /// estimate of the lens, or if a restart gains nothing. Each of the first [`MAX_REFERENCE_CHANGES`] restarts
    /// doubles this number of pairs. The first restart must divide the standard deviation of `t` by more than
    /// [`COMPENSATION_GAIN`]. A later restart is due if the weights may hide an error of `t` above [`MAX_HIDDEN_LENS`]
    /// times its standard deviation.
    pub(super) fn next(
        &self,
        hypothesis: &Hypothesis<T>,
        context: &Context<'_, T>,
    ) -> Option<Self> {
        if hypothesis.pairs() < self.waiting() {
            return None;
        }
        let mut lens = HypothesisLens::EXACT;
        lens.estimate(hypothesis, self, Knowledge::Included, context)?;
        let widened = hypothesis.reported_covariance(context)?;
        let gains = if self.compensates() {
            hides_much(&lens, &widened, context)
        } else {
            // A wrong lens also makes the image halves disagree, and this widens the covariance. So a significantly
            // wrong lens is judged by the covariance of the noise alone, too.
            let noise = hypothesis.covariance_of_noise(context)?;
            self.halves_deviation(&lens, &widened, context)
                || lens.is_significant() && self.halves_deviation(&lens, &noise, context)
        };
        let next = self.knowing(&lens).filter(|_| gains)?;
        Some(Self { correction: next.known, changes: self.changes.saturating_add(1), ..next })
    }

    /// Returns whether compensation divides the standard deviation of `t` by more than [`COMPENSATION_GAIN`].
    ///
    /// * `given`: covariance of the extrinsics if the given lens is exact, rad^2.
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

/// Returns whether the weights may hide an error of `t` above [`MAX_HIDDEN_LENS`] times its standard deviation.
///
/// * `given`: covariance of the extrinsics if the given lens is exact, rad^2.
pub(super) fn hides_much<T: Scalar>(
    lens: &HypothesisLens<T>,
    given: &Symmetric5<T>,
    context: &Context<'_, T>,
) -> bool {
    let hidden = lens.hidden();
    let with = deviation(&lens.widen(given, &lens.left_over(), context));
    // Not `hypot`, which for `f32` computes in `f64`, and a controller emulates `f64` in software.
    (hidden.w * hidden.w + hidden.a * hidden.a).sqrt() > T::lit(MAX_HIDDEN_LENS) * with
}

/// Returns the standard deviation of `t`, rad.
fn deviation<T: Scalar>(covariance: &Symmetric5<T>) -> T {
    StandardDeviations::of(covariance).translation
}
