//! Lens that the rays of the pairs are corrected by, and when it changes (`ESTIMATOR.md`, section 17).
//!
//! Compensating a difference of focal lengths or of `k1` takes corrected rays: with those of a wrong lens the weights hide
//! a part of the error. The pairs before a change have such weights, so the estimate begins again with it, and what they
//! said of the lens is kept as knowledge about the new one.

use super::hypothesis::Hypothesis;
use super::lens::HypothesisLens;
use crate::algebra::information::StandardDeviations;
use crate::algebra::lens_terms::LENS_PARAMETERS;
use crate::algebra::symmetric5::Symmetric5;
use crate::codec::{Reader, Writer};
use crate::config::Context;
use crate::error::RestoreError;
use crate::geometry::lens_correction::LensCorrection;
use crate::scalar::Scalar;
use crate::thresholds::{
    COMPENSATION_GAIN, KNOWN_LENS_WIDENING, MAX_HIDDEN_LENS, MAX_REFERENCE_CHANGES,
    MIN_REFERENCE_PAIRS,
};

/// Correction of the rays, and what is known about it from the pairs before.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LensReference<T> {
    correction: LensCorrection<T>,
    /// Variances of the differences of focal length and `k1` about the correction.
    variances: [T; 2],
    /// Changes so far; 0: the lens is as given.
    changes: u32,
}

impl<T: Scalar> LensReference<T> {
    /// Numbers and words in a record.
    pub(super) const NUMBERS: usize = 4;
    pub(super) const WORDS: usize = 1;

    /// The lens as given.
    pub(super) const GIVEN: Self =
        Self { correction: LensCorrection::NONE, variances: [T::ZERO; 2], changes: 0 };

    /// Correction of the rays.
    pub(crate) fn correction(&self) -> &LensCorrection<T> {
        &self.correction
    }

    /// Whether extrinsics and cameras are corrected.
    pub(super) fn compensates(&self) -> bool {
        self.changes > 0
    }

    /// Lets the knowledge fade as the sums do: a lens warms.
    pub(super) fn fade(&mut self, fading: T) {
        self.variances.iter_mut().for_each(|variance| *variance = *variance / fading);
    }

    /// Adds what is known to the information on the lens.
    pub(super) fn add_known(&self, information: &mut [[T; LENS_PARAMETERS]; LENS_PARAMETERS]) {
        if !self.compensates() {
            return;
        }
        let [scale_l, scale_r, _, _, _, _, k1_l, k1_r, _] = information;
        let [focal, k1] = self.variances.map(|variance| T::ONE / variance);
        let ([ll, lr, ..], [rl, rr, ..]) = (scale_l, scale_r);
        for (own, mixed) in [(ll, lr), (rr, rl)] {
            *own += focal;
            *mixed -= focal;
        }
        let ([.., ll, lr, _], [.., rl, rr, _]) = (k1_l, k1_r);
        for (own, mixed) in [(ll, lr), (rr, rl)] {
            *own += k1;
            *mixed -= k1;
        }
    }

    /// The reference to begin again with, where that gains: in the beginning, where the deviation of `t` with the given
    /// lens is more than [`COMPENSATION_GAIN`] times the one with the lens compensated; later, where what the weights hide
    /// of a further correction is more than [`MAX_HIDDEN_LENS`] of it.
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
        // Halves disagree by a wrong lens as well: their disagreement is no reason to keep it.
        let noise = hypothesis.covariance_of_noise(context)?;
        let deviation = |covariance: &Symmetric5<T>| StandardDeviations::of(covariance).translation;
        let compensated = lens.widen(&noise, &lens.left_over(), context);
        let compensated = deviation(&compensated);
        let gains = if self.compensates() {
            let hidden = lens.hidden();
            hidden.w.hypot(hidden.a) > T::lit(MAX_HIDDEN_LENS) * compensated
        } else {
            let without = lens.widen(&noise, &lens.of_given(&self.correction), context);
            deviation(&without) > T::lit(COMPENSATION_GAIN) * compensated
        };
        let correction = self.correction.plus(&lens.difference());
        let variances = lens.variances().map(|variance| variance * T::lit(KNOWN_LENS_WIDENING));
        let next = Self { correction, variances, changes: self.changes.saturating_add(1) };
        (gains && next.is_valid()).then_some(next)
    }

    fn is_valid(&self) -> bool {
        self.correction.is_valid() && self.variances.iter().all(|v| *v > T::ZERO && v.is_finite())
    }

    pub(super) fn write(&self, to: &mut Writer<'_>) {
        self.correction.write(to);
        to.numbers(&self.variances);
        to.word(self.changes);
    }

    /// # Errors
    /// [`RestoreError::Absurd`].
    pub(super) fn read(&mut self, from: &mut Reader<'_>) -> Result<(), RestoreError> {
        self.correction = LensCorrection::read(from)?;
        from.numbers(&mut self.variances)?;
        self.changes = from.word()?;
        let is_given = *self == Self::GIVEN;
        if is_given || self.compensates() && self.is_valid() {
            Ok(())
        } else {
            Err(RestoreError::Absurd)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_known_is_information_on_the_differences_alone_and_fades() {
        let mut reference = LensReference::<f64> {
            correction: LensCorrection::NONE,
            variances: [0.25, 0.5],
            changes: 1,
        };
        let form = |reference: &LensReference<f64>, p: [f64; LENS_PARAMETERS]| {
            let mut information = [[0.0; LENS_PARAMETERS]; LENS_PARAMETERS];
            reference.add_known(&mut information);
            (0..LENS_PARAMETERS)
                .flat_map(|i| (0..LENS_PARAMETERS).map(move |k| (i, k)))
                .map(|(i, k)| p[i] * information[i][k] * p[k])
                .sum::<f64>()
        };
        // (s_r - s_l)^2 / 0.25 + (k1_r - k1_l)^2 / 0.5
        assert!(
            (form(&reference, [1.0, 3.0, 9.0, 9.0, 9.0, 9.0, 2.0, 5.0, 9.0]) - 34.0).abs() < 1e-12
        );
        assert!(form(&reference, [2.0, 2.0, 9.0, 9.0, 9.0, 9.0, 5.0, 5.0, 9.0]).abs() < 1e-12);
        reference.fade(0.5);
        assert!(
            (form(&reference, [0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]) - 2.0).abs() < 1e-12
        );
        let given = LensReference { changes: 0, ..reference };
        assert!(form(&given, [1.0; LENS_PARAMETERS].map(|x: f64| x)).abs() < 1e-12);
    }
}
