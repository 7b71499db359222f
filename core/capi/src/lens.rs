//! Errors of the given lens models: their standard deviations, and their correction.

use stereo_selfcal::LensPrior;
use stereo_selfcal::geometry::LensCorrection;
use zerocopy::FromBytes;

/// Standard deviations of the errors of the given lens models; 0 takes a parameter as exact. `focal`, `principal_px`
/// and `k1` apply to each camera; each of the other fields says what it applies to. Without a given lens prior the
/// values are, in the order of the fields, 0.003, 1 px, 0.005, 0.001, 0.00025 and 0.0046 rad.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_lens_prior_t {
    /// Focal length, relative.
    pub focal: f32,
    /// Principal point, each coordinate, px.
    pub principal_px: f32,
    /// Radial coefficient `k1`.
    pub k1: f32,
    /// Tangential coefficient `p1` of the right camera minus the one of the left camera.
    pub p1: f32,
    /// Tangential coefficient `p2` of the right camera.
    pub p2: f32,
    /// Apparent yaw `a` of the lenses, rad: it shifts rows by `a x y` at unit depth.
    pub yaw_rad: f32,
}

impl From<selfcal_lens_prior_t> for LensPrior {
    fn from(prior: selfcal_lens_prior_t) -> Self {
        let selfcal_lens_prior_t { focal, principal_px, k1, p1, p2, .. } = prior;
        Self { focal, principal_px, k1, p1, p2 }
    }
}

/// Correction that is added to the given lens model of the right camera; 0 leaves it as given.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_lens_correction_t {
    /// Relative focal length: 0.001 makes the right one longer by 0.1 %.
    pub focal: f32,
    /// Radial coefficient `k1`.
    pub k1: f32,
}

impl From<LensCorrection<f32>> for selfcal_lens_correction_t {
    fn from(correction: LensCorrection<f32>) -> Self {
        Self { focal: correction.focal, k1: correction.k1 }
    }
}
