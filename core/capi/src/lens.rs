//! Errors of the given lens models: how large they may be, and what is done about them.

use stereo_selfcal::{LensCorrection, LensPrior, LensTracking};
use zerocopy::FromBytes;

use crate::error::selfcal_error_t::{self, *};

/// Standard deviations of the given lens models, of each camera; 0 takes a parameter as exact.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_lens_prior_t {
    /// Focal length, relative.
    pub focal: f32,
    /// Principal point, each coordinate, px.
    pub principal_px: f32,
    /// Radial coefficient `k1`.
    pub k1: f32,
    /// Tangential coefficient `p1`, of the right camera less that of the left one.
    pub p1: f32,
    /// Tangential coefficient `p2`.
    pub p2: f32,
}

impl From<selfcal_lens_prior_t> for LensPrior {
    fn from(prior: selfcal_lens_prior_t) -> Self {
        let selfcal_lens_prior_t { focal, principal_px, k1, p1, p2 } = prior;
        Self { focal, principal_px, k1, p1, p2 }
    }
}

/// What is done about errors of the given lens models.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_lens_tracking_t {
    /// They are estimated, and widen the deviations. Extrinsics are those of the given lens models.
    SELFCAL_LENS_TRACKING_REPORT = 0,
    /// Differences of focal length and of `k1` are compensated, where that halves the deviation of `t`:
    /// `SELFCAL_FUSED_LENS_CORRECTED`. For callers who rectify with the cameras of the calibration in
    /// use, as the functions here do.
    SELFCAL_LENS_TRACKING_COMPENSATE = 1,
}

pub(crate) fn tracking(tracking: u32) -> Result<LensTracking, selfcal_error_t> {
    const REPORT: u32 = selfcal_lens_tracking_t::SELFCAL_LENS_TRACKING_REPORT as u32;
    const COMPENSATE: u32 = selfcal_lens_tracking_t::SELFCAL_LENS_TRACKING_COMPENSATE as u32;
    match tracking {
        REPORT => Ok(LensTracking::Report),
        COMPENSATE => Ok(LensTracking::Compensate),
        _ => Err(SELFCAL_ERROR_VALUE),
    }
}

/// What is added to the given lens model of the right camera; 0 leaves it as given.
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
