//! The reported estimate, and its part that is applied (`ESTIMATOR.md`, section 16).

use super::Fusion;
use super::hypothesis::Hypothesis;
use super::lens::{HypothesisLens, Knowledge};
use crate::algebra::information::StandardDeviations;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::depth::mount::ReportedYaw;
use crate::depth::pose::{MountPose, RowsPose};
use crate::depth::yaw::RowsYaw;
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::lens_estimate::{Finding, LensEstimate};
use crate::outcome::proposal::Proposal;
use crate::outcome::reasons::{Reason, Reasons};
use crate::scalar::Scalar;
use crate::thresholds::{
    CERTAIN_BASELINE, MAX_DISAGREEMENT, MAX_SECOND_CROWD, MIN_AGREED, OBSERVED_BASELINE,
    SIGNIFICANT, SIGNIFICANT_CHANGE,
};

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
        let with_lens = self.with_lens(hypothesis, &covariance, context);
        // An uncertain lens cannot reduce a variance. An estimate in which it reduces one to less than half is
        // numerically wrong, and is not reported.
        let WithLens { covariance: wide, .. } = with_lens.as_ref()?;
        let mut variances = wide.diagonal().into_iter().zip(covariance.diagonal());
        if !variances.all(|(wide, given)| wide * T::lit(2.0) >= given) {
            return None;
        }
        let of_mount = self.of_mount(with_lens.as_ref()?, context);
        self.propose(hypothesis, &covariance, &of_mount, context, in_use)
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
        of_mount: &OfMount<T>,
        context: &Context<'_, T>,
        in_use: &CorrectedExtrinsics<T>,
    ) -> Option<Proposal<T>> {
        let OfMount { estimate, yaw } = of_mount;
        let WithLens { pose, covariance: wide, correction, found } = estimate;
        let [sd, sd_lens] = [covariance, wide].map(StandardDeviations::of);
        if !(sd.is_finite() && sd_lens.is_finite()) {
            return None;
        }
        let extrinsics = with_mount(pose, yaw.mount, context)?;
        let best = CorrectedExtrinsics { extrinsics, correction: *correction };
        let held = held_yaw(yaw, in_use, correction, context);
        let held_best = if held == yaw.mount {
            best
        } else {
            let extrinsics = with_mount(pose, held, context)?;
            CorrectedExtrinsics { extrinsics, correction: *correction }
        };
        let [observed, certain] = [OBSERVED_BASELINE, CERTAIN_BASELINE].map(T::lit);
        let left = sd_lens.translation * sd_lens.translation * context.prior;
        // The matches of one scene may share a bias of the baseline.
        let is_agreed = hypothesis.scenes() >= T::count(MIN_AGREED.into());
        let gains = (is_agreed || !self.mount.is_calibrated())
            && (left <= certain
                || left <= observed && baseline_differs(pose, &in_use.extrinsics, wide));
        let doubts = doubts(hypothesis, found.is_none());
        let doubted = doubts.contains(Reason::ImageHalves) && found.is_none();
        let rows_in_use = as_rows(hypothesis, yaw, in_use, context);
        let applicable = if doubted || !gains {
            let known = !doubted
                && is_agreed
                && sd.translation * sd.translation * context.prior <= observed;
            let known = known.then_some(&held_best);
            self.with_baseline_of(hypothesis, in_use, rows_in_use.as_ref(), known, held, context)
        } else {
            held_best
        };
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
            baseline_observed: left <= observed,
            improves: self.improves(hypothesis, [in_use, &applicable], yaw, covariance, context),
            state: self.state(),
            doubts,
            vibration: context.vibration.into(),
        })
    }

    /// Returns whether a change of the calibration in use is worthwhile: the pairs have shown a turn of the mount, or the
    /// estimate fits all pairs clearly better, and the calibration that would be applied differs from that in use by more
    /// than chance. `None` if the sums have another lens correction than one of the two.
    ///
    /// * `calibrations`: in use, and applicable; `covariance`: covariance of the estimate, rad^2.
    #[inline(never)]
    fn improves(
        &self,
        hypothesis: &Hypothesis<T>,
        calibrations: [&CorrectedExtrinsics<T>; 2],
        yaw: &ReportedYaw<T>,
        covariance: &Symmetric5<T>,
        context: &Context<'_, T>,
    ) -> Option<bool> {
        let reference = self.reference.correction();
        if calibrations.iter().any(|of| of.correction != *reference) {
            return None;
        }
        let [in_use, _] = calibrations;
        let used = MountPose::from(&in_use.extrinsics).yaw(context);
        if yaw.mount.is_some() && yaw.has_turned_from(used) {
            return Some(true);
        }
        // Rows are compared with rows, so that the yaw of the lens counts against neither.
        let [used, next] = calibrations.map(|of| as_rows(hypothesis, yaw, of, context));
        let (used, next) = used.zip(next)?;
        let off = next.rotations().unknowns_to(used.rotations());
        let differs =
            covariance.inverse_form(&off).is_none_or(|form| form >= T::lit(SIGNIFICANT_CHANGE));
        Some(differs && hypothesis.fits_clearly_better_than(used.rotations()))
    }

    /// Returns extrinsics with the baseline in use and the `R` fitted to it. Without a fit of `R`, returns the
    /// extrinsics in use.
    ///
    /// * `rows_in_use`: the pose in use as rows show it.
    /// * `known`: the estimate, if its baseline is known. It is returned instead if its row offsets are clearly
    ///   smaller.
    /// * `yaw`: yaw of the mount relative to the factory extrinsics, rad; `None` for the yaw that the rows show.
    #[inline(never)]
    fn with_baseline_of(
        &self,
        hypothesis: &Hypothesis<T>,
        in_use: &CorrectedExtrinsics<T>,
        rows_in_use: Option<&RowsPose<T>>,
        known: Option<&CorrectedExtrinsics<T>>,
        yaw: Option<T>,
        context: &Context<'_, T>,
    ) -> CorrectedExtrinsics<T> {
        let Some(used) = rows_in_use else { return *in_use };
        let correction = *self.reference.correction();
        let rows = hypothesis.with_baseline_of(used, in_use.extrinsics.translation(), context);
        let held = rows.as_ref().map_or(*used.rotations(), RectifyingRotations::from);
        if let Some(known) = known.filter(|_| hypothesis.fits_clearly_better_than(&held)) {
            return *known;
        }
        let mount = rows.and_then(|rows| with_rotation_of_mount(&rows, yaw, context));
        mount.map_or(*in_use, |extrinsics| CorrectedExtrinsics { extrinsics, correction })
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

    /// Returns the estimate, and splits the yaw that the rows show into the yaw of the mount and the apparent yaw of
    /// the lens.
    fn of_mount(&self, with_lens: &WithLens<T>, context: &Context<'_, T>) -> OfMount<T> {
        let mut estimate = *with_lens;
        let [_, variance, ..] = estimate.covariance.diagonal();
        let rows = RowsYaw { turn: estimate.pose.yaw(context), variance };
        let yaw = self.mount.reported(&rows, context);
        // The error of the mount's yaw comes from its separation from the lens. It does not depend on the other
        // unknowns, which the rows determine.
        let gain = if yaw.mount.is_some() { T::ZERO } else { T::ONE };
        estimate.covariance.set_yaw(gain, yaw.variance);
        OfMount { estimate, yaw }
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

/// The estimate with the yaw of the mount.
struct OfMount<T: Scalar> {
    /// The covariance belongs to the pose with the yaw of the mount.
    estimate: WithLens<T>,
    yaw: ReportedYaw<T>,
}

/// The estimate with an uncertain lens.
#[derive(Clone, Copy)]
struct WithLens<T: Scalar> {
    pose: RowsPose<T>,
    /// Covariance of the pose, rad^2.
    covariance: Symmetric5<T>,
    /// Lens correction of the cameras that the pose belongs to.
    correction: LensCorrection<T>,
    found: Option<LensEstimate<T>>,
}

/// Returns the yaw to apply: that of the calibration in use until the pairs have shown a turn of the mount beyond
/// chance, so that a rectifier is not loaded for nothing. `None` for the yaw that the rows show.
///
/// * `correction`: lens correction of the estimate.
fn held_yaw<T: Scalar>(
    yaw: &ReportedYaw<T>,
    in_use: &CorrectedExtrinsics<T>,
    correction: &LensCorrection<T>,
    context: &Context<'_, T>,
) -> Option<T> {
    let mount = yaw.mount?;
    let used = MountPose::from(&in_use.extrinsics).yaw(context);
    let is_held = in_use.correction == *correction && !yaw.has_turned_from(used);
    Some(if is_held { used } else { mount })
}

/// Returns the pose of a calibration as rows show it, with the yaw of the lens between the fused rows and the mount.
/// `None` if that yaw is too large.
fn as_rows<T: Scalar>(
    hypothesis: &Hypothesis<T>,
    yaw: &ReportedYaw<T>,
    of: &CorrectedExtrinsics<T>,
    context: &Context<'_, T>,
) -> Option<RowsPose<T>> {
    let lens_yaw = yaw.mount.map_or(T::ZERO, |mount| hypothesis.yaw(context) - mount);
    MountPose::from(&of.extrinsics).with_lens(lens_yaw)
}

/// Returns the extrinsics of the mount.
///
/// * `yaw`: yaw of the mount from the factory extrinsics, rad; `None` if the rows alone determine it.
fn with_mount<T: Scalar>(
    rows: &RowsPose<T>,
    yaw: Option<T>,
    context: &Context<'_, T>,
) -> Option<Extrinsics<T>> {
    rows.with_mount(yaw, context)?.rotations().extrinsics().ok()
}

/// Returns the extrinsics of the mount from those that the rows show, with the same `t` up to rounding.
///
/// * `yaw`: as for [`with_mount`].
fn with_rotation_of_mount<T: Scalar>(
    rows: &Extrinsics<T>,
    yaw: Option<T>,
    context: &Context<'_, T>,
) -> Option<Extrinsics<T>> {
    if yaw.is_none() {
        return Some(*rows);
    }
    let turned = with_mount(&RectifyingRotations::from(rows).into(), yaw, context)?;
    Extrinsics::try_new(turned.rotation().matrix(), rows.translation()).ok()
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

/// Returns whether the squared Mahalanobis distance of the baseline in use from the estimate exceeds chance
/// ([`SIGNIFICANT`]).
///
/// * `covariance`: covariance of the estimate, rad^2.
fn baseline_differs<T: Scalar>(
    pose: &RowsPose<T>,
    in_use: &Extrinsics<T>,
    covariance: &Symmetric5<T>,
) -> bool {
    let off = pose.rotations().unknowns_to(&RectifyingRotations::from(in_use));
    let [.., a, _, _, _, b, c] = covariance.0;
    let form = c * off.w * off.w - T::lit(2.0) * b * off.w * off.a + a * off.a * off.a;
    form >= T::lit(SIGNIFICANT * SIGNIFICANT) * (a * c - b * b)
}

#[cfg(test)]
mod tests {
    use super::super::hypothesis::tests::truth;
    use super::*;
    use nalgebra::Vector5;

    #[test]
    fn a_baseline_differs_by_its_distance_in_correlated_deviations() {
        let (sd, correlation) = (1e-5, 0.8);
        let variance = sd * sd;
        let mut covariance = Symmetric5::of_diagonal([variance; 5]);
        let [.., b, _] = &mut covariance.0;
        *b = correlation * variance;
        // The squared distance of a step (x, y), in deviations, is (x^2 - 2 rho x y + y^2) / (1 - rho^2).
        let differs = |x: f64, y: f64| {
            let in_use = truth().stepped_by(&Vector5::new(0.0, 0.0, 0.0, x * sd, y * sd)).unwrap();
            baseline_differs(&truth().into(), &in_use.extrinsics().unwrap(), &covariance)
        };
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (1.0, 0.0), (0.0, 1.0), (0.3, -1.0)] {
            let squared: f64 =
                (x * x - 2.0 * correlation * x * y + y * y) / (1.0 - correlation * correlation);
            let limit = SIGNIFICANT / squared.sqrt();
            let at = [0.98, 1.02].map(|part| differs(x * limit * part, y * limit * part));
            assert_eq!(at, [false, true], "{x} {y}");
        }
    }
}
