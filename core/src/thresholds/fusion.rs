//! Thresholds of hypotheses, vibration, change detection and key frames.

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

/// Smallest variance of a vibration that is inverted, rad^2. A larger value overstates the vibration of a rig at rest; a
/// smaller one overflows in `f32`.
pub(crate) const MIN_BLOCK_VARIANCE: f64 = 1e-12;

/// Multiple of the sum of median and standard deviation at which a sample of the vibration is clipped. A larger multiple
/// takes a knock for vibration; a smaller one underestimates vibration with long tails.
pub(crate) const VIBRATION_CLIP: f64 = 6.0;

/// Largest squared Mahalanobis distance of a pose from the optimum of its sums. A first pair that hardly determines a
/// direction reaches 400. A larger limit accepts damaged records; a smaller one refuses far pairs.
pub(crate) const MAX_INCONSISTENCY: f64 = 1e4;

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

/// Pairs that a challenger needs to take over, and scenes that an estimate needs to replace the baseline of a calibrated
/// rig. A larger number follows a step later; a smaller one follows chance, or the bias of one scene.
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
