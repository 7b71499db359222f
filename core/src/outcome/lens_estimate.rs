//! Errors of the lens models, as far as pairs show them.

use core::fmt;

use crate::config::LensPrior;
use crate::scalar::Scalar;
use crate::thresholds::{BAD_PX, GROSS_LENS, LENS_FOUND};

/// A parameter with its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Finding<T> {
    /// Estimate of the true value less the given one.
    pub value: T,
    /// Standard deviation; at first that of the prior. It contains a sixth of the value: the weights of the matches assume the
    /// given lens, and hide up to that much.
    pub sd: T,
}

impl<T: Scalar> Finding<T> {
    /// Whether the value exceeds three standard deviations.
    pub fn is_significant(&self) -> bool {
        self.value.abs() > T::lit(LENS_FOUND) * self.sd
    }
}

/// Errors of the given lens models, as far as pairs show them. The extrinsics are not corrected by them.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub struct LensEstimate<T> {
    /// Relative focal length, right less left: 0.001 where the right one is 0.1 % longer than given.
    pub focal: Finding<T>,
    /// Radial coefficient `k1`, right less left.
    pub k1: Finding<T>,
    /// Radial coefficient `k1`, mean of both cameras.
    pub k1_mean: Finding<T>,
    /// Tangential coefficient `p1`, right less left.
    pub p1: Finding<T>,
    /// Principal column, right less left, px.
    pub principal_x_px: Finding<T>,
}

impl<T: Scalar> LensEstimate<T> {
    /// Whether a parameter exceeds three standard deviations.
    pub fn is_significant(&self) -> bool {
        let Self { focal, k1, k1_mean, p1, principal_x_px } = self;
        [focal, k1, k1_mean, p1, principal_x_px].into_iter().any(Finding::is_significant)
    }

    /// Whether a parameter that is not compensated is off by more than a calibration leaves. Where rows are poor, off by more
    /// than the prior is enough.
    ///
    /// * `rows_px`: RMS row offset of a pair about its own optimum.
    pub(crate) fn is_gross(&self, prior: &LensPrior, rows_px: T) -> bool {
        let Self { k1_mean, p1, .. } = self;
        let most = if rows_px >= T::lit(BAD_PX) { T::ONE } else { T::lit(GROSS_LENS) };
        [(k1_mean, prior.k1), (p1, prior.p1)].into_iter().any(|(found, prior)| {
            found.is_significant() && found.value.abs() > most * T::single(prior)
        })
    }
}

impl<T: Scalar> fmt::Display for LensEstimate<T> {
    /// The parameters that exceed three standard deviations: `focal lengths differ by 0.20 % +- 0.02 %, ...`; `as given` if nothing.
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
