//! Thresholds of the errors of the lens models.

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

/// Number of pairs before the first change of the lens reference, and of a challenger that does not depart from the
/// champion; number of changes up to which each change doubles the number of pairs. Larger numbers change the reference
/// later; smaller ones change it by the error of a few pairs.
pub(crate) const MIN_REFERENCE_PAIRS: u32 = 8;
pub(crate) const MAX_REFERENCE_CHANGES: u32 = 4;
