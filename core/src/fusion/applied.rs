//! The part of the estimate that replaces the calibration in use, and whether the change is worthwhile (`ESTIMATOR.md`,
//! section 16).

use super::hypothesis::Hypothesis;
use super::reported::{WithLens, with_mount};
use crate::algebra::information::StandardDeviations;
use crate::algebra::symmetric5::Symmetric5;
use crate::config::Context;
use crate::depth::mount::ReportedYaw;
use crate::depth::pose::{MountPose, RowsPose};
use crate::geometry::extrinsics::Extrinsics;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::{
    CERTAIN_BASELINE, MIN_AGREED, OBSERVED_BASELINE, SIGNIFICANT, SIGNIFICANT_CHANGE,
};

/// Change from the calibration in use to an estimate.
pub(super) struct ChangeInUse<'a, T: Scalar> {
    pub(super) hypothesis: &'a Hypothesis<T>,
    /// Whether a calibration measured the factory extrinsics.
    pub(super) is_calibrated: bool,
    /// Lens correction of the rays.
    pub(super) rays: &'a LensCorrection<T>,
    pub(super) yaw: &'a ReportedYaw<T>,
    pub(super) in_use: &'a CorrectedExtrinsics<T>,
    pub(super) context: &'a Context<'a, T>,
}

impl<T: Scalar> ChangeInUse<'_, T> {
    /// Returns the calibration to apply: the estimate, or `R` alone with the baseline in use while the baseline is
    /// doubtful. `None` if the yaw to apply is too large.
    ///
    /// * `best`: the estimate as a calibration; `deviations`: its standard deviations if the given lens is exact, and
    ///   with an uncertain lens, rad.
    /// * `doubted`: whether the image halves disagree with exact lens models.
    pub(super) fn applicable(
        &self,
        estimate: &WithLens<T>,
        best: &CorrectedExtrinsics<T>,
        deviations: [&StandardDeviations<T>; 2],
        doubted: bool,
    ) -> Option<CorrectedExtrinsics<T>> {
        let Self { hypothesis, in_use, context, .. } = *self;
        let WithLens { pose, covariance, correction, .. } = estimate;
        let yaw = self.yaw_to_apply(correction);
        let whole = if yaw == self.yaw.mount {
            *best
        } else {
            let extrinsics = with_mount(pose, yaw, context)?;
            CorrectedExtrinsics { extrinsics, correction: *correction }
        };
        let [observed, certain] = [OBSERVED_BASELINE, CERTAIN_BASELINE].map(T::lit);
        let [of_noise, left] = deviations.map(|sd| unknown_share(sd, context));
        // The matches of one scene may share a bias of the baseline.
        let is_agreed = hypothesis.scenes() >= T::count(MIN_AGREED.into());
        let gains = left <= certain
            || left <= observed && baseline_differs(pose, &in_use.extrinsics, covariance);
        if gains && !doubted && (is_agreed || !self.is_calibrated) {
            return Some(whole);
        }
        let known = !doubted && is_agreed && of_noise <= observed;
        Some(self.with_baseline_in_use(known.then_some(&whole), yaw))
    }

    /// Returns the yaw to apply: that of the calibration in use until the pairs have shown a turn of the mount beyond
    /// chance, so that a rectifier is not loaded for nothing. `None` for the yaw that the rows show.
    ///
    /// * `correction`: lens correction of the estimate.
    fn yaw_to_apply(&self, correction: &LensCorrection<T>) -> Option<T> {
        let mount = self.yaw.mount?;
        let used = MountPose::from(&self.in_use.extrinsics).yaw(self.context);
        let is_held = self.in_use.correction == *correction && !self.yaw.has_turned_from(used);
        Some(if is_held { used } else { mount })
    }

    /// Returns extrinsics with the baseline in use and the `R` fitted to it. Without a fit of `R`, returns the
    /// extrinsics in use.
    ///
    /// * `known`: the estimate, if its baseline is known. It is returned instead if its row offsets are clearly
    ///   smaller.
    /// * `yaw`: yaw of the mount relative to the factory extrinsics, rad; `None` for the yaw that the rows show.
    #[inline(never)]
    fn with_baseline_in_use(
        &self,
        known: Option<&CorrectedExtrinsics<T>>,
        yaw: Option<T>,
    ) -> CorrectedExtrinsics<T> {
        let Self { hypothesis, in_use, context, .. } = *self;
        let Some(used) = self.rows_of(in_use) else { return *in_use };
        let correction = *self.rays;
        let rows = hypothesis.with_baseline_of(&used, in_use.extrinsics.translation(), context);
        let held = rows.as_ref().map_or(*used.rotations(), RectifyingRotations::from);
        if let Some(known) = known.filter(|_| hypothesis.fits_clearly_better_than(&held)) {
            return *known;
        }
        let mount = rows.and_then(|rows| with_rotation_of_mount(&rows, yaw, context));
        mount.map_or(*in_use, |extrinsics| CorrectedExtrinsics { extrinsics, correction })
    }

    /// Returns whether a change of the calibration in use is worthwhile: the pairs have shown a turn of the mount, or the
    /// estimate fits all pairs clearly better, and the calibration that would be applied differs from that in use by more
    /// than chance. `None` if the sums have another lens correction than one of the two.
    ///
    /// * `covariance`: covariance of the estimate, rad^2.
    #[inline(never)]
    pub(super) fn improves(
        &self,
        applicable: &CorrectedExtrinsics<T>,
        covariance: &Symmetric5<T>,
    ) -> Option<bool> {
        let calibrations = [self.in_use, applicable];
        if calibrations.iter().any(|of| of.correction != *self.rays) {
            return None;
        }
        let used = MountPose::from(&self.in_use.extrinsics).yaw(self.context);
        if self.yaw.mount.is_some() && self.yaw.has_turned_from(used) {
            return Some(true);
        }
        // Rows are compared with rows, so that the yaw of the lens counts against neither.
        let [used, next] = calibrations.map(|of| self.rows_of(of));
        let (used, next) = used.zip(next)?;
        let off = next.rotations().unknowns_to(used.rotations());
        let differs =
            covariance.inverse_form(&off).is_none_or(|form| form >= T::lit(SIGNIFICANT_CHANGE));
        Some(differs && self.hypothesis.fits_clearly_better_than(used.rotations()))
    }

    /// Returns the pose of a calibration as rows show it, with the yaw of the lens between the fused rows and the mount.
    /// `None` if that yaw is too large.
    #[inline(never)]
    fn rows_of(&self, calibration: &CorrectedExtrinsics<T>) -> Option<RowsPose<T>> {
        let of_rows = |mount| self.hypothesis.yaw(self.context) - mount;
        MountPose::from(&calibration.extrinsics).with_lens(self.yaw.mount.map_or(T::ZERO, of_rows))
    }
}

/// Returns the extrinsics of the mount from those that the rows show, with the same `t` up to rounding.
///
/// * `yaw`: as for [`with_mount`].
#[inline(never)]
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

/// Returns the variance of the baseline over its prior variance: 1 if the pairs show nothing of the baseline.
pub(super) fn unknown_share<T: Scalar>(
    deviations: &StandardDeviations<T>,
    context: &Context<'_, T>,
) -> T {
    deviations.translation * deviations.translation * context.prior
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
