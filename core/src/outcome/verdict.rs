//! The verdict after a pair: rows, depth and coverage of the calibration in use, and whether the rig may arm
//! (`ESTIMATOR.md`, section 16).

use core::fmt;

use crate::batch::correspondence::RayPair;
use crate::batch::grid::CellSet;
use crate::batch::row_offset::pixel_row_offset;
use crate::config::Config;
use crate::depth::pose::{MountPose, RowsPose};
use crate::geometry::lens_correction::{CorrectedExtrinsics, LensCorrection, RayChange};
use crate::outcome::cause::Cause;
use crate::outcome::proposal::Proposal;
use crate::outcome::reasons::{Reason, Reasons};
use crate::outcome::robust_rms::SquaresBySize;
use crate::scalar::Scalar;
use crate::state::State;
use crate::thresholds::{
    BAD_IN_A_ROW, BAD_PX, FIRST_ROW_LEVEL, GOOD_IN_A_ROW, IMPROVEMENT, JUDGED, MAX_UNSOLVED,
    MIN_IMAGE_COVERAGE, SCREEN, SCREEN_NOISES, SIGNIFICANT,
};

/// Number of unknowns of a pose.
const UNKNOWNS: f64 = 5.0;

/// Judgement of the calibration in use by the last pairs. It is computed once when a pair ends, and kept until the next
/// pair ends.
///
/// `rows_px` and both coverages are of the last pair that was solved; they are infinite and 0 before the first one.
/// `depth_px` is infinite without an estimate.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{Calibration, Calibrator, Correspondence};
///
/// /// Takes a pair; returns whether the vehicle may arm.
/// fn take<const N: usize>(rig: &mut Calibrator<f32, N>, matches: &[Correspondence<f32>]) -> bool {
///     let _ = rig.take_pair(matches.iter().copied());
///     if rig.verdict().should_apply {
///         let _ = rig.apply(); // then load the rectifier with `in_use`
///     }
///     rig.verdict().may_arm
/// }
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[expect(clippy::struct_excessive_bools, reason = "each answers a question of its own")]
#[non_exhaustive]
pub struct Verdict<T> {
    /// RMS row offset, px, of the calibration in use beyond that of the pair's own pose, over the matches that fit the
    /// latter. Noise of the matcher does not count; vibration does.
    pub rows_px: T,
    /// Expected RMS error of the disparities with the calibration in use, px: the distance from the estimate, and its
    /// deviation with the lens models uncertain. The error of depth `Z` is `Z^2 / (f b)` times this.
    pub depth_px: T,
    /// Share of the matches that fit the calibration in use, among those that fit the pair's own pose, 0 to 1.
    pub coverage: T,
    /// Share of the cells of an 8 x 6 grid over the left image with a match that fits the pair's own pose, 0 to 1.
    pub image_coverage: T,
    /// Whether `rows_px` is within [`Config::with_rows_limit_px`].
    pub rows_ok: bool,
    /// Whether `depth_px` is within [`Config::with_depth_limit_px`].
    pub depth_ok: bool,
    /// Answer to an arming check. True if the estimate has been confirmed, the calibration in use has fitted two pairs
    /// in a row and no two in a row failed since, depth is within its limit, and no reason forbids it.
    pub may_arm: bool,
    /// Whether [`crate::Calibrator::apply`] is worthwhile: the estimate is locked and clearly better than the
    /// calibration in use.
    pub should_apply: bool,
    /// Reliability of the estimate.
    pub state: State,
    /// Reasons not to rely on the calibration in use. There is at least one if the rig must not arm.
    pub reasons: Reasons,
    /// The likeliest mistake in rig file or matcher that the pairs, the matches or the estimate show.
    pub cause: Option<Cause>,
}

impl<T: Scalar> Verdict<T> {
    /// Before any pair.
    pub(crate) const NONE: Self = Self {
        rows_px: T::INFINITY,
        depth_px: T::INFINITY,
        coverage: T::ZERO,
        image_coverage: T::ZERO,
        rows_ok: false,
        depth_ok: false,
        may_arm: false,
        should_apply: false,
        state: State::Acquiring,
        reasons: Reasons::NONE.with(Reason::NotLocked, true),
        cause: None,
    };

    /// Forbids arming, because no pair has confirmed the calibration in use.
    pub(crate) fn disarm(&mut self) {
        self.may_arm = false;
        self.reasons = self.reasons.with(Reason::Evidence, true);
    }
}

impl<T: Scalar> fmt::Display for Verdict<T> {
    /// Writes one line: `rows 0.4 px, depth 1.0 px, coverage 0.96: may arm`. Reasons and the cause follow.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { rows_px, depth_px, coverage, reasons, .. } = self;
        let arming = if self.may_arm { "may arm" } else { "must not arm" };
        write!(
            f,
            "rows {rows_px:.1} px, depth {depth_px:.1} px, coverage {coverage:.2}: {arming}"
        )?;
        if self.should_apply {
            f.write_str(", should apply")?;
        }
        if !reasons.is_empty() {
            write!(f, ", against it: {reasons}")?;
        }
        self.cause.map_or(Ok(()), |cause| write!(f, ", likely cause: {cause}"))
    }
}

/// How the last pairs fitted the calibration in use.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Recent<T> {
    /// Numbers of pairs in a row that fitted and that did not. One of them is 0.
    good: u8,
    bad: u8,
    /// Number of pairs in a row that could not be solved.
    unsolved: u8,
    /// Whether [`GOOD_IN_A_ROW`] pairs have fitted, and since then no [`BAD_IN_A_ROW`] pairs in a row have not.
    fits: bool,
    /// Whether the last solved pair fits the calibration that [`crate::Calibrator::apply`] puts into use.
    next_fits: bool,
    /// Mean square of `x_l^2 - x_r^2` over the last solved pair: error of a disparity per turn of the baseline.
    nearness: T,
}

impl<T: Scalar> Recent<T> {
    pub(crate) const NONE: Self =
        Self { good: 0, bad: 0, unsolved: 0, fits: false, next_fits: false, nearness: T::ZERO };

    /// Notes a solved pair.
    fn add(&mut self, fits: bool, next_fits: bool) {
        self.next_fits = next_fits;
        self.unsolved = 0;
        if fits {
            (self.good, self.bad) = (self.good.saturating_add(1), 0);
        } else {
            (self.good, self.bad) = (0, self.bad.saturating_add(1));
        }
        self.fits = if self.fits { self.bad < BAD_IN_A_ROW } else { self.good >= GOOD_IN_A_ROW };
    }

    /// Notes a pair that could not be solved.
    fn add_unsolved(&mut self) {
        self.unsolved = self.unsolved.saturating_add(1);
        if self.unsolved >= MAX_UNSOLVED {
            (self.good, self.fits, self.next_fits) = (0, false, false);
        }
    }

    /// Notes that another calibration has been put into use. The last pair counts for it or against it.
    pub(crate) fn change(&mut self) {
        (self.good, self.bad) =
            if self.next_fits { (self.good.max(1), 0) } else { (0, self.bad.max(1)) };
    }
}

/// Solution of a pair alone.
pub(crate) struct Own<T: Scalar> {
    pub(crate) pose: RowsPose<T>,
    /// Noise of a coordinate, px.
    pub(crate) noise_px: T,
}

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
    /// * `own`: solution of the pair alone; `None` if it could not be solved.
    // Out of line, so that its stack is separate from the stack of the proposal.
    #[inline(never)]
    pub(crate) fn judge(
        &self,
        matches: &[RayPair<T>],
        own: Option<&Own<T>>,
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
        let (mut improves, mut agrees) = (false, None);
        match own.and_then(|own| self.fit(matches, own)) {
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
            .with(Reason::Evidence, !recent.fits)
            .with(Reason::Repeated, self.repeated)
            .with(Reason::Unfit, self.cause.is_some());
        verdict.depth_px = depth_px;
        verdict.rows_ok = !reasons.contains(Reason::Rows);
        verdict.depth_ok = !reasons.contains(Reason::Depth);
        verdict.state = self.state;
        verdict.may_arm = self.confirmed
            && matches!(self.state, State::Locked | State::Suspect)
            && !reasons.forbid_arming();
        verdict.should_apply =
            self.state == State::Locked && !reasons.is_doubtful() && (improves || deepens);
        verdict.reasons = reasons;
        verdict.cause = self.likeliest.or(self.cause);
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
    fn fit(&self, matches: &[RayPair<T>], own: &Own<T>) -> Option<Fit<T>> {
        let next = self.proposal.map_or(*self.in_use, |proposal| CorrectedExtrinsics {
            extrinsics: proposal.applicable,
            correction: proposal.applicable_correction,
        });
        let lens_yaw = self.proposal.map_or(T::ZERO, |proposal| proposal.lens_yaw.value);
        let both = [self.in_use, &next];
        let changes = both
            .map(|of| (of.correction != self.rays).then(|| self.rays.change_to(&of.correction)));
        // Rows are compared with rows, so that the yaw of the lens counts against neither calibration.
        let [used, next] = both.map(|of| MountPose::from(&of.extrinsics).with_lens(lens_yaw));
        let poses = [own.pose, used?, next?];
        let limit = T::single(self.config.fit_limit_px);
        let own_px = limit.max(T::lit(SCREEN_NOISES) * own.noise_px);
        // A matcher that tolerates more than the screen finds more.
        let px = own_px.max(T::single(self.config.rows_limit_px) * T::lit(SCREEN));
        let screens = [own_px, px].map(|px| px / self.focal);
        Sums::of(matches, &poses, &changes, screens).fit(self.focal)
    }
}

/// Fit of the calibration in use and of the estimate to a pair.
struct Fit<T> {
    /// Row offset beyond that of the pair's own pose, px, and share of the matches that fit.
    in_use: [T; 2],
    next: [T; 2],
    /// RMS difference between the row offsets in use and of the estimate, px.
    off_px: T,
    /// RMS row offset of the pair's own pose, px.
    own_px: T,
    image_coverage: T,
    nearness: T,
}

impl<T: Scalar> Fit<T> {
    /// Returns whether the estimate is clearly better than the calibration in use.
    ///
    /// * `over_pairs`: whether it is over all pairs, if that is known.
    fn improves(&self, over_pairs: Option<bool>) -> bool {
        let squared = |[rows_px, _]: [T; 2]| rows_px * rows_px + self.own_px * self.own_px;
        let least = T::lit(IMPROVEMENT * IMPROVEMENT);
        let over_pair = squared(self.next) < least * squared(self.in_use);
        self.off_px >= T::lit(BAD_PX) || over_pairs.unwrap_or(over_pair)
    }
}

/// Sums over the matches of a pair that fit its own pose.
struct Sums<T> {
    /// Numbers of matches that fit the pair's own pose, the calibration in use and the estimate.
    matches: [u32; 3],
    /// Row offsets in use minus own, of the estimate minus own, and in use minus of the estimate.
    differences: [SquaresBySize<T>; 3],
    /// Sum of the squared row offsets of the own pose.
    own: T,
    /// Sum of `(x_l^2 - x_r^2)^2`.
    nearness: T,
    seen: CellSet,
}

impl<T: Scalar> Sums<T> {
    /// Takes the sums over at most [`JUDGED`] matches.
    ///
    /// * `poses`: of the pair, in use, of the estimate; `changes`: changes of the right rays from the cameras of the
    ///   batch to the cameras of the last two; `screens`: largest row offset of a match that fits the pair's own pose,
    ///   and that fits the others; at unit focal length.
    fn of(
        matches: &[RayPair<T>],
        poses: &[RowsPose<T>; 3],
        changes: &[Option<RayChange<T>>; 2],
        [own_screen, screen]: [T; 2],
    ) -> Self {
        let none = SquaresBySize::none(own_screen * T::lit(FIRST_ROW_LEVEL));
        let mut sums = Self {
            matches: [0; 3],
            differences: [none; 3],
            own: T::ZERO,
            nearness: T::ZERO,
            seen: CellSet::NONE,
        };
        let [own, used, next] = poses.each_ref().map(RowsPose::rotations);
        let stride = matches.len().div_ceil(JUDGED).max(1);
        for pair in matches.iter().step_by(stride) {
            let Some(offset) =
                pixel_row_offset(own, pair).filter(|offset| offset.abs() <= own_screen)
            else {
                continue;
            };
            let [x_l, _, x_r, _] = pair.rays();
            let nearness = x_l * x_l - x_r * x_r;
            sums.own += offset * offset;
            sums.nearness += nearness * nearness;
            sums.seen.insert(pair.cell());
            let [of_used, of_next] =
                changes.map(|change| change.map_or(*pair, |change| pair.changed(&change)));
            let others = [pixel_row_offset(used, &of_used), pixel_row_offset(next, &of_next)];
            let [all, fit @ ..] = &mut sums.matches;
            *all = all.saturating_add(1);
            for (count, other) in fit.iter_mut().zip(others) {
                let fits = other.is_some_and(|other| other.abs() <= screen);
                *count = count.saturating_add(fits.into());
            }
            if let [Some(used), Some(next)] = others {
                let all = [used - offset, next - offset, used - next];
                sums.differences.iter_mut().zip(all).for_each(|(sum, one)| sum.add(one));
            }
        }
        sums
    }

    /// Returns the fit; `None` without more matches than unknowns.
    ///
    /// * `focal`: mean focal length, px.
    fn fit(&self, focal: T) -> Option<Fit<T>> {
        let [all, used, next] = self.matches.map(T::count);
        let unknowns = T::lit(UNKNOWNS);
        if !(all > unknowns) {
            return None;
        }
        let variance = self.own / (all - unknowns);
        let [in_use, of_next, off] = self.differences.each_ref().map(SquaresBySize::rms);
        // The own pose follows the noise of the pair: its row offsets are off by the noise of five unknowns.
        let by_noise = variance * unknowns / all;
        let beyond = |rms: T| (rms * rms - by_noise).max(T::ZERO).sqrt() * focal;
        Some(Fit {
            in_use: [beyond(in_use), used / all],
            next: [beyond(of_next), next / all],
            off_px: off * focal,
            own_px: variance.sqrt() * focal,
            image_coverage: self.seen.share(),
            nearness: self.nearness / all,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns after how many of the pairs the rig is fit to arm.
    fn fits(pairs: &[Option<bool>]) -> [bool; 8] {
        let mut recent = Recent::<f32>::NONE;
        core::array::from_fn(|i| {
            match pairs.get(i) {
                Some(Some(fits)) => recent.add(*fits, *fits),
                Some(None) => recent.add_unsolved(),
                None => {}
            }
            recent.fits
        })
    }

    #[test]
    fn two_good_pairs_in_a_row_arm_and_two_bad_ones_disarm() {
        let [good, bad] = [true, false].map(Some);
        let pairs = [good, bad, good, good, bad, good, bad, bad];
        let armed = [false, false, false, true, true, true, true, false];
        assert_eq!(fits(&pairs), armed);
        // A pair without a solution is no evidence either way.
        assert_eq!(
            fits(&[good, None, good, bad, None, bad])[..6],
            [false, false, true, true, true, false]
        );
    }

    #[test]
    fn without_any_evidence_it_ends() {
        let mut recent = Recent::<f32>::NONE;
        recent.add(true, true);
        recent.add(true, true);
        let pairs = (1..100).find(|_| {
            recent.add_unsolved();
            !recent.fits
        });
        assert_eq!(pairs, Some(MAX_UNSOLVED));
    }

    #[test]
    fn a_pair_that_misses_the_new_calibration_is_the_first_of_two_that_disarm() {
        for next_fits in [true, false] {
            let mut recent = Recent::<f32>::NONE;
            recent.add(true, true);
            recent.add(true, next_fits);
            recent.change();
            assert!(recent.fits);
            recent.add(false, false);
            assert_eq!(recent.fits, next_fits);
        }
    }

    #[test]
    fn a_new_calibration_that_fits_the_last_pair_needs_one_more() {
        for (next_fits, armed) in [(true, true), (false, false)] {
            let mut recent = Recent::<f32>::NONE;
            recent.add(false, next_fits);
            recent.change();
            recent.add(true, true);
            assert_eq!(recent.fits, armed);
        }
    }
}
