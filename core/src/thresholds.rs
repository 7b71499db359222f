//! Thresholds of the estimator, in the order of the walk: geometry, pair, fusion, outcome, paper.
//! `ESTIMATOR.md` derives what they are compared with.
//!
//! Each one states its unit, its reason, and what a larger and a smaller value do. A suffix names
//! the unit (`_PX`, `_RAD`); without one the number is a count or dimensionless. Sizes of memory
//! layouts and of wire formats are not here. Values that a user sets are in [`crate::Config`].

mod pair;

pub(crate) use pair::*;

// Geometry.

/// Depth of a rectified unit-depth ray (87 degrees off axis); a shallower ray is skipped. Larger
/// skips rays at the border; smaller lets the row offset's `1 / z` grow.
pub(crate) const MIN_DEPTH: f64 = 0.05;

/// Part of the unit baseline across each optical axis (sine of 6 degrees). Larger refuses rigs that
/// can be rectified; smaller nears the pole of the gauge.
pub(crate) const MIN_LATERAL: f64 = 0.1;

/// Turn of one view in one step. Larger trusts a linearisation beyond its range; smaller refuses
/// steps from a distant start.
pub(crate) const MAX_STEP_RAD: f64 = 1.5;

/// Tangent of 85 degrees: rays further off axis have no useful unit-depth form. Larger loses digits
/// in `f32`; smaller cuts a fisheye image.
pub(crate) const MAX_TANGENT: f64 = 11.43;

/// Squared Frobenius norm of `M^T M - I` of a matrix taken for a rotation, and Newton-Schulz steps
/// to the nearest one, 0.2 to 1e-13. Larger accepts other matrices; smaller refuses rounded files.
pub(crate) const MAX_ROTATION_DEFECT: f64 = 0.04;
pub(crate) const NEWTON_SCHULZ_STEPS: usize = 6;

/// Newton steps of an undistortion, 3 to 5 are usual; a bracketed fisheye takes up to four times as
/// many. Larger raises the worst time; smaller refuses pixels near the fold.
pub(crate) const MAX_NEWTON_STEPS: usize = 12;

/// Last Newton step in units in the last place, of one plus the point's size and of a fisheye's
/// angle. Larger loses digits; smaller may never be reached.
pub(crate) const NEWTON_ULPS: f64 = 4.0;
pub(crate) const FISHEYE_NEWTON_ULPS: f64 = 2.0;

/// Denominator of a rational lens at its smallest. Larger cuts the image of a lens that is nearly
/// singular there; smaller lets the quotient lose its digits.
pub(crate) const MIN_LENS_DENOMINATOR: f64 = 0.01;

/// Residual of an undistortion by a rational lens, distorted again, in units in the last place of one
/// plus the size of both points. Larger accepts points off their pixel; smaller refuses good ones.
pub(crate) const RATIONAL_RESIDUAL_ULPS: f64 = 256.0;

/// Start of Newton for a distorted point beyond the fold, as a part of the fold's radius. Larger
/// starts where the Jacobian is nearly singular; smaller takes more steps.
pub(crate) const NEWTON_START: f64 = 0.9;

/// Distortion coefficient, in size. Larger accepts files that hold no lens; smaller refuses lenses.
pub(crate) const MAX_DISTORTION: f64 = 1e3;

/// Samples of a lens model out to its limit, and bisections of the one that holds the fold. Larger
/// costs time when a camera is set; fewer samples miss a narrow fold, fewer bisections lose digits.
pub(crate) const FOLD_SAMPLES: u32 = 256;
pub(crate) const FOLD_BISECTIONS: usize = 30;

// Pair: in a file of its own.

// Fusion.

/// Normalised innovation squared (NIS) of a pair, and normalised score squared of a window, over the reduced chi-square;
/// 4e-5 by chance at most. Larger follows a step and sees drift later; smaller rejects good pairs and renews by chance.
pub(crate) const MAX_NIS: f64 = 28.0;

/// Inlier share of a pair over the usual one. Larger rejects poor pairs; smaller accepts outliers.
pub(crate) const MIN_INLIER_RATIO: f64 = 0.5;

/// Motion of a rig from pair to pair that is no change (0.005 degrees), each unknown. Larger hides
/// small steps; smaller rejects pairs of a vibrating rig.
pub(crate) const VIBRATION_RAD: f64 = 8.7e-5;

/// Samples from which on vibration is told, and deviations of their median by chance that it exceeds. Larger tells it
/// later; smaller by chance.
pub(crate) const MIN_VIBRATION_SAMPLES: usize = 4;
pub(crate) const VIBRATION_DEVIATIONS: f64 = 6.0;

/// Newest samples that count alone where their median exceeds so many deviations, and that of all so many times: a
/// vibration has begun; by the same ratio a mean is of another time. Larger notices it later; smaller by a knock.
pub(crate) const RECENT_VIBRATION_SAMPLES: usize = 7;
pub(crate) const RECENT_VIBRATION_DEVIATIONS: f64 = 8.0;
pub(crate) const VIBRATION_RATIO: f64 = 4.0;

/// Largest vibration (0.4 degrees). Larger takes knocks for it; smaller loses a shaken rig.
pub(crate) const MAX_VIBRATION_RAD: f64 = 7e-3;

/// Vibration of `R` from which on (0.03 degrees), and ratio of the deviations of baseline and `R` up to which, cameras
/// that turn explain it. Larger, then smaller, leaves vibration in the lens; the reverse hides a wrong lens.
pub(crate) const TURN_RAD: f64 = 5.2e-4;
pub(crate) const MAX_TURN_RATIO: f64 = 4.0;

/// Pairs that are forgotten, but the last, where they turn out to be shaken. Larger loses more; smaller keeps what is
/// no mean.
pub(crate) const FORGOTTEN_PAIRS: u32 = 16;

/// Freedom of a pair about the estimate it is tracked from (0.05 degrees), each unknown. Larger
/// weakens the covariance gating of outliers; smaller is stiff against a small step.
pub(crate) const FREEDOM_RAD: f64 = 8.7e-4;

/// Largest reduced chi-square that a pair contributes: real lenses leave 3 to 10. Larger lets a
/// false pair widen the gate; smaller reports too small a deviation.
pub(crate) const MAX_REDUCED_CHI_SQUARE: f64 = 16.0;

/// Pairs of reduced chi-square 1 that its mean starts from, and pairs in the running means of it,
/// of noise and of the inlier share. Larger follows a changing scene later; smaller is noisier.
pub(crate) const CHI_SQUARE_PAIRS: f64 = 4.0;
pub(crate) const AVERAGED_PAIRS: u32 = 50;

/// Reported standard deviation of `R` above which nothing locks. Larger locks on weak pairs; smaller
/// waits in poor scenes.
pub(crate) const MAX_LOCKED_SD_RAD: f64 = 0.12;

/// Variance of `t` over that of one of its two angles in the factory extrinsics (2 without pairs): up to
/// the first the baseline is observed, up to the second it is applied in any case. Larger applies what
/// is mostly the prior; smaller waits in far scenes.
pub(crate) const OBSERVED_BASELINE: f64 = 0.25;
pub(crate) const CERTAIN_BASELINE: f64 = 0.0625;

/// Squared distance of the baseline in use from an observed one over the covariance, from which on the
/// observed one is applied: 1 % by chance. Larger keeps a wrong baseline; smaller applies noise.
pub(crate) const SIGNIFICANT_BASELINE: f64 = 9.0;

/// Least pivot of the information on the lens, scaled to unit diagonal. Larger holds directions that pairs
/// determine; smaller divides by rounding.
pub(crate) const MIN_LENS_PIVOT: f64 = 1e-7;

/// Largest error of a lens in deviations of its prior. Larger reports what damaged sums say; smaller refuses lenses
/// that are far from theirs.
pub(crate) const MAX_LENS_VALUE: f64 = 1e3;

/// Part of an error of the lens that frozen weights may hide, `1 - E[psi'] / E[w]`: a deviation of its own. Larger
/// names the error later; smaller reports too small a deviation.
pub(crate) const LENS_SHRINKAGE: f64 = 0.17;

/// Largest correction of a lens, relative focal length and `k1`. Larger follows biases further; smaller leaves lenses
/// as they are.
pub(crate) const MAX_LENS_CORRECTION: f64 = 0.1;

/// Ratio of deviations of `t`, without and with compensation, from which on the lens is compensated. Larger leaves
/// errors in `t`; smaller takes biases of matches for a lens.
pub(crate) const COMPENSATION_GAIN: f64 = 2.0;

/// Part of the deviation of `t` that the weights may hide of a further correction. Larger begins again less often;
/// smaller by chance.
pub(crate) const MAX_HIDDEN_LENS: f64 = 0.1;

/// Widening of the variances of the lens that are kept when sums are dropped: twice the variances alone are never
/// less than the covariance of both. Larger learns again; smaller trusts an estimate with the weights of a wrong
/// lens.
pub(crate) const KNOWN_LENS_WIDENING: f64 = 2.0;

/// Pairs before the first change of the reference, doubled with each further one, up to so many times. More changes
/// later; fewer by the error of a few pairs.
pub(crate) const MIN_REFERENCE_PAIRS: u32 = 8;
pub(crate) const MAX_REFERENCE_CHANGES: u32 = 4;

/// Squared distance of the rows from the factory yaw, over the variance of both, from which on the mount has turned
/// since: 3 in 1000 by chance. Larger keeps the yaw of a rig that was knocked before it was first run; smaller takes an
/// error of the lens for a knock.
pub(crate) const REFUTED_FACTORY_YAW: f64 = 9.0;

/// Standard deviation of the yaw of the rows from scene to scene (0.03 degrees): other depths and regions weigh the same
/// lens otherwise. Larger takes small knocks in yaw for it; smaller takes it for knocks.
pub(crate) const SCENE_YAW_RAD: f64 = 5.2e-4;

/// Part of the squared turn of the rows that is added to it where nothing has confirmed the mount: the lens of one that has
/// turned hides more, by the chance `s^2 / 2 s_o^2`. Larger reports too large a deviation; smaller trusts the lens.
pub(crate) const TURNED_DOUBT: f64 = 0.5;

/// Pairs after which the rows are noted, and between which a knock is detected. Larger learns the lens later; smaller takes
/// a knock that is in the sums for the lens.
pub(crate) const ROWS_LAG: u16 = 16;

/// Distances that a range reading may have, m. Larger and smaller ones are faults of a sensor.
pub(crate) const MIN_RANGE_M: f64 = 0.01;
pub(crate) const MAX_RANGE_M: f64 = 1e5;

/// Distance of a match from the pixel of a range reading, px. Larger reads other surfaces; smaller finds no match.
pub(crate) const RANGE_REACH_PX: f64 = 3.0;

/// Relative standard deviation of the length of the baseline. Larger makes near readings weak; smaller takes an error of
/// the length for yaw.
pub(crate) const BASELINE_LENGTH_SD: f64 = 0.005;

/// Motion of the rig by tracked matches: how many are read, steps, first scale of the loss in deviations, which halves to
/// 1, squared residual of three freedoms that is an inlier (99 %), and share of inliers. More cost time; larger scales
/// and gates let outliers in, smaller ones lose a motion that is large or noisy; a larger share refuses more.
pub(crate) const MAX_TRACKED: usize = 256;
pub(crate) const MOTION_STEPS: usize = 16;
pub(crate) const MOTION_SCALE: f64 = 64.0;
pub(crate) const MOTION_GATE: f64 = 11.3;
pub(crate) const MOTION_INLIERS: f64 = 0.6;

/// Prior deviation of the turn that motion shows (1.1 degrees), and disparity behind infinity of a tracked match, in noise of
/// a coordinate. Larger diverges from poor starts; smaller pulls to the rows, and cuts far points.
pub(crate) const MOTION_TURN_RAD: f64 = 0.02;
pub(crate) const BEHIND_INFINITY: f64 = 10.0;

/// Noise of a coordinate of a tracked match over that across the rows. Larger lets outliers in, and weighs motion less;
/// smaller finds no motion where tracks are poorer than matches.
pub(crate) const TRACK_NOISE: f64 = 2.0;

/// Deviation that all witnesses together have at least (0.015 degrees): they share the length of the baseline and the
/// focal length. Larger gives them less weight; smaller trusts them beyond that.
pub(crate) const WITNESS_RAD: f64 = 2.6e-4;

/// Deviation of the apparent yaw of the lens above which the yaw is not confirmed (0.1 degrees). Larger names it later;
/// smaller names what a factory calibration leaves.
pub(crate) const MAX_CONFIRMED_YAW_RAD: f64 = 1.75e-3;

/// Standard deviation of the yaw of a factory calibration with boards (0.05 degrees), rad. Larger follows the rows; smaller
/// trusts the calibration further than it was measured.
pub(crate) const CALIBRATED_YAW_SD_RAD: f32 = 8.7e-4;

/// Standard deviation of a mount yaw of which nothing is known. Larger loses digits of the lens in `f32`; smaller pulls
/// the estimate to the factory extrinsics.
pub(crate) const UNKNOWN_YAW_RAD: f64 = 1.0;

/// Standard deviations from which on an error of the lens is named. Larger names it later; smaller by chance.
pub(crate) const LENS_FOUND: f64 = 3.0;

/// Factor per pair of a followed drift in the covariance. Larger reports it longer; smaller is overtaken by it.
pub(crate) const DRIFT_DECAY: f64 = 0.9;

/// Correction in use over the limit of that of the estimate: a baseline that is kept adds to it.
/// Larger takes up what no estimate says; smaller refuses a fit of `R` near the limit.
pub(crate) const MAX_IN_USE: f64 = 1.5;

/// Steps to the optimum of all sums, each of which squares the error of the linearisation, and the
/// squared step whose successor is below rounding. Larger costs time; smaller leaves an error.
pub(crate) const OPTIMUM_STEPS: usize = 3;
pub(crate) const LAST_STEP_SQUARED: f64 = 1e-8;

/// Part of the least known direction's information that the last step may move into it from the best known one. Larger
/// keeps an information that is not that of the pose; smaller costs time in far scenes.
pub(crate) const MOVED_INFORMATION: f64 = 0.1;

/// Pairs behind a challenger that takes over. Larger follows a step later; smaller follows chance.
pub(crate) const MIN_AGREED: u16 = 3;

/// Contradictions after which a challenger is dropped. Larger keeps a false one; smaller drops a
/// true one for a poor pair.
pub(crate) const MAX_FAILED: u16 = 2;

/// Rejected pairs in a row after which the rig is lost, and every second search starts at the
/// factory extrinsics. Larger reports it later; smaller reports garbage as lost.
pub(crate) const LOST_AFTER: u16 = 10;

/// Row offset from which on the truncated cost is 1. Larger lets outliers in; smaller compares noise.
pub(crate) const TRUNCATED_PX: f64 = 2.0;

/// Mean truncated cost (0 to 1) by which a new pose must be better than the challenger's. Larger
/// keeps a false challenger; smaller swaps by chance.
pub(crate) const CLEARLY_BETTER: f64 = 0.04;

/// Mean truncated cost (0 to 1) of a challenger above which poses with the baseline turned are tried: about the share of
/// outliers. Larger locks on a wrong baseline that fits some of the matches; smaller costs time.
pub(crate) const OPEN_COST: f64 = 0.4;

/// Factors per pair of the short and of the long window (about 10 and 50 pairs), and pairs that the short one counts as
/// when it replaces older ones, and that the share of a crowd is a mean of. Larger sees small changes later; smaller
/// forgets.
pub(crate) const SHORT_DECAY: f64 = 0.9;
pub(crate) const LONG_DECAY: f64 = 0.98;
pub(crate) const SHORT_PAIRS: u32 = 10;

/// Pairs before change is detected: the least that replace the older ones. Larger detects later;
/// smaller leaves a weak estimate.
pub(crate) const WARM_UP_PAIRS: u32 = 4;

/// Disagreement of image halves that leaves the covariance as it is; 1e-3 by chance an axis. Larger
/// reports too small a deviation of biased matches; smaller widens healthy ones.
pub(crate) const HEALTHY_DISAGREEMENT: f64 = 2.0;

/// The largest disagreement told apart: its square stays finite. Larger overflows in `f32`; smaller tells less.
pub(crate) const MAX_TOLD_DISAGREEMENT: f64 = 1e4;

/// Correspondences remembered of a pair, the bits of a word, and steps of their coordinates in a
/// pixel. Larger costs memory; smaller makes the share noisy.
pub(crate) const REMEMBERED: usize = 32;
pub(crate) const REMEMBERED_STEPS_PER_PX: f64 = 4.0;

/// Motion of each coordinate of a correspondence seen again, steps (1.5 px), at most 15 (half a
/// bucket). Larger takes slow motion for rest; smaller misses rest under noise.
pub(crate) const SAME_STEPS: u16 = 6;

/// Share of remembered correspondences seen again that makes a repeated scene: 0.6 to 0.8 at rest,
/// up to 0.13 in motion. Larger counts a scene twice; smaller drops new ones.
pub(crate) const SAME_SHARE: f64 = 0.3;

/// Share of remembered correspondences seen again unmoved, to a step, that makes a copy of the last pair. Larger takes
/// a copy for a measurement; smaller takes a scene at rest under little noise for a copy.
pub(crate) const COPIED_SHARE: f64 = 0.9;

// Outcome.

/// One in so many pairs that agree on nothing, from which on the cause that it shows is named: a turn of the baseline is
/// tried at every sixth pair. Larger names what is chance; smaller names nothing.
pub(crate) const CAUSE_SHARE: u32 = 8;

/// Error of a lens in deviations of its prior that no calibration leaves: the matches are of another lens. Larger arms with
/// a wrong lens; smaller disarms with one that was calibrated poorly.
pub(crate) const GROSS_LENS: f64 = 4.0;

/// Deviations by which disparities of matches that are moved alike scatter more than rows, over all pairs, from which on
/// there is depth. Larger disarms a far scene for longer; smaller arms with one image on both sides by chance.
pub(crate) const RELIEF_SHOWN: f64 = 5.0;

/// Difference of the motion between both images, px, up to which two matches are moved alike. Larger takes a far scene for
/// one image; smaller misses one image under noise.
pub(crate) const ALIKE_PX: f64 = 2.0;

/// Disagreement of image halves above which, with exact lenses, the baseline, and above which nothing, is
/// applied. Larger applies biased estimates; smaller refuses healthy ones (below 2.3).
pub(crate) const MAX_DISAGREEMENT: [f64; 2] = [3.0, 5.0];

/// Share of a second crowd over that of the inliers, means of the last pairs, above which either may be the scene.
/// Larger applies what may be a fence; smaller waits where the scene is clear.
pub(crate) const MAX_SECOND_CROWD: f64 = 0.8;

/// Huber thresholds to a screened row offset. Larger lets outliers into the RMS; smaller hides a bad calibration.
pub(crate) const SCREEN: f64 = 3.0;

/// Noise of a coordinate to a screened row offset, where that is more: three deviations. Larger and smaller as
/// [`SCREEN`].
pub(crate) const SCREEN_NOISES: f64 = 4.2;

/// RMS row offset, and difference of the row offsets in use and proposed, from which on a matcher that searches along
/// rows misses. Larger arms a misaligned rig; smaller refuses a usable one.
pub(crate) const BAD_PX: f64 = 1.0;

/// Levels that row offsets are sorted into by size, each twice as far as the one before; the end of the first one, in
/// screened row offsets; and levels from that of the median on beyond which they are clipped, 4 to 8 medians. Larger
/// lets mismatches into the RMS; smaller hides few near points that are off.
pub(crate) const ROW_LEVELS: usize = 20;
pub(crate) const FIRST_ROW_LEVEL: f64 = 0.01;
pub(crate) const CLIPPED_LEVELS: u16 = 3;

/// Squared distance of what is in use from the estimate over the covariance, from which on it is worth a change: 1 % by
/// chance. Larger calls for changes later; smaller by noise.
pub(crate) const SIGNIFICANT_CHANGE: f64 = 15.1;

/// RMS row offset of the proposal over that in use, below which a change is worth it. Larger calls
/// for changes by noise; smaller misses real ones.
pub(crate) const IMPROVEMENT: f64 = 0.9;

#[cfg(feature = "paper")]
pub(crate) mod paper;
#[cfg(test)]
mod tests;
