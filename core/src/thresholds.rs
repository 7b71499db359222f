//! Thresholds of the estimator, in the order of the walk: geometry, batch, pair, fusion, outcome,
//! paper. `ESTIMATOR.md` derives what they are compared with.
//!
//! Each one states its unit, its reason, and what a larger and a smaller value do. A suffix names
//! the unit (`_PX`, `_RAD`); without one the number is a count or dimensionless. Sizes of memory
//! layouts and of wire formats are not here. Values that a user sets are in [`crate::Config`].

// Geometry.

/// Depth of a rectified unit-depth ray (87 degrees off axis); a shallower ray is skipped.
/// Larger skips rays at the border; smaller lets the row offset's `1 / z` grow.
pub(crate) const MIN_DEPTH: f64 = 0.05;

/// Part of the unit baseline across each optical axis (sine of 6 degrees).
/// Larger refuses rigs that can be rectified; smaller nears the pole of the gauge.
pub(crate) const MIN_LATERAL: f64 = 0.1;

/// Turn of one view in one step. Larger leaves the range of the exponential's series;
/// smaller refuses steps from a distant start.
pub(crate) const MAX_STEP_RAD: f64 = 1.5;

/// Tangent of 85 degrees: rays further off axis have no useful unit-depth form.
/// Larger loses digits in `f32`; smaller cuts a fisheye image.
pub(crate) const MAX_TANGENT: f64 = 11.43;

/// Squared Frobenius norm of `M^T M - I` of a matrix that is taken for a rotation. The Newton-Schulz
/// steps converge for it. Larger accepts other matrices; smaller refuses rounded files.
pub(crate) const MAX_ROTATION_DEFECT: f64 = 0.04;

/// Newton-Schulz steps to the nearest rotation: defects 0.2, 3e-2, 7e-4, 4e-7, 1e-13, rounding.
/// More cost time; fewer leave a defect.
pub(crate) const NEWTON_SCHULZ_STEPS: usize = 6;

/// Newton steps of an undistortion, 3 to 5 are usual; a fisheye, bracketed, takes up to four times
/// as many. More bound the time worse; fewer refuse pixels near the fold.
pub(crate) const MAX_NEWTON_STEPS: usize = 12;

/// Newton has converged at this step, in units in the last place of `1 + |p|`.
/// Larger loses digits; smaller may never be reached.
pub(crate) const NEWTON_ULPS: f64 = 4.0;

/// The same of a fisheye's angle, in units in the last place of it.
pub(crate) const FISHEYE_NEWTON_ULPS: f64 = 2.0;

/// Start of Newton for a distorted point beyond the fold, as a part of the fold's radius.
/// Larger starts where the Jacobian is nearly singular; smaller takes more steps.
pub(crate) const NEWTON_START: f64 = 0.9;

/// Distortion coefficient, in size. Larger overflows in `f32`; smaller refuses real lenses.
pub(crate) const MAX_DISTORTION: f64 = 1e3;

/// Samples of a lens model between axis and limit: a fold narrower than one is not seen.
pub(crate) const FOLD_SAMPLES: u32 = 256;

/// Bisections of the sample that holds the fold: below the resolution of `f32`.
pub(crate) const FOLD_BISECTIONS: usize = 30;

// Pair: loss and noise.

/// Tukey's limit in standard deviations: 95 % efficient on Gaussian noise.
/// Larger admits outliers; smaller discards inliers.
pub(crate) const TUKEY: f64 = 4.685;

/// First scale of the annealed loss, px: 5 degrees at a focal length of 1400 px.
/// Larger averages over outliers and takes more passes; smaller misses a rig that is further off.
pub(crate) const FIRST_SCALE_PX: f64 = 120.0;

/// Each scale over the one before. Larger takes more passes; smaller skips the basin.
pub(crate) const ANNEALING: f64 = 0.5;

/// The same for a batch of at most [`FEW`]: few correspondences follow only small changes.
pub(crate) const SLOW_ANNEALING: f64 = 0.7;

/// Correspondences up to which annealing is slow and takes twice the passes: no more work than a
/// batch of twice the size. Larger costs time; smaller loses small batches.
pub(crate) const FEW: usize = 128;

/// Scale at or below which Tukey at the noise takes over, px. Larger starts it before the optimum is
/// within reach of the noise; smaller spends passes.
pub(crate) const LAST_SCALE_PX: f64 = 7.5;

/// Noise of a coordinate at the start of a search, px, and what a found pose stays below: over a flat
/// background the estimate grows. Larger takes outliers for a consensus; smaller refuses poor matchers.
pub(crate) const FIRST_NOISE_PX: f64 = 1.5;

/// Largest noise of a coordinate, px. Larger lets the loss widen without end among outliers;
/// smaller takes the inliers of a poor matcher for outliers.
pub(crate) const MAX_NOISE_PX: f64 = 3.0;

/// Smallest unit of the loss, in steps of the matcher's grid. Smaller locks on the mode of rounded
/// rows, not on their mean (9 to 26 times the bound); larger dulls the loss.
pub(crate) const MIN_UNIT: f64 = 0.6;

/// Residuals that the noise is estimated from, and that count as near, in units of the loss.
/// Larger lets outliers in; smaller leaves fewer.
pub(crate) const NEAR: f64 = 2.0;

/// Variance of a unit normal distribution that is cut off at [`NEAR`] deviations. Follows from it.
pub(crate) const TRUNCATED_VARIANCE: f64 = 0.7737;

/// Residuals that count as inliers, in units of the loss.
pub(crate) const INLIER: f64 = 3.0;

/// Outer edge of the band beside the peak, in units of the loss. Outliers fill it as densely as the
/// peak: [`NEAR`] to this is as wide as the peak itself.
pub(crate) const BESIDE: f64 = 4.0;

/// Variance of a row offset, and of a disparity, over that of one coordinate: each view adds its own.
pub(crate) const DIFFERENCE_VARIANCE: f64 = 2.0;

/// Part of the near residuals that counts as degrees of freedom at least. Keeps the noise of a tiny
/// batch finite. Larger understates its noise; smaller lets it grow.
pub(crate) const MIN_FREEDOM: f64 = 0.5;

/// Disparity below zero that a match may have, px: noise reaches below zero.
/// Larger admits outliers behind infinity; smaller cuts far inliers on one side, which biases yaw.
pub(crate) const MIN_DISPARITY_PX: f64 = 4.0;

/// Deviations of yaw that are allowed for in a disparity: yaw moves all of them alike.
/// Larger hears less from scenes of one depth; smaller takes an error of yaw for a scene.
pub(crate) const YAW_DEVIATIONS: f64 = 3.0;

/// Part of the squared disparities that may be noise. Larger lets a scene at infinity tell of the
/// baseline; smaller refuses far scenes.
pub(crate) const MAX_DISPARITY_NOISE: f64 = 0.75;

// Pair: leverage.

/// Information on the baseline that a correspondence carries, in mean shares of the pass before; the
/// weight falls with the square beyond. Larger lets a near outlier rule `t`; smaller loses near inliers.
/// 3 to 10 are equal in scenes 30 to 800 baselines deep.
pub(crate) const MAX_LEVERAGE: f64 = 8.0;

/// The same before the first step of a track, in squares of the mean root: outliers hardly move it.
pub(crate) const FIRST_MAX_LEVERAGE: f64 = 20.0;

/// Correspondences that the first limit is learnt from. More cost time; fewer make it noisy.
pub(crate) const SURVEYED: usize = 32;

// Pair: passes.

/// Passes of a track: a survey, two steps, the evaluation.
pub(crate) const TRACK_PASSES: u16 = 4;

/// Correspondences that a step of a track reads; of a larger batch every second one. The pose decides
/// weights only, so that half of them cost a hundredth of the deviation.
pub(crate) const TRACKED: usize = 128;

/// Squared step in standard deviations at which a search has converged: what is left adds less than
/// half a per cent to the variance. Larger stops early; smaller spends passes.
pub(crate) const NEGLIGIBLE: f64 = 1e-2;

/// Relative change of the noise at which it has settled. Larger stops early; smaller spends passes.
pub(crate) const SETTLED: f64 = 0.05;

/// Passes that evaluation and comparison take beyond the configured limit: the bound of `solve_pair`.
pub(crate) const SPARE_PASSES: u16 = 8;

// Pair: what a pose must show.

/// Near residuals over those beside at a pose found from afar. Outliers alone show 1.
/// Larger refuses pairs full of outliers; smaller accepts chance.
pub(crate) const FOUND_PEAK: f64 = 2.0;

/// Excess of near residuals over those beside, in deviations of chance, at a pose found from afar.
pub(crate) const FOUND_PEAK_DEVIATIONS: f64 = 3.0;

/// Part of the usable correspondences that are near at a pose found from afar.
/// Larger refuses pairs full of outliers; smaller accepts a local optimum.
pub(crate) const FOUND_NEAR: f64 = 0.15;

/// Near residuals over those beside at the pose of a track, which is known already.
pub(crate) const TRACK_PEAK: f64 = 1.5;

/// Near residuals at the pose of a track. Larger rejects small batches; smaller believes chance.
pub(crate) const TRACK_MIN_NEAR: u32 = 8;

/// Excess in deviations of chance that a pair of a challenger shows as well: it is not yet confirmed.
pub(crate) const CLEAR_PEAK_DEVIATIONS: f64 = 2.0;

/// Smallest eigenvalue of the information with unit diagonal; below it a direction is free.
/// Larger refuses weak scenes; smaller accepts rounding of `f32` as information.
pub(crate) const MIN_CONDITION: f64 = 1e-5;

/// Iterations of the power method for an extreme eigenvalue. More cost time; fewer lose digits.
pub(crate) const POWER_ITERATIONS: usize = 12;

// Fusion: one hypothesis.

/// Normalised innovation squared (NIS) of a pair over the reduced chi-square; chi-square of 5 degrees
/// of freedom exceeds it with 4e-5. Larger follows a step later; smaller rejects good pairs.
pub(crate) const MAX_NIS: f64 = 28.0;

/// [`MAX_NIS`] is so many times larger for a challenger without a champion: it may still be a few
/// deviations off.
pub(crate) const YOUNG_SLACK: f64 = 2.0;

/// Inlier share of a pair over the usual one. Larger rejects poor pairs; smaller accepts outliers.
pub(crate) const MIN_INLIER_RATIO: f64 = 0.5;

/// Motion of a rig from pair to pair that is no change, rad (0.005 degrees), each unknown.
/// Larger hides small steps; smaller rejects pairs of a vibrating rig.
pub(crate) const VIBRATION_RAD: f64 = 8.7e-5;

/// Freedom of a pair about the estimate it is tracked from, rad (0.05 degrees), each unknown.
/// Larger weakens the covariance gating of outliers; smaller is stiff against a small step.
pub(crate) const FREEDOM_RAD: f64 = 8.7e-4;

/// Largest reduced chi-square of a pair that is believed: real lenses leave 3 to 10.
/// Larger lets a false pair widen the gate; smaller reports too small a deviation.
pub(crate) const MAX_REDUCED_CHI_SQUARE: f64 = 16.0;

/// Pairs of reduced chi-square 1 that its mean starts from. Larger learns later; smaller is noisier.
pub(crate) const CHI_SQUARE_PAIRS: f64 = 4.0;

/// Pairs in the running means of noise, inlier share and reduced chi-square.
/// Larger follows a changing scene later; smaller is noisier.
pub(crate) const AVERAGED_PAIRS: u32 = 50;

/// Reported standard deviation above which nothing is locked, rad, of `R` and of `t`.
/// Larger locks on weak pairs; smaller waits in far scenes.
pub(crate) const MAX_LOCKED_SD_RAD: f64 = 0.12;

/// What a further pair leaves of a followed drift in the covariance. Larger reports it longer.
pub(crate) const DRIFT_DECAY: f64 = 0.9;

/// Gauss-Newton steps to the optimum of all sums: each squares the error of the linearisation.
pub(crate) const OPTIMUM_STEPS: usize = 3;

/// Squared step after which the next one is below rounding, rad^2. Smaller costs time.
pub(crate) const LAST_STEP_SQUARED: f64 = 1e-8;

// Fusion: association.

/// Pairs behind a challenger that takes over. Larger follows a step later; smaller follows chance.
pub(crate) const MIN_AGREED: u16 = 3;

/// Contradictions that a challenger is dropped after. Larger keeps a false one; smaller drops a true
/// one for a poor pair.
pub(crate) const MAX_FAILED: u16 = 2;

/// Rejected pairs in a row after which the rig is lost, and every second search starts at the factory
/// extrinsics. Larger reports it later; smaller reports garbage as lost.
pub(crate) const LOST_AFTER: u16 = 10;

/// Row offset that costs fully when two poses are compared, px. Larger lets outliers decide;
/// smaller compares noise.
pub(crate) const TRUNCATED_PX: f64 = 2.0;

/// Mean truncated cost (0 to 1) by which a new pose must be better than the challenger's.
/// Larger keeps a false challenger; smaller swaps by chance.
pub(crate) const CLEARLY_BETTER: f64 = 0.04;

// Fusion: change detection.

/// What a further pair leaves in the short and in the long window: about 10 and 50 pairs.
/// Larger sees smaller changes later; smaller sees larger ones sooner.
pub(crate) const SHORT_DECAY: f64 = 0.9;
pub(crate) const LONG_DECAY: f64 = 0.98;

/// Pairs that the short window counts as once it replaces the older ones: `1 / (1 - SHORT_DECAY)`.
pub(crate) const SHORT_PAIRS: u32 = 10;

/// Normalised score squared of a window over the reduced chi-square: 4e-5 by chance a window.
/// Larger sees drift later; smaller renews by chance.
pub(crate) const MAX_WINDOW: f64 = 28.0;

/// NIS that each pair may add to the cumulative sum for nothing: the mean 5, and 4 more.
/// Larger misses small changes; smaller sums up model error.
pub(crate) const CUSUM_ALLOWED: f64 = 9.0;

/// Limit of the cumulative sum. Larger detects later; smaller detects chance.
pub(crate) const MAX_CUSUM: f64 = 60.0;

/// Pairs before change is detected: the least that replace the older ones.
/// Larger detects later; smaller leaves a weak estimate.
pub(crate) const WARM_UP_PAIRS: u32 = 4;

// Fusion: image halves.

/// Disagreement of image halves that leaves the covariance as it is; 1e-3 by chance an axis.
/// Larger reports too small a deviation of biased matches; smaller widens healthy ones.
pub(crate) const HEALTHY_DISAGREEMENT: f64 = 2.0;

/// Error of the halves' first-order models after a step, in deviations of the estimate; beyond it they
/// start anew. Larger compares wrong models; smaller forgets often.
pub(crate) const MAX_MODEL_ERROR: f64 = 0.1;

/// Largest disagreement that is told apart: its square stays finite.
pub(crate) const MAX_TOLD_DISAGREEMENT: f64 = 1e4;

// Fusion: repeated scenes.

/// Correspondences remembered of a pair: the bits of a word. Fewer make the share noisy.
pub(crate) const REMEMBERED: usize = 32;

/// Steps of remembered coordinates in a pixel.
pub(crate) const REMEMBERED_STEPS_PER_PX: f64 = 4.0;

/// Motion of each coordinate of a correspondence that is seen again, steps (1.5 px), at most 15 (half
/// a bucket). Larger takes slow motion for rest; smaller misses it under noise.
pub(crate) const SAME_STEPS: u16 = 6;

/// Share of remembered correspondences seen again in a repeated scene: recordings of standing cameras
/// show 0.6 to 0.8, of moving ones up to 0.13. Larger counts a scene twice; smaller drops new ones.
pub(crate) const SAME_SHARE: f64 = 0.3;

// Outcome.

/// Disagreement of image halves above which the baseline is not applied, and above which nothing is.
/// Larger applies biased estimates; smaller refuses healthy ones (below 2.3 in synthetic scenes).
pub(crate) const MAX_DISAGREEMENT: [f64; 2] = [3.0, 5.0];

/// Huber thresholds within which a correspondence is screened.
pub(crate) const SCREEN: f64 = 3.0;

/// RMS row offset from which on a matcher that searches along rows misses, px.
pub(crate) const BAD_PX: f64 = 1.0;

/// RMS row offset of the proposal over that in use, below which a change is worth it.
pub(crate) const IMPROVEMENT: f64 = 0.9;

/// Of the published method.
#[cfg(feature = "paper")]
pub(crate) mod paper {
    /// Damping of the first step, relative to the diagonal. Larger is slower; smaller overshoots.
    pub(crate) const FIRST_DAMPING: f64 = 1e-4;

    /// Damping above which a small step tells nothing of convergence, and the range it is tried in.
    pub(crate) const LOOSE_DAMPING: f64 = 1e-2;
    pub(crate) const MIN_DAMPING: f64 = 1e-9;
    pub(crate) const MAX_DAMPING: f64 = 1e8;

    /// Nielsen's rule: least and most factor of the damping after an accepted step, and how the factor
    /// of rejected ones grows.
    pub(crate) const DAMPING_FACTOR: [f64; 2] = [0.1, 2.0];
    pub(crate) const DAMPING_GROWTH: f64 = 2.0;

    /// Smallest step tolerance in units in the last place of 1 rad: below it the pose does not move.
    pub(crate) const TOLERANCE_ULPS: f64 = 8.0;

    /// Rounding of the cost in units in the last place, from where on slopes decide.
    pub(crate) const COST_ULPS: f64 = 2.0;

    /// Angle of `R` below which its axis is noise, and above which it may be reversed, rad.
    pub(crate) const MIN_ANGLE_RAD: f64 = 3e-3;
    pub(crate) const MAX_ANGLE_RAD: f64 = 3.0;

    /// Length of the mean unit axis below which pairs do not agree on one.
    pub(crate) const MIN_CONCENTRATION: f64 = 0.9;

    /// Length of the mean baseline below which directions cancel.
    pub(crate) const MIN_MEAN_BASELINE: f64 = 1e-3;

    /// Values that the median sorts before it goes on by steps.
    pub(crate) const MEDIAN_VALUES: usize = 31;

    /// Smallest deviation that the median's steps are made of, rad: equal values must not stop it.
    pub(crate) const MIN_DEVIATION_RAD: f64 = 1e-6;

    /// Step of the median over the median absolute deviation: 1.4826 makes it a standard deviation,
    /// 1.2533 = sqrt(pi / 2) one over twice the normal density at the median.
    pub(crate) const MEDIAN_STEP: f64 = 1.4826 * 1.2533;
}
