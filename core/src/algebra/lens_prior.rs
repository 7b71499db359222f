//! Uncertainty of the given lens models.

use super::lens_terms::{LENS_PARAMETERS, LensValues};
use crate::scalar::Scalar;

/// Standard deviations of the errors of the given lens models; 0 takes a parameter as exact. `focal`, `principal_px`
/// and `k1` apply to each camera; `p1` and `p2` say what they apply to.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct LensPrior {
    /// Relative focal length.
    pub focal: f32,
    /// Each coordinate of the principal point, px.
    pub principal_px: f32,
    /// Radial coefficient `k1`.
    pub k1: f32,
    /// Tangential coefficient `p1` of the right camera minus the one of the left camera.
    pub p1: f32,
    /// Tangential coefficient `p2` of the right camera, as far as it turns the baseline.
    /// [`crate::Config::with_lens_yaw_sd_rad`] covers the apparent yaw that `p2` also causes.
    pub p2: f32,
}

impl LensPrior {
    /// Uncertainty of a year-old calibration: two calibrations of the same camera differ by this much.
    pub const WIDE: Self =
        Self { focal: 0.003, principal_px: 1.0, k1: 0.005, p1: 0.001, p2: 0.000_25 };

    /// Exact lens models.
    pub const NONE: Self = Self { focal: 0.0, principal_px: 0.0, k1: 0.0, p1: 0.0, p2: 0.0 };

    /// Returns the standard deviations of the lens parameters, in the order of the lens terms.
    ///
    /// * `focal`: mean focal length of the cameras, px.
    pub(crate) fn of_terms<T: Scalar>(&self, focal: T) -> [T; LENS_PARAMETERS] {
        let [scale, principal, k1, p1] =
            [self.focal, self.principal_px, self.k1, self.p1].map(T::single);
        let principal = [principal / focal; 2];
        LensValues { focal: [scale; 2], column: principal, row: principal, k1: [k1; 2], p1 }.into()
    }

    /// Returns whether each value is finite and within the range of [`crate::Config::with_lens_prior`].
    pub(crate) const fn is_valid(&self) -> bool {
        const fn within(sd: f32, most: f32) -> bool {
            sd >= 0.0 && sd <= most
        }
        within(self.focal, 0.1)
            && within(self.principal_px, 100.0)
            && within(self.k1, 0.1)
            && within(self.p1, 0.1)
            && within(self.p2, 0.1)
    }
}
