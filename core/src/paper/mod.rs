//! The complete published method (eqs 9 to 22), separate from `pair` and `fusion`. It is a reference and a baseline for
//! comparison.
//!
//! - `residual`, `loss`: row offset, derivatives, Huber weight. `solver`, `evaluation`: one pair, from the factory
//!   extrinsics.
//! - `gate`, `mean_direction`: many pairs. `compensated`, `median`: their sums and central angle.
//!
//! `host-tests/evidence` tests the whole method: `tests/evidence/errata.rs`, and `src/rivals/literal_paper.rs`, a
//! literal transcription with 6 parameters.
//!
//! *Residual* `e = v_l - v_r` (11). A left perturbation `w` gives `dv = -(1 + v^2) w_x + u v w_y + u w_z` (14, 15). In
//! the five unknowns, with `d = u_l - u_r`: `J = [-(1 + v_l^2), u_l v_l, u_l, d v_l + u_r e, d - s e (v_l + v_r)]`. The
//! row `e_0` and the sixth parameter of the paper fix only the gauge.
//!
//! *Solver* (16 to 19). Huber weights `min(1, c_t / |e|)`; Levenberg-Marquardt `(H + lambda diag H) x = -g`. A step is
//! kept only if the cost falls; a ray behind a camera costs as much as a row offset of 1. After a kept step, Nielsen's
//! rule multiplies `lambda` by a factor within `DAMPING_FACTOR`. If the change of the cost is below its rounding, it is
//! computed as `(g_0 + g_1) . x / 2`, exact for a quadratic (approximate Wolfe condition, Hager and Zhang). The
//! information of `n` rows, `m` of them within `c_t`, is:
//!
//! ```text
//! information = (sum over |e| <= c_t of J J^T, less disparity noise) m / (n variance)
//! variance    = max( sum min(|e|, c_t)^2 / (n - 5), floor^2 )
//! ```
//!
//! Let `H` be this sum of `J J^T`. `H_44` is reduced by `m variance` (`less_disparity_noise`). A pair is refused unless
//! `variance (m + 9 H_00 / H_11) <= MAX_DISPARITY_NOISE H_44`; this allows for a yaw error of 3 deviations.
//!
//! *Fusion* (20 to 22). `t* = normalize(sum t_k)`; `R* = exp([s* v*]x)` where `v*` is the normalised sum of the unit
//! axes, and `s*` is the mean or median of the angles. All sums are compensated; all except the sum of the axes are of
//! differences from the first pair. The median is exact over `MEDIAN_VALUES` angles; then it follows Robbins and Monro,
//! `m += MEDIAN_STEP mad sign(x - m) / n`. The reported deviations are the standard errors of the means. If the axes
//! are noise, as near `R = I`, or the angle is close to a half turn, the estimate has `Reason::Axis`.
//!
//! *Errata*, 1 to 9 in this order, each with a test: (14) prints `J_0` with the opposite sign; (12) has `theta_l` for
//! `theta_r`; (8) lacks a normalisation; the public code returns `+r_r1` for `t`; the text says "insufficiently" small
//! and means sufficiently; (20), (23) fail at 0 and pi, where `arccos` loses the digits of `f32`; (18) alone does not
//! survive gross outliers; (12) with `e_0` at weight 1 lets outliers bend the gauge by up to 2.3e-4 rad; (3) exchanges
//! `p_l` and `p_r`.

mod compensated;
mod evaluation;
mod gate;
mod loss;
pub(crate) mod mean_direction;
mod median;
pub(crate) mod residual;
pub(crate) mod solver;

use crate::batch::correspondence::RayPair;
use crate::config::Context;
pub use crate::config::paper::{Central, Settings};
use crate::error::Rejection;
use crate::geometry::lens_correction::LensCorrection;
use crate::outcome::lens_estimate::Finding;
use crate::outcome::pair_report::{Fused, PairReport};
use crate::outcome::proposal::Proposal;
use crate::outcome::reasons::{Reason, Reasons};
use crate::outcome::vibration::Vibration;
use crate::scalar::Scalar;
use crate::state::State;
pub use mean_direction::{FusedEstimate, MeanDirection};
pub use solver::HuberSolver;

/// State of the published method.
#[derive(Debug, Clone)]
pub(crate) struct Paper<T: Scalar> {
    fusion: MeanDirection<T>,
    /// The pair being solved.
    solver: Option<HuberSolver<T>>,
    /// The solved pair, until it is fused.
    solved: Option<PairReport<T>>,
}

impl<T: Scalar> Paper<T> {
    pub(crate) const fn new(angle: Central) -> Self {
        Self { fusion: MeanDirection::new(angle), solver: None, solved: None }
    }

    /// Forgets all pairs.
    pub(crate) fn reset(&mut self) {
        // Assigned from a constant, because a value made here would pass through the stack.
        self.fusion = match self.fusion.central() {
            Central::Mean => const { MeanDirection::new(Central::Mean) },
            Central::Median => const { MeanDirection::new(Central::Median) },
        };
        (self.solver, self.solved) = (None, None);
    }

    /// Discards the pair, whether it is solved or being solved.
    pub(crate) fn discard(&mut self) {
        (self.solver, self.solved) = (None, None);
    }

    /// Begins to solve a batch, and takes its first pass.
    ///
    /// # Errors
    /// [`Rejection::TooFew`], [`Rejection::Unobservable`]; no pair is being solved then.
    #[inline(never)]
    pub(crate) fn begin(
        &mut self,
        context: &Context<'_, T>,
        matches: &[RayPair<T>],
    ) -> Result<(), Rejection> {
        self.discard();
        let Context { config, factory, focal, .. } = *context;
        self.solver = Some(HuberSolver::begin(config, focal, factory, matches)?);
        Ok(())
    }

    /// Takes one more pass; returns true, without a pass, once only the evaluation pass is left.
    ///
    /// # Errors
    /// [`Rejection::NotBegun`].
    pub(crate) fn advance(&mut self, matches: &[RayPair<T>]) -> Result<bool, Rejection> {
        let solver = self.solver.as_mut().ok_or(Rejection::NotBegun)?;
        let solved = solver.is_done();
        if !solved {
            solver.advance(matches);
        }
        Ok(solved)
    }

    /// Takes the evaluation pass, and returns the report of the pair. Returns it again until [`Self::close`].
    ///
    /// # Errors
    /// [`Rejection`]; there is no pair to fuse then.
    pub(crate) fn report(&mut self, matches: &[RayPair<T>]) -> Result<PairReport<T>, Rejection> {
        if let Some(report) = self.solved {
            return Ok(report);
        }
        let report = self.solver.as_ref().ok_or(Rejection::NotBegun)?.report(matches);
        self.solver = None;
        self.solved = report.ok();
        report
    }

    /// Fuses the solved pair. Called once for a pair.
    ///
    /// # Errors
    /// [`Rejection`]; the estimate is unchanged.
    #[inline(never)]
    pub(crate) fn fuse(
        &mut self,
        context: &Context<'_, T>,
        _: &[RayPair<T>],
    ) -> Result<Fused, Rejection> {
        let report = self.solved.ok_or(Rejection::NotBegun)?;
        gate::admit(context, &report)?;
        // On a copy, because the mean of pairs within the limit may exceed the limit.
        let mut fusion = self.fusion.clone();
        fusion.add(&report);
        if fusion.estimate().is_some_and(|estimate| !context.allows(&estimate.extrinsics)) {
            return Err(Rejection::CorrectionLimit);
        }
        self.fusion = fusion;
        Ok(Fused::Added)
    }

    /// Ends the solved pair.
    pub(crate) fn close(&mut self) {
        self.solved = None;
    }

    pub(crate) fn has_pairs(&self) -> bool {
        self.fusion.pairs() > 0
    }

    pub(crate) fn state(&self) -> State {
        if self.has_pairs() { State::Locked } else { State::Acquiring }
    }

    /// Returns the estimate; `None` before the first pair, if the directions cancel, or if the mean cannot be
    /// rectified.
    pub(crate) fn proposal(&self) -> Option<Proposal<T>> {
        let estimate = self.fusion.estimate()?;
        Some(Proposal {
            lens_yaw: Finding { value: T::ZERO, sd: T::ZERO },
            vibration: Vibration::NONE,
            extrinsics: estimate.extrinsics,
            correction: LensCorrection::NONE,
            applicable: estimate.extrinsics,
            applicable_correction: LensCorrection::NONE,
            pairs: estimate.pairs,
            sd: estimate.sd,
            covariance: None,
            sd_lens: estimate.sd,
            covariance_lens: None,
            lens: None,
            baseline_observed: true,
            improves: None,
            state: self.state(),
            doubts: Reasons::NONE.with(Reason::Axis, !estimate.axis_is_meaningful),
        })
    }
}
