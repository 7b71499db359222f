//! Thresholds of the search, track and evaluation of one pair.

/// Tukey's limit in deviations: 95 % efficient. Larger admits outliers; smaller discards inliers.
pub(crate) const TUKEY: f64 = 4.685;

/// First scale of the annealed loss, in median residuals of a sample at the start, and its range. Larger takes more
/// passes; smaller misses a rig that is further off.
pub(crate) const FIRST_SCALE_MEDIANS: f64 = 2.0;
pub(crate) const FIRST_SCALE_PX: [f64; 2] = [15.0, 480.0];

/// Each scale over the one before; of scales above [`WIDE_SCALE_PX`], which no noise reaches, faster. Larger takes more
/// passes; smaller loses the basin of convergence.
pub(crate) const ANNEALING: f64 = 0.5;
pub(crate) const WIDE_ANNEALING: f64 = 0.35;
pub(crate) const WIDE_SCALE_PX: f64 = 30.0;

/// Levels that residuals are counted below, and the first one; each is `sqrt 2` of the one before, the last one 16 px.
/// More cost time; fewer make the noise to begin with coarse.
pub(crate) const LEVELS: usize = 13;
pub(crate) const FIRST_LEVEL_PX: f64 = 0.25;

/// A peak of residuals: its part of the usable ones while the scale falls, its count over that beside it (outliers alone
/// show 1), also at a pose found from afar, and its excess in deviations of chance, also of correspondences of high
/// leverage. Larger overlooks few inliers; smaller takes chance for a peak.
pub(crate) const PEAK_SHARE: f64 = 0.25;
pub(crate) const PEAK_OVER_BESIDE: f64 = 2.0;
pub(crate) const PEAK_DEVIATIONS: f64 = 3.0;

/// Scale of the loss over the peak that it is aimed at. Larger ends between two crowds of matches; smaller loses
/// inliers.
pub(crate) const BELOW_PEAK: f64 = 0.7;

/// Scale over the peak at which Tukey takes over, of peaks up to [`NARROW_PX`] and of wider ones, which two crowds
/// form as well; scale at which it takes over without a peak. Larger ends between two crowds; smaller spends passes.
pub(crate) const POLISH_AT: [f64; 2] = [1.0, 0.3];
pub(crate) const NARROW_PX: f64 = 0.6;
pub(crate) const LEAST_SCALE_PX: f64 = 1.0;

/// Peak over the noise of a polish, below which the noise falls back to the peak. Larger follows chance; smaller stays
/// with a compromise of two crowds.
pub(crate) const PEAK_OVER_NOISE: f64 = 0.6;

/// Noise of a coordinate before the first estimate. It weighs nothing until then.
pub(crate) const FIRST_NOISE_PX: f64 = 1.5;

/// Tukey's limit where a second crowd of matches stands beside the inliers: 65 % efficient. Larger is biased by it;
/// smaller discards inliers.
pub(crate) const TIGHT_TUKEY: f64 = 2.5;

/// Residuals beyond the peak that lean to one side are those of a crowd, up to so many units of the loss; from which
/// share of the usable ones on, mean of the last pairs, the limit is tight. Larger is biased by a crowd; smaller
/// takes chance for one.
pub(crate) const CROWD: f64 = 10.0;
pub(crate) const CROWD_SHARE: f64 = 0.08;

/// Largest noise of a coordinate, and of a found pose: among outliers the estimate grows. Larger takes outliers for a
/// consensus; smaller refuses poor matchers.
pub(crate) const MAX_NOISE_PX: f64 = 8.0;
pub(crate) const FOUND_NOISE_PX: f64 = 5.5;

/// Rise of the robust cost at a fixed scale, in variances, from which on a step is taken back: what one outlier
/// costs. The limit on leverage, which the cost does not know, causes smaller ones. Larger accepts worse poses;
/// smaller spends passes.
pub(crate) const MAX_RISE: f64 = 3.66;

/// Levenberg-Marquardt: damping after a first rejection, relative to the diagonal, its factors after a further one
/// and after an acceptance, and its range: below it is none, beyond it there is no descent. Larger takes more passes;
/// smaller is rejected again.
pub(crate) const FIRST_DAMPING: f64 = 0.3;
pub(crate) const DAMPING_FACTORS: [f64; 2] = [4.0, 0.125];
pub(crate) const DAMPING_RANGE: [f64; 2] = [0.02, 1000.0];

/// An annealing that ends at a peak of fewer correspondences, as a part of the usable ones, or at a wider one, px,
/// starts again where a pose through a small sample is better: at this scale, px. Narrower peaks, but above
/// [`NARROW_PX`], may hold two near crowds. Larger spends passes; smaller stays with a fence.
pub(crate) const SECOND_BELOW: f64 = 0.6;
pub(crate) const BROAD_PX: f64 = 2.1;
pub(crate) const SECOND_SCALE_PX: f64 = 4.0;

/// Poses through small samples: correspondences that they are drawn from, number of poses, correspondences in each, and
/// the prior of what they leave free. Larger costs time; smaller misses more.
pub(crate) const RESAMPLED: usize = 64;
pub(crate) const RESAMPLES: usize = 64;
pub(crate) const SAMPLE: usize = 3;
pub(crate) const RESAMPLE_SD_RAD: f64 = 0.03;

/// Scale of the score of such a pose: least, px, and over the noise; and the score over that of the pose before by
/// which it is better: a factor and correspondences. Larger overlooks a second crowd; smaller follows chance.
pub(crate) const RESAMPLE_SCALE: [f64; 2] = [1.0, 0.3];
pub(crate) const RESAMPLE_GAIN: f64 = 1.1;
pub(crate) const RESAMPLE_SCORE: f64 = 0.5;

/// Second start of a batch of at most [`RESAMPLED`]: one round is due below this part even at a narrow
/// peak; rounds else, groups of poses in a round of that many correspondences, poses in a group, and steps from the
/// best pose of each group to the optimum near it. Larger costs time; smaller misses more.
pub(crate) const SMALL_SECOND_BELOW: f64 = 0.9;
pub(crate) const ROUNDS: u8 = 4;
pub(crate) const GROUPS: usize = 3;
pub(crate) const GROUP: usize = 8;
pub(crate) const IMPROVING_STEPS: usize = 3;

/// Score of such an optimum over that of the pose before by which it is better, correspondences. Larger stays with a
/// compromise; smaller follows chance.
pub(crate) const ROUND_SCORE: f64 = 0.2;

/// Two near crowds: correspondences that are asked for the larger one, the scale of its score over the peak that holds
/// both, which the annealing goes on with, and the least, px. More cost time; a larger scale does not tell the crowds
/// apart, and a smaller one follows chance.
pub(crate) const CROWD_SAMPLE: usize = 128;
pub(crate) const CROWD_SCALE: f64 = 0.4;
pub(crate) const CROWD_SCALE_PX: f64 = 0.3;

/// Smallest unit of the loss, in steps of the grid: a narrower one locks on the mode of rounded
/// rows, not on their mean. Larger dulls the loss; smaller biases by 9 to 26 times the bound.
pub(crate) const MIN_UNIT: f64 = 0.6;

/// Residuals that count as near, in units of the loss: they give the noise. Larger lets outliers in; smaller leaves few.
pub(crate) const NEAR: f64 = 2.0;

/// Residuals that count as inliers, in units of the loss. Larger counts outliers; smaller leaves few.
pub(crate) const INLIER: f64 = 3.0;

/// Least degrees of freedom per near residual: keeps the noise of few residuals finite. Larger
/// understates it; smaller lets it grow.
pub(crate) const MIN_FREEDOM: f64 = 0.5;

/// Disparity below zero that a match may have: noise reaches there. Larger admits outliers behind
/// infinity; smaller cuts far inliers.
pub(crate) const MIN_DISPARITY_PX: f64 = 4.0;

/// Standard deviations of yaw that the smallest disparity allows for: yaw moves all disparities
/// alike. Larger learns less from scenes of one depth; smaller takes an error of yaw for a scene.
pub(crate) const YAW_DEVIATIONS: f64 = 3.0;

/// Noise of disparities that the information on the baseline loses, over the estimated one: noise along
/// the rows is not quite that across them. Larger loses information in far scenes; smaller takes noise
/// for disparity.
pub(crate) const DISPARITY_NOISE_MARGIN: f64 = 1.1;

/// Information on the baseline that a correspondence carries, in mean shares of the pass before;
/// beyond it the weight falls with the square. Larger lets a near outlier rule `t`; smaller loses
/// near inliers. 3 to 10 are equal in scenes 30 to 800 baselines deep.
pub(crate) const MAX_LEVERAGE: f64 = 8.0;

/// The same before the first step of a track, in median shares of those within the loss, which outliers do
/// not move; beyond it leverage is high. Larger lets a near outlier in; smaller loses near inliers.
pub(crate) const FIRST_MAX_LEVERAGE: f64 = 46.0;

/// Share that separates few near points before a far scene from the tail of one range of depths, in first
/// limits. Larger loses few near points; smaller lets near outliers in.
pub(crate) const MIN_SEPARATION: f64 = 4.0;

/// Correspondences that a survey reads. Larger costs time; smaller makes it noisy.
pub(crate) const SURVEYED: usize = 32;

/// Passes of a track: survey, two steps, evaluation. Larger costs time; smaller takes no step.
pub(crate) const TRACK_PASSES: u16 = 4;

/// Correspondences that a step of a track reads, of larger batches half: the pose
/// decides weights only. Larger costs time; smaller loses accuracy, half a batch a hundredth.
pub(crate) const TRACKED: usize = 128;

/// Squared step in standard deviations at which a search has converged: the optimum of the moments takes one more step.
/// Larger stops early; smaller spends passes.
pub(crate) const NEGLIGIBLE: f64 = 0.1;

/// Relative change of the noise at which it has settled. Larger stops early; smaller spends passes.
pub(crate) const SETTLED: f64 = 0.05;

/// Passes of evaluation and comparison beyond the configured limit: bounds `solve_pair`. Larger
/// raises the bound; smaller cuts a pair short.
pub(crate) const SPARE_PASSES: u16 = 8;

/// Near residuals at a pose found from afar, a part of the usable ones, with what each px of noise adds up to a most:
/// outliers within a wide peak are many. Larger refuses pairs full of outliers; smaller accepts a local optimum.
pub(crate) const FOUND_NEAR: [f64; 2] = [0.15, 0.25];
pub(crate) const FOUND_NEAR_MOST: f64 = 0.6;

/// At the pose of a track, which is known already: near residuals over those beside, how many there
/// are, and for a challenger, which is not confirmed, their excess in deviations of chance. Larger
/// rejects small and poor batches; smaller believes chance.
pub(crate) const TRACK_PEAK: f64 = 1.5;
pub(crate) const TRACK_MIN_NEAR: u32 = 8;
pub(crate) const CLEAR_PEAK_DEVIATIONS: f64 = 2.0;

/// Variance of the disparities of a pair about a plane, over that of their noise, below which they are those of the
/// same image on both sides. Noise alone, of a scene at infinity, is 1, and of a matcher better than the noise floor 0.1.
/// Larger refuses planes under little noise; smaller takes an image for a scene.
pub(crate) const ALIKE_DISPARITIES: f64 = 0.01;

/// Points clearly behind the cameras over those clearly in front, of correspondences that fit, above which the pose is
/// of a reversed baseline or of a mirrored image. A scene has none, but for a few mismatches. Larger takes a mirrored
/// image for a scene; smaller refuses scenes with repetitive textures.
pub(crate) const MAX_BEHIND: f64 = 0.5;

/// Least sum of the weights, in those of matches without residual, over the near residuals. Below it most that fit are
/// behind infinity or of high leverage. Larger refuses scenes of few near points; smaller fuses pairs of a few matches.
pub(crate) const MIN_WEIGHTED: f64 = 0.05;

/// Smallest eigenvalue of the information with unit diagonal; below it a direction is free. Larger
/// refuses weak scenes; smaller accepts rounding as information.
pub(crate) const MIN_CONDITION: f64 = 1e-5;

/// Power iterations to an extreme eigenvalue. Larger costs time; smaller loses digits.
pub(crate) const POWER_ITERATIONS: usize = 12;
