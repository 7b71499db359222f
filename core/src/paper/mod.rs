//! The complete published method (eqs 9 to 22), separate from the robust estimator. It is a reference and a baseline
//! for comparison. [`PaperCalibrator`] is its facade.
//!
//! - `residual`, `loss`: row offset, derivatives, Huber weight. `solver`, `evaluation`, `disparity_noise`: one pair, from
//!   the start extrinsics.
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
//! are noise, as near `R = I`, or the angle is close to a half turn, [`FusedEstimate::axis_is_meaningful`] is false.
//!
//! *Errata*, 1 to 9 in this order, each with a test: (14) prints `J_0` with the opposite sign; (12) has `theta_l` for
//! `theta_r`; (8) lacks a normalisation; the public code returns `+r_r1` for `t`; the text says "insufficiently" small
//! and means sufficiently; (20), (23) fail at 0 and pi, where `arccos` loses the digits of `f32`; (18) alone does not
//! survive gross outliers; (12) with `e_0` at weight 1 lets outliers bend the gauge by up to 2.3e-4 rad; (3) exchanges
//! `p_l` and `p_r`.

mod calibrator;
mod compensated;
mod disparity_noise;
mod evaluation;
mod gate;
mod loss;
mod mean_direction;
mod median;
mod residual;
mod settings;
mod solver;

pub use calibrator::PaperCalibrator;
pub use mean_direction::{FusedEstimate, MeanDirection};
pub use settings::{Central, Settings};
pub use solver::HuberSolver;
