//! Thresholds of the mount yaw and of its witnesses.

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
