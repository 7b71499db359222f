//! Result of an association: the hypothesis that a pair supports, and the report of the pair.

use super::key_frame::Moved;
use crate::algebra::information::Information;
use crate::config::Context;
use crate::depth::yaw::RowsYaw;
use crate::geometry::extrinsics::Extrinsics;
use crate::outcome::pair_report::PairReport;
use crate::pair::evaluate::{EvaluatedPose, PairMeasurement};
use crate::scalar::Scalar;
use crate::state::Stop;

/// Hypothesis that a pair supports.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Support {
    Champion,
    Challenger,
    /// A new hypothesis.
    New,
    /// No hypothesis. Champion and challenger reject the pair, or the challenger rejects it and a search has found no
    /// pose that fits clearly better than the challenger's.
    None,
}

/// Hypotheses whose gates reject a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Rejected {
    pub(super) by_champion: bool,
    pub(super) by_challenger: bool,
}

/// Result of an association.
#[derive(Debug, Clone, Copy)]
pub(super) struct AssociationResult<'a, T: Scalar> {
    pub(super) support: Support,
    pub(super) evaluated: &'a EvaluatedPose<T>,
    pub(super) rejected: Rejected,
    /// Motion of the scene of the pair since the key frame.
    pub(super) moved: Moved,
    /// Passes taken, evaluations and comparisons included.
    pub(super) passes: u16,
    pub(super) stop: Stop,
}

impl<T: Scalar> AssociationResult<'_, T> {
    /// Returns [`Moved::share`] and [`Moved::scatter`] of the pair for its hypothesis; 1 for a new hypothesis.
    pub(super) fn counting(&self) -> [T; 2] {
        match self.support {
            Support::Champion | Support::Challenger => [self.moved.share(), self.moved.scatter()],
            Support::New | Support::None => [T::ONE; 2],
        }
    }

    /// Returns the yaw of the pair alone, at [`Self::optimum`], with the variance of its noise. `None` if
    /// there is no valid optimum.
    #[inline(never)]
    pub(super) fn yaw(&self, context: &Context<'_, T>) -> Option<RowsYaw<T>> {
        let PairMeasurement { pose, moments, .. } = &self.evaluated.measurement;
        let normal = moments.biased_at_frame().debiased().with_prior(context.prior);
        let (step, covariance) = normal.optimum()?;
        let [_, variance, ..] = covariance.diagonal();
        Some(RowsYaw { turn: context.factory_pose.unknowns_to(pose).y + step.y, variance })
    }

    /// Returns the extrinsics of the pair alone, and its information on them without the prior. They are the optimum of
    /// its moments and a prior about the evaluated pose with the information of the factory extrinsics. `None` if there
    /// is no valid optimum.
    pub(super) fn optimum(
        &self,
        context: &Context<'_, T>,
    ) -> Option<(Extrinsics<T>, Information<T>)> {
        let PairMeasurement { pose, moments, .. } = &self.evaluated.measurement;
        let normal = moments.biased_at_frame().debiased();
        let pose = pose.stepped_by(&normal.with_prior(context.prior).step()?)?;
        Some((pose.extrinsics().ok()?, normal.information))
    }

    /// Returns the report of the pair alone, at its optimum. `None` if there is no valid optimum.
    pub(super) fn report(&self, context: &Context<'_, T>) -> Option<PairReport<T>> {
        let EvaluatedPose { measurement, stats, .. } = self.evaluated;
        let focal = context.focal;
        let (extrinsics, information) = self.optimum(context)?;
        let count = stats.screened.max(T::ONE);
        let [squares_before, squares_after] = stats.squares.map(|sum| sum * focal * focal);
        let [cost_before, cost_after] = stats.cost.map(|sum| sum * focal * focal);
        let [usable, skipped, screened] =
            [stats.usable, stats.skipped, stats.screened].map(|count| count.to_u16().into());
        Some(PairReport {
            extrinsics,
            information,
            stop: self.stop,
            passes: self.passes,
            usable,
            skipped,
            screened,
            cost_before: cost_before * T::HALF,
            cost_after: cost_after * T::HALF,
            rms_px_before: (squares_before / count).sqrt(),
            rms_px_after: (squares_after / count).sqrt(),
            noise_px: measurement.noise,
        })
    }
}
