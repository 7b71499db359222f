//! Errors of the lens models that pairs show.

use core::fmt;

use crate::algebra::lens_prior::LensPrior;
use crate::scalar::Scalar;
use crate::thresholds::{BAD_PX, GROSS_LENS, SIGNIFICANT};

/// A parameter with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Finding<T> {
    /// Estimated error: the true value minus the given value.
    pub value: T,
    /// Standard deviation of the value; at first the standard deviation of the prior. For the parameters of
    /// [`LensEstimate`] it includes a sixth of the error that is not compensated: the weights of the matches were
    /// computed with this error and may hide a sixth of it.
    pub sd: T,
}

impl<T: Scalar> Finding<T> {
    /// Returns whether the value exceeds three standard deviations.
    pub fn is_significant(&self) -> bool {
        self.value.abs() > T::lit(SIGNIFICANT) * self.sd
    }
}

/// Errors of the given lens models that pairs show. Only [`crate::LensTracking::Compensate`] corrects the extrinsics
/// for them, namely for the differences of focal length and `k1`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct LensEstimate<T> {
    /// Relative error of the focal length, right minus left: 0.001 if the right one is 0.1 % longer than given.
    pub focal: Finding<T>,
    /// Radial coefficient `k1`, right minus left.
    pub k1: Finding<T>,
    /// Radial coefficient `k1`, mean of both cameras. Half of a `k1` that is compensated is not included.
    pub k1_mean: Finding<T>,
    /// Tangential coefficient `p1`, right minus left.
    pub p1: Finding<T>,
    /// Column of the principal point, right minus left, px.
    pub principal_x_px: Finding<T>,
}

impl<T: Scalar> LensEstimate<T> {
    /// Returns whether a parameter exceeds three standard deviations.
    pub fn is_significant(&self) -> bool {
        let Self { focal, k1, k1_mean, p1, principal_x_px } = self;
        [focal, k1, k1_mean, p1, principal_x_px].into_iter().any(Finding::is_significant)
    }

    /// Returns whether the mean `k1` or `p1` has a significant error that is larger than any calibration leaves;
    /// neither is compensated. If the row offsets are poor, an error above the standard deviation of the prior is
    /// enough.
    ///
    /// * `rows_px`: RMS row offset of a pair about its own optimum, px.
    pub(crate) fn is_gross(&self, prior: &LensPrior, rows_px: T) -> bool {
        let Self { k1_mean, p1, .. } = self;
        let most = if rows_px >= T::lit(BAD_PX) { T::ONE } else { T::lit(GROSS_LENS) };
        [(k1_mean, prior.k1), (p1, prior.p1)].into_iter().any(|(found, prior)| {
            found.is_significant() && found.value.abs() > most * T::single(prior)
        })
    }
}

impl<T: Scalar> fmt::Display for LensEstimate<T> {
    /// Writes the parameters that exceed three standard deviations: `focal lengths differ by 0.200 % +- 0.020 %, ...`;
    /// `as given` if no parameter does.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { focal, k1, k1_mean, p1, principal_x_px } = self;
        let percent = T::lit(100.0);
        let mut separator = "";
        if focal.is_significant() {
            let [value, sd] = [focal.value * percent, focal.sd * percent];
            write!(f, "focal lengths differ by {value:.3} % +- {sd:.3} %")?;
            separator = ", ";
        }
        for (name, found) in [
            ("k1 differ by", k1),
            ("mean k1 is off by", k1_mean),
            ("p1 differ by", p1),
            ("principal columns differ by px", principal_x_px),
        ] {
            if found.is_significant() {
                let Finding { value, sd } = found;
                write!(f, "{separator}{name} {value:.5} +- {sd:.5}")?;
                separator = ", ";
            }
        }
        if separator.is_empty() { f.write_str("as given") } else { Ok(()) }
    }
}
