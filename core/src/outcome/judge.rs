//! Forms the verdict when a pair ends (`ESTIMATOR.md`, section 16).

use crate::batch::correspondence::RayPair;
use crate::config::Config;
use crate::depth::pose::MountPose;
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection};
use crate::geometry::rectification::RectifyingRotations;
use crate::outcome::cause::Cause;
use crate::outcome::pair_fit::{Fit, Sums};
use crate::outcome::pair_report::PairReport;
use crate::outcome::proposal::Proposal;
use crate::outcome::reasons::{Reason, Reasons};
use crate::outcome::recent::Recent;
use crate::outcome::rows_of::RowsOf;
use crate::outcome::verdict::Verdict;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{MIN_IMAGE_COVERAGE, SCREEN, SCREEN_NOISES, SIGNIFICANT};

/// Input of a verdict, apart from the matches.
pub(crate) struct Evidence<'a, T: Scalar> {
    pub(crate) config: &'a Config,
    pub(crate) in_use: &'a CorrectedExtrinsics<T>,
    pub(crate) proposal: Option<&'a Proposal<T>>,
    /// Correction of the cameras that the rays of the batch belong to.
    pub(crate) rays: LensCorrection<T>,
    /// Mean focal length, px.
    pub(crate) focal: T,
    pub(crate) state: State,
    /// Whether pairs have supported the estimate.
    pub(crate) confirmed: bool,
    /// Whether the estimate rejects the pair. A frozen estimate stays locked nevertheless.
    pub(crate) rejected: bool,
    /// Whether the pair showed the same scene as the last pair that was added.
    pub(crate) repeated: bool,
    /// Mistake that the matches of the pair, or the estimate, show.
    pub(crate) cause: Option<Cause>,
    /// Likeliest mistake according to the pairs since the estimate was last locked.
    pub(crate) likeliest: Option<Cause>,
}

impl<T: Scalar> Evidence<'_, T> {
    /// Forms the verdict when a pair ends. Returns whether the estimate fits the pair; `None` if the pair could not be
    /// solved, or without an estimate.
    ///
    /// * `pair`: report of the pair; `None` if it could not be solved.
    // Out of line, so that its stack is separate from the stack of the proposal.
    #[inline(never)]
    pub(crate) fn judge(
        &self,
        matches: &[RayPair<T>],
        pair: Option<&PairReport<T>>,
        recent: &mut Recent<T>,
        verdict: &mut Verdict<T>,
    ) -> Option<bool> {
        let rows_limit = T::single(self.config.rows_limit_px);
        let coverage_limit = T::single(self.config.coverage_limit);
        let is_good = |[rows_px, coverage]: [T; 2], image_coverage| {
            rows_px <= rows_limit
                && coverage >= coverage_limit
                && image_coverage >= T::lit(MIN_IMAGE_COVERAGE)
        };
        if pair.is_some() {
            recent.add_rejected(self.rejected);
        }
        let (mut improves, mut agrees) = (false, None);
        match pair.and_then(|pair| self.fit(matches, pair)) {
            Some(fit) => {
                let Fit { in_use, next, image_coverage, nearness, .. } = fit;
                recent.add(is_good(in_use, image_coverage), is_good(next, image_coverage));
                recent.nearness = nearness;
                [verdict.rows_px, verdict.coverage] = in_use;
                verdict.image_coverage = image_coverage;
                agrees = self.proposal.map(|_| is_good(next, T::ONE));
                improves = fit.improves(self.proposal.and_then(|proposal| proposal.improves));
            }
            None => recent.add_unsolved(),
        }
        let [depth_px, deviation_px, off_px] = self.depth(recent.nearness);
        let deepens = off_px >= T::lit(SIGNIFICANT) * deviation_px
            && off_px >= T::single(self.config.depth_limit_px) * T::HALF;
        let reasons = self
            .proposal
            .map_or(Reasons::NONE, Proposal::reasons)
            .with(Reason::NotLocked, self.state != State::Locked)
            .with(Reason::Rows, !(verdict.rows_px <= rows_limit))
            .with(Reason::Depth, !(depth_px <= T::single(self.config.depth_limit_px)))
            .with(Reason::Coverage, !is_good([T::ZERO, verdict.coverage], verdict.image_coverage))
            .with(Reason::Evidence, !recent.fits || recent.rejects())
            .with(Reason::Repeated, self.repeated)
            .with(Reason::Unfit, self.cause.is_some());
        verdict.depth_px = depth_px;
        verdict.rows_ok = !reasons.contains(Reason::Rows);
        verdict.depth_ok = !reasons.contains(Reason::Depth);
        verdict.state = self.state;
        verdict.may_arm = self.confirmed
            && matches!(self.state, State::Locked | State::Suspect)
            && !reasons.forbid_arming();
        verdict.cause = self.likeliest.or(self.cause);
        // Pairs that disagree may follow from a knock, too. Any other cause is a mistake of the setup: the estimate then
        // contains it, and would replace a calibration that is right.
        let is_set_up = verdict.cause.is_none_or(|cause| cause == Cause::Moments);
        verdict.should_apply = self.state == State::Locked
            && !reasons.is_doubtful()
            && is_set_up
            && (improves || deepens);
        verdict.reasons = reasons;
        agrees
    }

    /// Returns the expected RMS error of the disparities in use, the part of it that the estimate would leave, and the
    /// part that the distance of the yaw in use from the estimate has, px. Infinite without an estimate.
    #[inline(never)]
    fn depth(&self, nearness: T) -> [T; 3] {
        let Some(proposal) = self.proposal else { return [T::INFINITY; 3] };
        let [in_use, estimate] =
            [&self.in_use.extrinsics, &proposal.extrinsics].map(MountPose::from);
        let off = estimate.rotations().unknowns_to(in_use.rotations());
        let Proposal { covariance_lens: lens, .. } = proposal;
        let [yaw, forward] = [lens.m22, lens.m44];
        let remains = yaw + nearness * forward;
        let all = remains + off.y * off.y + nearness * off.w * off.w;
        [all.sqrt(), remains.sqrt(), off.y.abs()].map(|rad| rad * self.focal)
    }

    /// Returns how the calibration in use and the estimate fit a pair. `None` if too few matches fit the pair's own
    /// pose, or if a calibration cannot be turned by the yaw of the lens.
    #[inline(never)]
    fn fit(&self, matches: &[RayPair<T>], pair: &PairReport<T>) -> Option<Fit<T>> {
        let next = self.proposal.map_or(*self.in_use, |proposal| CorrectedExtrinsics {
            extrinsics: proposal.applicable,
            correction: proposal.applicable_correction,
        });
        let lens_yaw = self.proposal.map_or(T::ZERO, |proposal| proposal.lens_yaw.value);
        let rows_of = |of: &CorrectedExtrinsics<T>| {
            RowsOf::new(&MountPose::from(&of.extrinsics), &of.correction, &self.rays, lens_yaw)
        };
        let calibrations = [rows_of(self.in_use)?, rows_of(&next)?];
        let own = RectifyingRotations::from(&pair.extrinsics).into();
        let limit = T::single(self.config.fit_limit_px);
        let own_px = limit.max(T::lit(SCREEN_NOISES) * pair.noise_px);
        // A matcher that tolerates more than the screen finds more.
        let px = own_px.max(T::single(self.config.rows_limit_px) * T::lit(SCREEN));
        let screens = [own_px, px].map(|px| px / self.focal);
        Sums::of(matches, &own, &calibrations, screens).fit(self.focal)
    }
}
