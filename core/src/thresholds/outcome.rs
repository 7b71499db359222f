//! Thresholds of causes, verdict and details.

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

/// Solved pairs in a row that the estimate rejects, from which it confirms no depth; a challenger takes over after three
/// that agree. A larger number arms longer by an estimate that the pairs contradict; a smaller one disarms by chance.
pub(crate) const MAX_REJECTED: u8 = 5;

/// Squared Mahalanobis distance of the calibration in use from the estimate, above which a change is worthwhile. Chance
/// exceeds it in 1 % of the cases. A larger limit asks for changes later; a smaller one asks for changes because of
/// noise.
pub(crate) const SIGNIFICANT_CHANGE: f64 = 15.1;

/// RMS row offset of the proposal over that in use, below which a change is worthwhile. A larger ratio asks for changes
/// because of noise; a smaller one misses real changes.
pub(crate) const IMPROVEMENT: f64 = 0.9;

/// Row offset in a corner of the image from which the text of the details names the lens, px. A larger limit hides
/// offsets that a row search meets; a smaller one names offsets that no matcher notices.
pub(crate) const NAMED_ROWS_PX: f64 = 0.1;
