//! The reported estimate (`ESTIMATOR.md`, section 16).

use super::Fusion;
use super::applied::{ChangeInUse, unknown_share};
use super::hypothesis::Hypothesis;
use super::lens::{HypothesisLens, Knowledge};
use crate::algebra::information::StandardDeviations;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::depth::mount::ReportedYaw;
use crate::depth::pose::RowsPose;
use crate::depth::yaw::RowsYaw;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::outcome::lens_estimate::{Finding, LensEstimate};
use crate::outcome::proposal::Proposal;
use crate::outcome::reasons::{Reason, Reasons};
use crate::scalar::Scalar;
use crate::thresholds::{MAX_DISAGREEMENT, MAX_SECOND_CROWD, OBSERVED_BASELINE};

impl<T: Scalar> Fusion<T> {
    /// Returns the estimate. `None` before the first pair, without a valid covariance, or without a plausible solution
    /// for the lens.
    #[inline(never)]
    pub(crate) fn proposal(
        &self,
        context: &Context<'_, T>,
        in_use: &CorrectedExtrinsics<T>,
    ) -> Option<Proposal<T>> {
        let hypothesis = self.hypotheses.reported()?;
        let covariance = hypothesis.reported_covariance(context)?;
        // The estimate is borrowed: moving it out of the option would take its stack space twice.
        let mut estimate = self.with_lens(hypothesis, &covariance, context);
        let estimate = estimate.as_mut()?;
        // An uncertain lens cannot reduce a variance. An estimate in which it reduces one to less than half is
        // numerically wrong, and is not reported.
        let mut variances = estimate.covariance.diagonal().into_iter().zip(covariance.diagonal());
        if !variances.all(|(wide, given)| wide * T::lit(2.0) >= given) {
            return None;
        }
        let yaw = self.separate_lens(estimate, context);
        self.propose(hypothesis, &covariance, (estimate, &yaw), context, in_use)
    }

    /// Returns the reported and the applied part of an estimate. Out of line, like [`Self::concluded`], because the
    /// estimate of the lens takes most of the stack.
    ///
    /// * `covariance`: covariance if the given lens is exact, rad^2.
    #[inline(never)]
    fn propose(
        &self,
        hypothesis: &Hypothesis<T>,
        covariance: &Symmetric5<T>,
        (estimate, yaw): (&WithLens<T>, &ReportedYaw<T>),
        context: &Context<'_, T>,
        in_use: &CorrectedExtrinsics<T>,
    ) -> Option<Proposal<T>> {
        let WithLens { pose, covariance: wide, correction, found } = estimate;
        let [sd, sd_lens] = [covariance, wide].map(StandardDeviations::of);
        if !(sd.is_finite() && sd_lens.is_finite()) {
            return None;
        }
        let extrinsics = with_mount(pose, yaw.mount, context)?;
        let best = CorrectedExtrinsics { extrinsics, correction: *correction };
        let rays = self.reference.correction();
        let is_calibrated = self.mount.is_calibrated();
        let change = ChangeInUse { hypothesis, is_calibrated, rays, yaw, in_use, context };
        let doubts = doubts(hypothesis, found.is_none());
        let doubted = doubts.contains(Reason::ImageHalves) && found.is_none();
        let applicable = change.applicable(estimate, &best, [&sd, &sd_lens], doubted)?;
        Some(Proposal {
            extrinsics: best.extrinsics,
            correction: best.correction,
            applicable: applicable.extrinsics,
            applicable_correction: applicable.correction,
            pairs: hypothesis.pairs(),
            sd,
            covariance: covariance.matrix(),
            sd_lens,
            covariance_lens: wide.matrix(),
            lens: *found,
            lens_yaw: Finding { value: yaw.lens, sd: yaw.lens_sd },
            baseline_observed: unknown_share(&sd_lens, context) <= T::lit(OBSERVED_BASELINE),
            improves: change.improves(&applicable, covariance),
            state: self.state(),
            doubts,
            vibration: context.vibration.into(),
        })
    }

    /// Returns the estimate with an uncertain lens. Once the rays are corrected, the pose belongs to the lens that the
    /// pairs show. `None` if the lens has no plausible finite solution.
    #[inline(never)]
    fn with_lens(
        &self,
        hypothesis: &Hypothesis<T>,
        covariance: &Symmetric5<T>,
        context: &Context<'_, T>,
    ) -> Option<WithLens<T>> {
        if !context.has_lens_prior() {
            let (pose, correction) = (hypothesis.rows_pose(), *self.reference.correction());
            return Some(WithLens { pose, covariance: *covariance, correction, found: None });
        }
        let mut lens = HypothesisLens::EXACT;
        lens.estimate(hypothesis, &self.reference, Knowledge::Included, context)?;
        Some(self.concluded(hypothesis, &lens, covariance, context))
    }

    /// Returns the result of [`Self::with_lens`] from an estimate of the lens.
    #[inline(never)]
    fn concluded(
        &self,
        hypothesis: &Hypothesis<T>,
        lens: &HypothesisLens<T>,
        covariance: &Symmetric5<T>,
        context: &Context<'_, T>,
    ) -> WithLens<T> {
        let (pose, correction) = (hypothesis.rows_pose(), *self.reference.correction());
        let found = Some(lens.report(&correction, context.focal));
        let Some(compensated) = self.compensated(&pose, lens, context) else {
            let wide = lens.widen(covariance, &lens.values, context);
            return WithLens { pose, covariance: wide, correction, found };
        };
        let mut wide = lens.widen(covariance, &lens.left_over(), context);
        wide.add_outer_out_of_line(T::ONE, &lens.hidden().into());
        let correction = correction.plus(&lens.difference());
        WithLens { pose: compensated, covariance: wide, correction, found }
    }

    /// Splits the yaw that the rows show into the yaw of the mount and the apparent yaw of the lens, and returns both.
    /// The covariance then belongs to the pose with the yaw of the mount.
    fn separate_lens(
        &self,
        estimate: &mut WithLens<T>,
        context: &Context<'_, T>,
    ) -> ReportedYaw<T> {
        let [_, variance, ..] = estimate.covariance.diagonal();
        let rows = RowsYaw { turn: estimate.pose.yaw(context), variance };
        let yaw = self.mount.reported(&rows, context);
        // The error of the mount's yaw comes from its separation from the lens. It does not depend on the other
        // unknowns, which the rows determine.
        let gain = if yaw.mount.is_some() { T::ZERO } else { T::ONE };
        estimate.covariance.set_yaw(gain, yaw.variance);
        yaw
    }

    /// Returns the pose for the compensated lens. `None` if the lens is not compensated, or if the pose exceeds the
    /// correction limit, for instance with a far pair that does not observe the baseline.
    fn compensated(
        &self,
        pose: &RowsPose<T>,
        lens: &HypothesisLens<T>,
        context: &Context<'_, T>,
    ) -> Option<RowsPose<T>> {
        if !self.reference.compensates() {
            return None;
        }
        let pose = pose.rotations().stepped_by(&lens.compensation())?;
        context.check(&pose).is_ok().then(|| pose.into())
    }
}

/// The estimate with an uncertain lens.
pub(super) struct WithLens<T: Scalar> {
    pub(super) pose: RowsPose<T>,
    /// Covariance of the pose, rad^2.
    pub(super) covariance: Symmetric5<T>,
    /// Lens correction of the cameras that the pose belongs to.
    pub(super) correction: LensCorrection<T>,
    found: Option<LensEstimate<T>>,
}

/// Returns the extrinsics of the mount.
///
/// * `yaw`: yaw of the mount from the factory extrinsics, rad; `None` if the rows alone determine it.
pub(super) fn with_mount<T: Scalar>(
    rows: &RowsPose<T>,
    yaw: Option<T>,
    context: &Context<'_, T>,
) -> Option<Extrinsics<T>> {
    rows.with_mount(yaw, context)?.rotations().extrinsics().ok()
}

/// Returns the doubts about a hypothesis that follow from matches on one side of the peak
/// ([`Hypothesis::second_crowd`]) and from the image halves.
///
/// * `exact`: whether the lens models count as exact. Otherwise halves that disagree only widen the standard
///   deviations.
fn doubts<T: Scalar>(hypothesis: &Hypothesis<T>, exact: bool) -> Reasons {
    let [named, biased] = MAX_DISAGREEMENT.map(T::lit);
    let disagreement = hypothesis.disagreement();
    Reasons::NONE
        .with(Reason::SecondMode, hypothesis.second_crowd() > T::lit(MAX_SECOND_CROWD))
        .with(Reason::ImageHalves, disagreement > named)
        .with(Reason::Biased, exact && disagreement > biased)
}
