//! Thresholds of the estimator, in the order of the data flow: geometry, pair, fusion, outcome, paper. `ESTIMATOR.md`
//! derives the quantities that they limit.
//!
//! Each one states its unit, its reason, and the effect of a larger and of a smaller value. A suffix names the unit
//! (`_PX`, `_RAD`); a number without one is a count or dimensionless. Sizes of memory layouts and of wire formats are
//! not here. Values that a user sets are in [`crate::Config`].

mod pair;

pub(crate) use pair::*;

// Geometry.

/// Least depth of a rectified unit-depth ray (87 degrees off axis); a shallower ray is skipped. A larger limit skips
/// rays at the border; a smaller one lets the `1 / z` of the row offset grow.
pub(crate) const MIN_DEPTH: f64 = 0.05;

/// Least component of the unit baseline across each optical axis (sine of 6 degrees). A larger limit refuses rigs that
/// can be rectified; a smaller one accepts rigs near the pole of the gauge.
pub(crate) const MIN_LATERAL: f64 = 0.1;

/// Largest turn of one view in one step. A larger limit uses a linearisation beyond its range; a smaller one refuses
/// steps from a distant start.
pub(crate) const MAX_STEP_RAD: f64 = 1.5;

/// Tangent of 85 degrees: a ray further off axis has no useful unit-depth form. A larger limit loses digits in `f32`; a
/// smaller one cuts off the border of a fisheye image.
pub(crate) const MAX_TANGENT: f64 = 11.43;

/// Largest squared Frobenius norm of `M^T M - I` at which `M` counts as a rotation. A larger norm accepts other
/// matrices; a smaller one refuses rounded files.
pub(crate) const MAX_ROTATION_DEFECT: f64 = 0.04;

/// Number of Newton-Schulz steps to the nearest rotation. Four steps reduce the norm of `M^T M - I` from 0.2 to 1e-13;
/// two are spare.
pub(crate) const NEWTON_SCHULZ_STEPS: usize = 6;

/// Largest number of Newton steps of an undistortion; 3 to 5 are usual. A bracketed fisheye takes up to four times this
/// number, a rational lens up to three times. A larger limit raises the worst-case time; a smaller one refuses pixels
/// near the fold.
pub(crate) const MAX_NEWTON_STEPS: usize = 12;

/// Newton step that ends an undistortion: in units in the last place of one plus the size of the point, and for a
/// fisheye in units in the last place of the angle. A larger tolerance loses digits; a smaller one may never be
/// reached.
pub(crate) const NEWTON_ULPS: f64 = 4.0;
pub(crate) const FISHEYE_NEWTON_ULPS: f64 = 2.0;

/// Least denominator of a rational lens. A larger limit cuts the image of a nearly singular lens; a smaller one lets
/// the quotient lose its digits.
pub(crate) const MIN_LENS_DENOMINATOR: f64 = 0.01;

/// Largest residual of an undistorted and redistorted point of a rational lens, in units in the last place of one plus
/// the sizes of both points. A larger limit accepts points that miss their pixel; a smaller one refuses good points.
pub(crate) const RATIONAL_RESIDUAL_ULPS: f64 = 256.0;

/// Start of Newton's method for a distorted point beyond the fold, as a part of the fold's radius. A larger part starts
/// where the Jacobian is nearly singular; a smaller one takes more steps.
pub(crate) const NEWTON_START: f64 = 0.9;

/// Largest magnitude of a distortion coefficient. A larger limit accepts files that hold no lens; a smaller one refuses
/// lenses.
pub(crate) const MAX_DISTORTION: f64 = 1e3;

/// Largest magnitude of a coefficient of a rational lens: those of numerator and denominator cancel, and calibrations
/// with some thousands are ordinary inside the image.
pub(crate) const MAX_RATIONAL: f64 = 1e5;

/// Samples of a lens model up to its limit, and bisections of the interval that holds the fold. Larger numbers cost
/// time when a camera is set; a smaller number of samples misses a narrow fold, and a smaller number of bisections
/// loses digits.
pub(crate) const FOLD_SAMPLES: u32 = 256;
pub(crate) const FOLD_BISECTIONS: usize = 30;

// Pair: in a file of its own.

// Fusion.

/// Largest normalised innovation squared (NIS) of a pair, and largest normalised score squared of a window, over the
/// reduced chi-square. The probability that chance exceeds it is at most 4e-5. A larger limit detects steps and drift
/// later; a smaller one rejects good pairs and renews the estimate by chance.
pub(crate) const MAX_NIS: f64 = 28.0;

/// Factor of [`MAX_NIS`] for a challenger while there is no confirmed estimate; such a challenger may be a few
/// deviations off. A larger factor locks on chance; a smaller one locks later.
pub(crate) const YOUNG_SLACK: f64 = 2.0;

/// Motion of a rig from pair to pair that counts as rest (0.005 degrees), for each unknown. A larger value hides small
/// steps; a smaller one rejects pairs of a vibrating rig.
pub(crate) const VIBRATION_RAD: f64 = 8.7e-5;

/// Number of samples that a test for vibration needs; deviations by which their median must exceed chance; and factor
/// of this limit, and of the variance at rest, once vibration is known. Larger limits detect vibration later; smaller
/// ones detect it by chance.
pub(crate) const MIN_VIBRATION_SAMPLES: usize = 4;
pub(crate) const VIBRATION_DEVIATIONS: f64 = 6.0;
pub(crate) const VIBRATION_HYSTERESIS: f64 = 0.25;

/// Ratio of the median to the mean of the samples beyond which the mean is stale; the ratio of the mean to the median
/// may be up to its square. A larger ratio notices a vibration later; a smaller one makes the variance noisier.
pub(crate) const VIBRATION_RATIO: f64 = 4.0;

/// Largest vibration (0.4 degrees). A larger limit takes knocks for vibration; a smaller one loses a shaken rig.
pub(crate) const MAX_VIBRATION_RAD: f64 = 7e-3;

/// Limits within which turning cameras explain a scatter: least vibration of `R` (0.03 degrees), and largest ratio of
/// the deviations of baseline and `R`. A larger vibration or a smaller ratio leaves vibration in the lens; a smaller
/// vibration or a larger ratio hides a wrong lens.
pub(crate) const TURN_RAD: f64 = 5.2e-4;
pub(crate) const MAX_TURN_RATIO: f64 = 4.0;

/// Prior deviation of a pair about the estimate that it is tracked from (0.05 degrees), for each unknown. A larger
/// value weakens the covariance gating of outliers; a smaller one resists a small step.
pub(crate) const FREEDOM_RAD: f64 = 8.7e-4;

/// Largest reduced chi-square that a pair contributes; real lenses leave 3 to 10. A larger limit lets a false pair
/// widen the gate; a smaller one reports too small a deviation.
pub(crate) const MAX_REDUCED_CHI_SQUARE: f64 = 16.0;

/// Number of pairs of reduced chi-square 1 with which the mean of the reduced chi-square starts; and number of pairs in
/// the running means of chi-square and noise. Larger numbers follow a changing scene later; smaller ones make the means
/// noisier.
pub(crate) const CHI_SQUARE_PAIRS: f64 = 4.0;
pub(crate) const AVERAGED_PAIRS: u32 = 50;

/// Reported standard deviation of `R` above which no estimate locks. A larger limit locks on weak pairs; a smaller one
/// waits in poor scenes.
pub(crate) const MAX_LOCKED_SD_RAD: f64 = 0.12;

/// Variance of `t` over the variance of one of its two angles in the factory extrinsics (2 without pairs). The baseline
/// is observed up to the first limit, and is applied in any case up to the second limit. Larger limits apply a baseline
/// that is mostly the prior; smaller ones wait in far scenes.
pub(crate) const OBSERVED_BASELINE: f64 = 0.25;
pub(crate) const CERTAIN_BASELINE: f64 = 0.0625;

/// Least pivot of the information on the lens, scaled to unit diagonal. A larger limit holds directions fixed that
/// pairs determine; a smaller one divides by rounding.
pub(crate) const MIN_LENS_PIVOT: f64 = 1e-7;

/// Smallest share of the information on a lens parameter that counts if the extrinsics are free, in roundings of a
/// number. In `f32`, pairs leave a share of 1e-4 or more, and the rounding errors of a restored estimate a share of
/// 2e-6. A larger share forgets the lens in scenes that hardly show it; a smaller one takes rounding for a lens.
pub(crate) const LENS_ROUNDING: f64 = 64.0;

/// Largest error of a lens in deviations of its prior. A larger limit reports the result of damaged sums; a smaller one
/// refuses lenses that are far from their calibration.
pub(crate) const MAX_LENS_VALUE: f64 = 1e3;

/// Part of an error of the lens that frozen weights may hide, `1 - E[psi'] / E[w]`; it counts as an additional standard
/// deviation. A larger part names the error later; a smaller one reports too small a deviation.
pub(crate) const LENS_SHRINKAGE: f64 = 0.17;

/// Largest correction of a lens, relative focal length and `k1`. A larger limit follows biases further; a smaller one
/// leaves wrong lenses as they are.
pub(crate) const MAX_LENS_CORRECTION: f64 = 0.1;

/// Ratio of the deviations of `t` without and with compensation, above which the lens is compensated. A larger ratio
/// leaves errors in `t`; a smaller one takes biases of matches for a lens.
pub(crate) const COMPENSATION_GAIN: f64 = 2.0;

/// Effect of a further correction that the weights may hide, as a part of the deviation of `t`. A larger part restarts
/// the sums less often; a smaller one restarts them by chance.
pub(crate) const MAX_HIDDEN_LENS: f64 = 0.1;

/// Factor of the variances of the lens that are kept when sums are dropped. Covariances are not kept, and doubled
/// variances bound any covariance. A larger factor makes the estimator learn the lens again; a smaller one trusts an
/// estimate that was made with the weights of a wrong lens.
pub(crate) const KNOWN_LENS_WIDENING: f64 = 2.0;

/// Number of pairs before the first change of the lens reference, and of a challenger that differs in the lens alone;
/// number of changes up to which each change doubles the number of pairs. Larger numbers change the reference later;
/// smaller ones change it by the error of a few pairs.
pub(crate) const MIN_REFERENCE_PAIRS: u32 = 8;
pub(crate) const MAX_REFERENCE_CHANGES: u32 = 4;

/// Standard deviation of the yaw of the rows from scene to scene (0.034 degrees): other depths and regions weigh the
/// same lens differently. It exceeds the scatter of single pairs, 0.02 to 0.03 degrees, because neighbours are alike. A
/// rig with a larger scatter learns it. A larger value takes small knocks in yaw for scatter; a smaller one takes scatter
/// for knocks.
pub(crate) const SCENE_YAW_RAD: f64 = 6e-4;

/// Scatter of the yaw that a rig learns: number of pairs as which [`SCENE_YAW_RAD`] counts before the first one, and
/// number of pairs in the running mean. Larger numbers learn another scatter later; smaller ones take chance for it.
pub(crate) const SCATTER_PAIRS: [f64; 2] = [2.0, 32.0];

/// Standard deviations of the turn of a mount about y from pair to pair, one for each decade: at rest, where it follows
/// the temperature; while it warms up; while it yields; at a knock. Larger values follow the scatter of the scenes;
/// smaller ones follow drift and knocks late.
pub(crate) const MOUNT_WALKS_RAD: [f64; 4] = [1e-5, 1e-4, 1e-3, 1e-2];

/// Probability per pair that a mount begins to walk in another way. A larger value follows the scatter of the scenes; a
/// smaller one notices drift and knocks late.
pub(crate) const MOUNT_CHANGES: f64 = 0.02;

/// Until a witness measures the yaw of the mount, `1 + TURNED_DOUBT` times the squared apparent yaw of the lens is
/// added to the variances of both yaws, because this yaw may be a turn of the mount. A larger value reports too large a
/// deviation; a smaller one trusts the lens.
pub(crate) const TURNED_DOUBT: f64 = 0.5;

/// Least and largest distance of a range reading, m. Readings outside are faults of a sensor.
pub(crate) const MIN_RANGE_M: f64 = 0.01;
pub(crate) const MAX_RANGE_M: f64 = 1e5;

/// Largest distance of a match from the pixel of a range reading, px. A larger reach reads other surfaces; a smaller
/// one finds no match.
pub(crate) const RANGE_REACH_PX: f64 = 3.0;

/// Relative standard deviation of the length of the baseline. A larger value gives less weight to near readings; a
/// smaller one takes an error of the length for yaw.
pub(crate) const BASELINE_LENGTH_SD: f64 = 0.005;

/// Motion of the rig from tracked matches: largest number of matches read; largest number of steps; first scale of the
/// loss in deviations, which halves at each step down to 1; squared length of the last step in deviations; largest
/// squared residual of an inlier (three degrees of freedom, 99 %); least share of inliers. Larger numbers of matches and
/// steps, and a shorter last step, cost time. Larger scales and gates let outliers in; smaller ones lose a large or
/// noisy motion. A larger share refuses more motions.
pub(crate) const MAX_TRACKED: usize = 256;
pub(crate) const MOTION_STEPS: usize = 16;
pub(crate) const MOTION_SCALE: f64 = 64.0;
pub(crate) const MOTION_SETTLED: f64 = 1e-4;
pub(crate) const MOTION_GATE: f64 = 11.3;
pub(crate) const MOTION_INLIERS: f64 = 0.6;

/// Prior deviation of the turn that motion shows (1.1 degrees), and largest disparity behind infinity of a tracked
/// match, in units of the noise of a coordinate. Larger values let poor starts diverge; smaller ones pull the turn to
/// the rows, and cut far points.
pub(crate) const MOTION_TURN_RAD: f64 = 0.02;
pub(crate) const BEHIND_INFINITY: f64 = 10.0;

/// Noise of a coordinate of a tracked match over the noise across rows. A larger factor lets outliers in and gives
/// motion less weight; a smaller one finds no motion where tracks are poorer than matches.
pub(crate) const TRACK_NOISE: f64 = 2.0;

/// Largest number of witness measurements that count as support of a yaw. The yaw is replaced once the consecutive
/// contradicting measurements that agree with each other outnumber its support, and are at least two. A larger number
/// delays the response to a turn that the rows do not show; a smaller one lets wrong readings replace right ones.
pub(crate) const WITNESS_SUPPORT: u8 = 3;

/// Least deviation of all witnesses together (0.015 degrees): they share the length of the baseline and the focal
/// length. A larger value gives them less weight; a smaller one trusts them beyond this common error.
pub(crate) const WITNESS_RAD: f64 = 2.6e-4;

/// Deviation of the apparent yaw of the lens above which the yaw is not confirmed, and of a turn by motion above which
/// it is not a measurement (0.1 degrees). A larger limit names an error later; a smaller one names the error that a
/// factory calibration leaves.
pub(crate) const MAX_CONFIRMED_YAW_RAD: f64 = 1.75e-3;

/// Standard deviation of the yaw of a factory calibration with boards (0.05 degrees), rad. A larger value follows the
/// rows; a smaller one trusts the calibration further than it was measured.
pub(crate) const CALIBRATED_YAW_SD_RAD: f32 = 8.7e-4;

/// Standard deviations above which a difference is not chance: of an error of the lens from 0, of a baseline in use
/// from an observed one, of the yaw of the mount from that of its calibration or of a witness, of the number of
/// residuals in a peak from the number beside it. It is also the error of yaw that the smallest disparity and the test
/// for depth of the published method allow for. A larger value overlooks errors, and small numbers of inliers, for
/// longer; a smaller one takes noise for errors, and chance for a peak.
pub(crate) const SIGNIFICANT: f64 = 3.0;

/// Largest correction in use over the limit of the estimated correction; a baseline that is kept adds to the
/// correction. A larger factor applies a rig that no estimate supports; a smaller one refuses a fit of `R` near the
/// limit.
pub(crate) const MAX_IN_USE: f64 = 1.5;

/// Number of steps to the optimum of all sums, each of which squares the error of the linearisation; and squared step
/// after which the next step is below rounding. Larger values cost time; smaller ones leave an error.
pub(crate) const OPTIMUM_STEPS: usize = 3;
pub(crate) const LAST_STEP_SQUARED: f64 = 1e-8;

/// The last step, of length `d`, adds about `d^2` of the largest information to the direction with the least.
/// This is the largest such addition, as a part of the least information. A larger part keeps information that belongs
/// to another pose; a smaller one costs time in far scenes.
pub(crate) const MOVED_INFORMATION: f64 = 0.1;

/// Pairs that a challenger needs to take over. A larger number follows a step later; a smaller one follows chance.
pub(crate) const MIN_AGREED: u16 = 3;

/// Least number of contradicting pairs after which a challenger is dropped; one with many agreeing pairs tolerates
/// more. A larger number keeps a false challenger longer; a smaller one drops a true challenger because of one poor
/// pair.
pub(crate) const MAX_FAILED: u16 = 2;

/// Rejected pairs in a row after which the rig is lost, and every second search starts at the factory extrinsics. A
/// larger number reports the loss later; a smaller one reports bad matches as a loss.
pub(crate) const LOST_AFTER: u16 = 10;

/// Row offset at which the truncated cost reaches 1. A larger value lets outliers in; a smaller one compares poses by
/// noise.
pub(crate) const TRUNCATED_PX: f64 = 2.0;

/// Mean truncated cost (0 to 1) by which a new pose must be better than the challenger's. A larger margin keeps a false
/// challenger; a smaller one replaces the pose by chance.
pub(crate) const CLEARLY_BETTER: f64 = 0.04;

/// Mean truncated cost (0 to 1) of a challenger above which poses with a turned baseline are tried; it is about the
/// share of outliers. A larger limit locks on a wrong baseline that fits some of the matches; a smaller one costs time.
pub(crate) const OPEN_COST: f64 = 0.4;

/// Decay factor per pair of the window of the change detection (about 10 pairs) and of a followed drift in the
/// covariance, and number of the pairs in the window. The window counts as this number of pairs when it replaces older
/// pairs, and the shares of inliers and of a crowd are means over this number. A larger factor or number detects small
/// changes later; a smaller one forgets them, and lets a drift exceed the reported deviation.
pub(crate) const WINDOW_DECAY: f64 = 0.9;
pub(crate) const WINDOW_PAIRS: u32 = 10;

/// Number of pairs before a change is detected: the least number that replaces older pairs. A larger number detects
/// later; a smaller one leaves a weak estimate.
pub(crate) const WARM_UP_PAIRS: u32 = 4;

/// Disagreement of image halves up to which the covariance stays; the probability that chance exceeds it is 1e-3 per
/// axis. A larger limit reports too small a deviation for biased matches; a smaller one increases the deviation of
/// healthy matches.
pub(crate) const HEALTHY_DISAGREEMENT: f64 = 2.0;

/// Error of the first-order models of the image halves after a step, in deviations of the estimate, above which these
/// models restart. A larger error compares wrong models; a smaller one forgets often.
pub(crate) const MAX_MODEL_ERROR: f64 = 0.1;

/// Upper bound of a disagreement of image halves; its square stays finite. A larger bound overflows in `f32`; a smaller
/// one makes more disagreements equal.
pub(crate) const MAX_TOLD_DISAGREEMENT: f64 = 1e4;

/// Largest number of correspondences in one of the 48 cells of the image. A larger number raises the worst-case time of a
/// push; a smaller one loses matches of a scene in a few cells.
pub(crate) const MAX_IN_CELL: u16 = 128;

/// Number of correspondences of a pair that are remembered, one for each bit of a word; and number of coordinate steps
/// per pixel. Larger numbers cost memory; smaller ones make the share noisy.
pub(crate) const REMEMBERED: usize = 32;
pub(crate) const REMEMBERED_STEPS_PER_PX: f64 = 4.0;

/// Largest motion of a scene at rest, in steps (6 steps are 1.5 px). A larger limit adds fewer pairs of a slow motion; a
/// smaller one misses rest under noise.
pub(crate) const SAME_STEPS: u16 = 6;

/// Motion of the scene, in steps (32 steps are 8 px), from which a pair counts fully; one that has moved less counts by
/// the share. A larger distance reports too large deviations of errors that are new in each pair; a smaller one too
/// small deviations of errors that stay with the scene.
pub(crate) const KEY_STEPS: u16 = 32;

/// Motion of the scene, in steps (64 steps are 16 px), from which successive pairs count as independent in change
/// detection. It is longer than `KEY_STEPS`, because a false change drops all pairs. A larger distance detects small
/// steps of the rig later while the scene creeps; a smaller one takes errors that stay with the scene for changes.
pub(crate) const FAR_STEPS: u16 = 64;

/// Share of the remembered correspondences that must be found again within a distance for the scene to have moved no
/// further: 0.6 to 0.8 are found again at rest, and up to 0.13 by chance. A larger share takes rest for motion; a
/// smaller one takes a new scene for an old one.
pub(crate) const SAME_SHARE: f64 = 0.3;

/// Share of remembered correspondences seen again within a step, above which the pair is a copy of the last pair. A
/// larger share takes a copy for a measurement; a smaller one takes a scene at rest under little noise for a copy.
pub(crate) const COPIED_SHARE: f64 = 0.9;

// Outcome.

/// A cause is named once more than one in this number of pairs without agreement shows it; each turned baseline is
/// tried with every sixth pair. A larger number names causes by chance; a smaller one misses causes.
pub(crate) const CAUSE_SHARE: u32 = 8;

/// Error of a lens in deviations of its prior beyond any calibration: the matches belong to another lens. A larger
/// limit arms with a wrong lens; a smaller one disarms with a poorly calibrated one.
pub(crate) const GROSS_LENS: f64 = 4.0;

/// Test for depth among matches with a common motion: decay factor per pair of the sums. The sum of the scores must
/// exceed the second value in deviations of chance, and the third value as a share of the matches. A restart keeps the
/// fourth number of matches. Larger limits disarm a far scene for longer; smaller ones arm with one image on both
/// sides, by chance or by mismatches along rows.
pub(crate) const RELIEF_DECAY: f64 = 0.98;
pub(crate) const RELIEF_SHOWN: f64 = 5.0;
pub(crate) const RELIEF_SHARE: f64 = 0.05;
pub(crate) const RELIEF_KEPT: f64 = 200.0;

/// Largest difference of the motions of two matches, from the left to the right image, at which they have a common
/// motion, px. A larger limit takes a far scene for one image; a smaller one misses one image under noise.
pub(crate) const ALIKE_PX: f64 = 2.0;

/// Share of the matches with equal rows from which on the rows were not measured, and above which they lie on a grid.
/// Whole pixels tie in 9 of 10 matches at most. A larger first share fuses copied rows; a smaller one refuses whole
/// pixels. A larger second share misses a grid; a smaller one takes a fine grid, which is harmless, for a coarse one.
pub(crate) const MOST_TIED: f64 = 0.95;
pub(crate) const MIN_TIED: f64 = 0.3;

/// Largest difference of rows after rectification that is a tie, px. A larger limit takes precise rows for copies; a
/// smaller one misses copies whose pixels were rounded.
pub(crate) const TIE_PX: f64 = 1.0 / 64.0;

/// Largest difference of rows that shows the step of a grid, px. A larger limit takes mismatches for steps; a smaller
/// one underestimates the steps of a coarse pyramid.
pub(crate) const MAX_ROW_STEP_PX: f64 = 8.0;

/// Least step that the matcher may state without a test of its rows, px. A larger limit widens matches that are whole
/// by chance; a smaller one believes a matcher that states the resolution of its numbers.
pub(crate) const COARSE_STEP_PX: f64 = 0.25;

/// Disagreement of image halves above which it is a reason for doubt, and above which the estimate counts as biased if
/// the lens models are exact. Larger limits apply biased estimates; smaller ones refuse healthy estimates (below 2.3).
pub(crate) const MAX_DISAGREEMENT: [f64; 2] = [3.0, 5.0];

/// Share of a second crowd over the share of the inliers, each a mean over the last pairs, above which either crowd may
/// be the scene. A larger limit may apply the pose of a fence; a smaller one waits where the scene is clear.
pub(crate) const MAX_SECOND_CROWD: f64 = 0.8;

/// Multiple of the row offset at which a rig may arm, and of the Huber threshold of the published method, up to which a
/// row offset enters the RMS. A larger multiple lets outliers in; a smaller one hides a bad calibration.
pub(crate) const SCREEN: f64 = 3.0;

/// Multiple of the noise of a coordinate up to which a row offset enters the RMS, if that is more than the limit of a
/// fit: three deviations of a row offset.
pub(crate) const SCREEN_NOISES: f64 = 4.2;

/// Number of matches of a pair that a verdict reads. A larger number costs time; a smaller one makes the coverage noisy.
pub(crate) const JUDGED: usize = 128;

/// Pairs in a row that must fit the calibration in use before a rig arms, and that must miss it before a rig disarms.
/// Larger numbers arm and disarm later; with 1, a single wrong pair decides.
pub(crate) const GOOD_IN_A_ROW: u8 = 2;
pub(crate) const BAD_IN_A_ROW: u8 = 2;

/// Number of pairs in a row without a solution after which a rig disarms. A larger number arms on old evidence; a smaller
/// one disarms above water or fog.
pub(crate) const MAX_UNSOLVED: u8 = 10;

/// Least share of the cells of the image with a match that fits. A larger limit disarms with few matches; a smaller one
/// arms with matches in one corner.
pub(crate) const MIN_IMAGE_COVERAGE: f64 = 0.15;

/// RMS difference of the row offsets in use and proposed above which an estimate is clearly better, px. A larger limit
/// asks for changes later; a smaller one asks for changes that no matcher notices.
pub(crate) const BAD_PX: f64 = 1.0;

/// Number of levels of size into which row offsets are sorted, each ending at twice the end of the previous one; end of
/// the first level, as a part of the screening threshold; and number of levels, from the level of the median on, after
/// which row offsets are clipped (4 to 8 medians). Larger values let mismatches into the RMS; smaller ones hide a few
/// near points that are off.
pub(crate) const ROW_LEVELS: usize = 20;
pub(crate) const FIRST_ROW_LEVEL: f64 = 0.01;
pub(crate) const CLIPPED_LEVELS: u16 = 3;

/// Squared Mahalanobis distance of the calibration in use from the estimate, above which a change is worthwhile. Chance
/// exceeds it in 1 % of the cases. A larger limit asks for changes later; a smaller one asks for changes because of
/// noise.
pub(crate) const SIGNIFICANT_CHANGE: f64 = 15.1;

/// RMS row offset of the proposal over that in use, below which a change is worthwhile. A larger ratio asks for changes
/// because of noise; a smaller one misses real changes.
pub(crate) const IMPROVEMENT: f64 = 0.9;

pub(crate) mod paper;
#[cfg(test)]
mod tests;
