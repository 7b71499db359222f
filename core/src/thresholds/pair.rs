//! Thresholds of the search, track and evaluation of one pair.

/// Tukey's limit in deviations: 95 % efficient. A larger limit admits outliers; a smaller one discards inliers.
pub(crate) const TUKEY: f64 = 4.685;

/// First scale of the annealed loss, in median residuals of a sample at the start, and the least one, px, which no noise
/// reaches. A larger scale takes more passes; a smaller one misses a rig that is further off.
pub(crate) const FIRST_SCALE_MEDIANS: f64 = 2.0;
pub(crate) const WIDE_SCALE_PX: f64 = 32.0;

/// Ratio of successive scales, and above [`WIDE_SCALE_PX`]. A larger ratio takes more passes; a smaller one loses the
/// basin of convergence.
pub(crate) const ANNEALING: f64 = 0.6;
pub(crate) const WIDE_ANNEALING: f64 = 0.35;

/// Levels that residuals are counted below, and the first level; each level is `sqrt 2` of the one before, and the last
/// one is 16 px. More levels cost time; fewer make the first estimate of the noise coarse.
pub(crate) const LEVELS: usize = 13;
pub(crate) const FIRST_LEVEL_PX: f64 = 0.25;

/// Part of the usable correspondences in a peak of residuals, while the scale falls, and their count over that beside
/// it; outliers alone show 1. Larger values overlook few inliers; smaller ones take chance for a peak.
pub(crate) const PEAK_SHARE: f64 = 0.25;
pub(crate) const PEAK_OVER_BESIDE: f64 = 2.0;

/// Excess of a peak over the count beside it, in deviations of chance, also at a pose found from afar or not confirmed,
/// of correspondences of high leverage, and of a gap between two crowds. A larger value overlooks few inliers; a smaller
/// one takes chance for a peak.
pub(crate) const PEAK_DEVIATIONS: f64 = 3.0;

/// Scale of the loss over the peak that it is aimed at. A larger scale ends between two crowds of matches; a smaller
/// one loses inliers.
pub(crate) const BELOW_PEAK: f64 = 0.7;

/// Scale over the peak at which Tukey takes over, for peaks up to [`NARROW_PX`] and for wider ones, which two crowds
/// form as well. Larger scales end between two crowds; smaller ones spend passes.
pub(crate) const POLISH_AT: [f64; 2] = [1.0, 0.3];
pub(crate) const NARROW_PX: f64 = 0.6;

/// Scale at which Tukey takes over without a peak, and least scale of a second start. A larger scale ends between two
/// crowds; a smaller one spends passes.
pub(crate) const LEAST_SCALE_PX: f64 = 0.7;

/// Peak over the noise of a polish, below which the noise falls back to the peak. A larger ratio follows chance; a
/// smaller one stays with a compromise of two crowds.
pub(crate) const PEAK_OVER_NOISE: f64 = 0.6;

/// Tukey's limit where a second crowd of matches stands beside the inliers: 65 % efficient. The crowd biases a larger
/// limit; a smaller one discards inliers.
pub(crate) const TIGHT_TUKEY: f64 = 2.5;

/// A crowd: residuals beyond the peak that lean to one side. Their largest size, in units of the loss; and their share
/// of the usable residuals, mean of the last pairs, above which the limit is tight. A crowd biases larger values;
/// smaller ones take chance for a crowd.
pub(crate) const CROWD: f64 = 10.0;
pub(crate) const CROWD_SHARE: f64 = 0.08;

/// Largest noise of a coordinate; outliers raise the estimate, and a found pose is below the limit. A larger limit takes
/// outliers for a consensus; a smaller one refuses poor matchers.
pub(crate) const MAX_NOISE_PX: f64 = 5.5;

/// Rise of the robust cost at a fixed scale, in variances, above which a step is taken back: the cost of one outlier.
/// The limit on leverage, which the cost does not include, causes smaller rises. A larger limit accepts worse poses; a
/// smaller one spends passes.
pub(crate) const MAX_RISE: f64 = 3.66;

/// Part of the usable correspondences within a peak, below which a second start is due, and the same in a small batch.
/// It is due at a peak wider than [`NARROW_PX`] as well. Larger parts spend passes; smaller ones stay with a fence.
pub(crate) const CERTAIN_SHARE: [f64; 2] = [0.6, 0.9];

/// Rounds of a second start; correspondences that poses are drawn from; groups of poses in a round of that many
/// correspondences; poses in a group; correspondences in a sample; and steps from the best pose of a group to the
/// optimum near it. Larger values cost time; smaller ones miss more.
pub(crate) const ROUNDS: u8 = 3;
pub(crate) const SAMPLED: usize = 64;
pub(crate) const GROUPS: usize = 3;
pub(crate) const GROUP: usize = 8;
pub(crate) const SAMPLE: usize = 3;
pub(crate) const IMPROVING_STEPS: usize = 3;

/// Scale of the score of a pose, over the noise. And score by which it is better than the pose before, correspondences.
/// Larger values overlook a second crowd; smaller ones follow chance.
pub(crate) const PROPOSAL_SCALE: f64 = 0.3;
pub(crate) const PROPOSAL_GAIN: f64 = 0.2;

/// Smallest unit of the loss, in steps of the grid: a narrower loss locks on the mode of rounded rows instead of their
/// mean. A larger unit dulls the loss; a smaller one biases by 9 to 26 times the bound.
pub(crate) const MIN_UNIT: f64 = 0.6;

/// Limit of a near residual, in units of the loss; near residuals give the noise. A larger limit lets outliers in; a
/// smaller one discards inliers.
pub(crate) const NEAR: f64 = 2.0;

/// Limit of an inlier, in units of the loss. A larger limit counts outliers; a smaller one discards inliers.
pub(crate) const INLIER: f64 = 3.0;

/// Disparity below zero that noise may give a match. A larger limit admits outliers behind infinity; a smaller one cuts
/// far inliers.
pub(crate) const MIN_DISPARITY_PX: f64 = 4.0;

/// Standard deviations of yaw that the smallest disparity allows for: yaw moves all disparities alike. A larger number
/// learns less from scenes of one depth; a smaller one takes an error of yaw for a scene.
pub(crate) const YAW_DEVIATIONS: f64 = 3.0;

/// Factor of the estimated noise of disparities that the information on the baseline loses: noise along the rows
/// differs a little from noise across them. A larger factor loses information in far scenes; a smaller one takes noise
/// for disparity.
pub(crate) const DISPARITY_NOISE_MARGIN: f64 = 1.1;

/// Largest information on the baseline of one correspondence, in mean shares of the pass before; beyond it the weight
/// falls with the square. A larger limit lets a near outlier rule `t`; a smaller one loses near inliers. Limits of 3 to
/// 10 are equal in scenes 30 to 800 baselines deep.
pub(crate) const MAX_LEVERAGE: f64 = 8.0;

/// The same limit before the first step of a track, in median shares of those within the loss, which outliers do not
/// move. A correspondence beyond it has high leverage. A larger limit lets a near outlier in; a smaller one loses near
/// inliers.
pub(crate) const FIRST_MAX_LEVERAGE: f64 = 46.0;

/// Share that separates a few near points before a far scene from the tail of one range of depths, in first limits. A
/// larger value loses the near points; a smaller one lets near outliers in.
pub(crate) const MIN_SEPARATION: f64 = 4.0;

/// Correspondences that a survey reads. A larger number costs time; a smaller one makes the survey noisy.
pub(crate) const SURVEYED: usize = 32;

/// Passes of a track: survey, two steps, evaluation. A larger number costs time; a smaller one takes no step.
pub(crate) const TRACK_PASSES: u16 = 4;

/// Correspondences that a step of a track reads; of a larger batch it reads half, because the pose only decides
/// weights. A larger number costs time; a smaller one loses accuracy (half a batch: a hundredth).
pub(crate) const TRACKED: usize = 128;

/// Squared step in standard deviations at which a search has converged: the optimum of the moments takes one more step.
/// A larger limit stops early; a smaller one spends passes.
pub(crate) const NEGLIGIBLE: f64 = 0.1;

/// Relative change of the noise at which it has settled. A larger limit stops early; a smaller one spends passes.
pub(crate) const SETTLED: f64 = 0.05;

/// Passes of evaluation and comparison beyond the configured limit; they bound `solve_pair`. A larger number raises the
/// bound; a smaller one cuts a pair short.
pub(crate) const SPARE_PASSES: u16 = 8;

/// Near residuals at a pose found from afar, as a part of the usable ones. Each px of noise adds to this part, up to a
/// limit, because many outliers lie within a wide peak. Larger values refuse pairs full of outliers; smaller ones accept a
/// local optimum.
pub(crate) const FOUND_NEAR: [f64; 2] = [0.15, 0.25];
pub(crate) const FOUND_NEAR_MOST: f64 = 0.6;

/// Requirements of a tracked pose, which is known already: near residuals over those beside, and their number. Larger
/// values refuse small and poor batches; smaller ones accept chance.
pub(crate) const TRACK_PEAK: f64 = 1.5;
pub(crate) const TRACK_MIN_NEAR: u32 = 8;

/// Variance of the disparities of a pair about a plane, over that of their noise, below which both sides show the same
/// image. Noise alone, of a scene at infinity, gives 1, and 0.1 with a matcher better than the noise floor. A larger
/// limit refuses planes under little noise; a smaller one takes one image for a scene.
pub(crate) const ALIKE_DISPARITIES: f64 = 0.01;

/// Points clearly behind the cameras over those clearly in front, among correspondences that fit, above which the
/// baseline is reversed or an image mirrored. Only a few mismatches of a scene lie behind. A larger limit takes a
/// mirrored image for a scene; a smaller one refuses scenes with repetitive textures.
pub(crate) const MAX_BEHIND: f64 = 0.5;

/// Least sum of the weights over the near residuals; a match without residual has weight 1. Below it most fitting
/// matches lie behind infinity or have high leverage. A larger limit refuses scenes of few near points; a smaller one
/// fuses pairs of a few matches.
pub(crate) const MIN_WEIGHTED: f64 = 0.05;

/// Least eigenvalue of the information with unit diagonal; below it a direction is free. A larger limit refuses weak
/// scenes; a smaller one accepts rounding as information.
pub(crate) const MIN_CONDITION: f64 = 1e-5;

/// Power iterations to an extreme eigenvalue. A larger number costs time; a smaller one loses digits.
pub(crate) const POWER_ITERATIONS: usize = 12;
