//! Thresholds of the search, track and evaluation of one pair.

/// Tukey's limit in deviations: 95 % efficient. A larger limit admits outliers; a smaller one discards inliers.
pub(crate) const TUKEY: f64 = 4.685;

/// First scale of the annealed loss, in medians of the residuals of a sample at the start, and least value of this
/// scale, px, which no noise reaches. A larger scale takes more passes; a smaller one misses a rig that is further off.
pub(crate) const FIRST_SCALE_MEDIANS: f64 = 2.0;
pub(crate) const WIDE_SCALE_PX: f64 = 32.0;

/// Ratio of successive scales, and the same ratio above [`WIDE_SCALE_PX`]. A larger ratio takes more passes; a smaller
/// one loses the basin of convergence.
pub(crate) const ANNEALING: f64 = 0.6;
pub(crate) const WIDE_ANNEALING: f64 = 0.35;

/// Number of levels below which residuals are counted, and the first level. Each level is `sqrt 2` times the previous
/// one, and the last one is 16 px. A larger number costs time; a smaller one makes the first estimate of the noise
/// coarse.
pub(crate) const LEVELS: usize = 13;
pub(crate) const FIRST_LEVEL_PX: f64 = 0.25;

/// Least part of the usable correspondences in a peak of residuals, while the scale falls, and least ratio of the count
/// in the peak to the count beside it; outliers alone have a ratio of 1. A pose found by a search needs this ratio too.
/// Larger values overlook a small number of inliers; smaller ones accept a chance cluster of residuals as a peak.
pub(crate) const PEAK_SHARE: f64 = 0.25;
pub(crate) const PEAK_OVER_BESIDE: f64 = 2.0;

/// Scale of the loss over the peak, to which annealing reduces the scale. A larger scale ends between two crowds of
/// matches; a smaller one loses inliers.
pub(crate) const BELOW_PEAK: f64 = 0.7;

/// Scale over the peak at which Tukey takes over, for peaks up to [`NARROW_PX`] and for wider peaks, which two crowds
/// may form, too. Larger scales end between two crowds; smaller ones spend passes.
pub(crate) const POLISH_AT: [f64; 2] = [1.0, 0.3];
pub(crate) const NARROW_PX: f64 = 0.6;

/// Scale at which Tukey takes over without a peak, and least scale of a second start. A larger scale ends between two
/// crowds; a smaller one spends passes.
pub(crate) const LEAST_SCALE_PX: f64 = 0.7;

/// Peak over the noise of a polish, below which the noise falls back to the peak. A larger ratio follows chance; a
/// smaller one stays with a compromise of two crowds.
pub(crate) const PEAK_OVER_NOISE: f64 = 0.6;

/// Tukey's limit where a second crowd of matches stands beside the inliers: 64 % efficient. A larger limit lets the
/// crowd bias the pose; a smaller one discards inliers.
pub(crate) const TIGHT_TUKEY: f64 = 2.5;

/// Limits of a crowd, which is an excess of residuals beyond the peak on one side: the largest size of its residuals,
/// in units of the loss; and its share of the usable residuals, as a mean over the last pairs, above which Tukey's
/// limit is tight. Larger values let a crowd bias the pose; smaller ones take chance for a crowd.
pub(crate) const CROWD: f64 = 10.0;
pub(crate) const CROWD_SHARE: f64 = 0.08;

/// Largest noise of a coordinate; outliers raise the estimated noise, and the noise of a found pose is below the limit.
/// A larger limit takes outliers for a consensus; a smaller one refuses poor matchers.
pub(crate) const MAX_NOISE_PX: f64 = 5.5;

/// Rise of the robust cost at a fixed scale, in variances, above which a step is taken back: the cost of one outlier.
/// The cost does not include the limit on leverage, so a valid step may raise it a little. A larger value accepts worse
/// poses; a smaller one spends passes.
pub(crate) const MAX_RISE: f64 = 3.66;

/// Part of the usable correspondences within a peak, below which a second start is due, and the same in a small batch.
/// A second start is also due at a peak wider than [`NARROW_PX`]. Larger parts spend passes; smaller ones keep a
/// wrong pose that fits a repeated structure, such as a fence.
pub(crate) const CERTAIN_SHARE: [f64; 2] = [0.6, 0.9];

/// Second start: `ROUNDS` rounds. Each reads at most `SAMPLED` correspondences and solves `GROUPS` groups of `GROUP`
/// poses, more groups if it reads fewer. A pose is solved from `SAMPLE` of them, and the best of a group is improved by
/// `IMPROVING_STEPS` steps. Larger values cost time; smaller ones miss the pose more often.
pub(crate) const ROUNDS: u8 = 3;
pub(crate) const SAMPLED: usize = 64;
pub(crate) const GROUPS: usize = 3;
pub(crate) const GROUP: usize = 8;
pub(crate) const SAMPLE: usize = 3;
pub(crate) const IMPROVING_STEPS: usize = 3;

/// Scale of the score of a pose, over the noise; and gain in score, in correspondences, by which a pose must be better
/// than the previous one. Larger values overlook a second crowd; smaller ones follow chance.
pub(crate) const PROPOSAL_SCALE: f64 = 0.3;
pub(crate) const PROPOSAL_GAIN: f64 = 0.2;

/// Smallest unit of the loss, in steps of the grid: a narrower loss locks on the mode of rounded rows instead of their
/// mean. A larger unit dulls the loss; a smaller one causes a bias of 9 to 26 times the bound.
pub(crate) const MIN_UNIT: f64 = 0.6;

/// Limit of a near residual, in units of the loss; near residuals give the noise. A larger limit lets outliers in; a
/// smaller one discards inliers.
pub(crate) const NEAR: f64 = 2.0;

/// Limit of an inlier, in units of the loss. A larger limit counts outliers; a smaller one discards inliers.
pub(crate) const INLIER: f64 = 3.0;

/// Largest magnitude of a negative disparity that noise may give a match. A larger limit admits outliers behind
/// infinity; a smaller one cuts far inliers.
pub(crate) const MIN_DISPARITY_PX: f64 = 4.0;

/// Factor of the estimated noise of disparities, which is subtracted from the information on the baseline: noise along
/// the rows differs a little from noise across them. A larger factor loses information in far scenes; a smaller one
/// takes noise for disparity.
pub(crate) const DISPARITY_NOISE_MARGIN: f64 = 1.1;

/// Largest information of one correspondence on the baseline, in mean shares of the previous pass; beyond it the weight
/// falls with the square. A larger limit lets a near outlier rule `t`; a smaller one loses near inliers. Limits of 3 to
/// 10 are equal in scenes 30 to 800 baselines deep.
pub(crate) const MAX_LEVERAGE: f64 = 8.0;

/// The same limit before the first step of a track, in median shares of the correspondences within the loss; outliers
/// do not move this median. A correspondence beyond it has high leverage. A larger limit lets a near outlier in; a
/// smaller one loses near inliers.
pub(crate) const FIRST_MAX_LEVERAGE: f64 = 46.0;

/// Share that separates a few near points before a far scene from the tail of one range of depths, in units of
/// [`FIRST_MAX_LEVERAGE`]. A larger value loses the near points; a smaller one lets near outliers in.
pub(crate) const MIN_SEPARATION: f64 = 4.0;

/// Number of correspondences that a survey reads. A larger number costs time; a smaller one makes the survey noisy.
pub(crate) const SURVEYED: usize = 32;

/// Number of passes of a track: survey, two steps, evaluation. A larger number costs time; a smaller one takes no step.
pub(crate) const TRACK_PASSES: u16 = 4;

/// Number of correspondences that a step of a track reads; from a larger batch it reads half, because the pose only
/// decides the weights. A larger number costs time; a smaller one loses accuracy (a hundredth with half a batch).
pub(crate) const TRACKED: usize = 128;

/// Squared length of a step, in standard deviations, below which a search has converged. The fusion computes the
/// optimum from the moments, which is one step further. A larger limit stops early; a smaller one spends passes.
pub(crate) const NEGLIGIBLE: f64 = 0.1;

/// Relative change of the noise at which it has settled. A larger limit stops early; a smaller one spends passes.
pub(crate) const SETTLED: f64 = 0.05;

/// Number of steps beyond the configured limit of passes, for evaluation, comparison, fusion and verdict; this number
/// bounds `solve_pair`. A larger number raises the bound; a smaller one cuts a pair short.
pub(crate) const SPARE_STEPS: u16 = 9;

/// Least part of near residuals among the usable ones at a pose that is found from afar: its base value, its increase
/// per px of noise, and its upper limit; a tracked pose needs half of it. The part increases because many outliers lie
/// within a wide peak. Larger values refuse pairs full of outliers; smaller ones accept a local optimum.
pub(crate) const FOUND_NEAR: [f64; 2] = [0.15, 0.25];
pub(crate) const FOUND_NEAR_MOST: f64 = 0.6;

/// Requirements of a tracked pose, which is known already: least ratio of the near residuals to the residuals beside
/// them, and least number of near residuals. Larger values refuse small and poor batches; smaller ones accept chance.
pub(crate) const TRACK_PEAK: f64 = 1.5;
pub(crate) const TRACK_MIN_NEAR: u32 = 8;

/// Variance of the disparities of a pair about a plane, over the variance of their noise, below which both sides show
/// the same image. Noise alone, of a scene at infinity, gives 1, and 0.1 with a matcher better than the noise floor. A
/// larger limit refuses planes under little noise; a smaller one takes one image for a scene.
pub(crate) const ALIKE_DISPARITIES: f64 = 0.01;

/// Ratio of the points clearly behind the cameras to the points clearly in front, among correspondences that fit, above
/// which the baseline is reversed or an image mirrored. Only a few mismatches of a scene lie behind. A larger limit
/// takes a mirrored image for a scene; a smaller one refuses scenes with repetitive textures.
pub(crate) const MAX_BEHIND: f64 = 0.5;

/// Least sum of the weights over the number of near residuals; a match without residual has weight 1. Below it most
/// fitting matches lie behind infinity or have high leverage. A larger limit refuses scenes of few near points; a
/// smaller one fuses pairs of a few matches.
pub(crate) const MIN_WEIGHTED: f64 = 0.05;

/// Least eigenvalue of the information with unit diagonal; below it a direction is free. A larger limit refuses weak
/// scenes; a smaller one accepts rounding as information.
pub(crate) const MIN_CONDITION: f64 = 1e-5;

/// Number of power iterations to an extreme eigenvalue. A larger number costs time; a smaller one loses digits.
pub(crate) const POWER_ITERATIONS: usize = 12;
