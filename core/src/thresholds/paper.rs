//! Thresholds of the published method.

/// Damping of the first step, relative to the diagonal. A larger value slows convergence; a smaller one overshoots.
pub(crate) const FIRST_DAMPING: f64 = 1e-4;

/// Damping above which a small step does not prove convergence, and range of the damping. Larger limits stop early or
/// try longer; smaller ones spend passes or give up.
pub(crate) const LOOSE_DAMPING: f64 = 1e-2;
pub(crate) const MIN_DAMPING: f64 = 1e-9;
pub(crate) const MAX_DAMPING: f64 = 1e8;

/// Nielsen's rule: least and largest factor of the damping after an accepted step, and growth of the damping factor at
/// each rejected step. Larger values damp more; smaller ones overshoot.
pub(crate) const DAMPING_FACTOR: [f64; 2] = [0.1, 2.0];
pub(crate) const DAMPING_GROWTH: f64 = 2.0;

/// Least step tolerance, in units in the last place of 1 rad; and rounding of the cost, in units in the last place of
/// the cost, below which slopes decide. Larger values stop early; smaller ones follow rounding.
pub(crate) const TOLERANCE_ULPS: f64 = 8.0;
pub(crate) const COST_ULPS: f64 = 2.0;

/// Angle of `R` below which its axis is noise, and above which the axis may be reversed. Larger values doubt more near
/// 0 and less near pi; smaller ones doubt less near 0 and more near pi.
pub(crate) const MIN_ANGLE_RAD: f64 = 3e-3;
pub(crate) const MAX_ANGLE_RAD: f64 = 3.0;

/// Length of the mean unit axis below which pairs do not agree on an axis, and of the mean baseline below which
/// directions cancel. Larger values doubt more estimates; smaller ones report noise.
pub(crate) const MIN_CONCENTRATION: f64 = 0.9;
pub(crate) const MIN_MEAN_BASELINE: f64 = 1e-3;

/// Part of the squared disparities of a pair that may be noise. A larger part estimates the baseline from a scene at
/// infinity; a smaller one refuses far scenes.
pub(crate) const MAX_DISPARITY_NOISE: f64 = 0.75;

/// Values that the median sorts before it takes steps. A larger number takes memory; a smaller one makes the median
/// less accurate.
pub(crate) const MEDIAN_VALUES: usize = 31;

/// Least median absolute deviation of the first values from which the steps of the median are computed. A larger value
/// makes the median jitter; with a smaller one, equal first values make the steps too short.
pub(crate) const MIN_DEVIATION_RAD: f64 = 1e-6;
