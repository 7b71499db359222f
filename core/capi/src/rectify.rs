//! Input of a rectifier: rotations, common camera, homographies.

use nalgebra::Matrix3;
use stereo_selfcal::geometry::{LensCorrection, RectifiedCamera, RectifyingRotations};
use stereo_selfcal::{Cameras, Extrinsics};
use zerocopy::FromBytes;

use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::instance::{Instance, selfcal_t, shared};
use crate::pointer::{Out, read};

/// Calibration to rectify with: extrinsics, and the cameras that they belong to.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_source_t {
    /// The calibration in use.
    SELFCAL_SOURCE_IN_USE = 0,
    /// The estimate, `extrinsics` of the proposal.
    SELFCAL_SOURCE_PROPOSED = 1,
    /// The calibration that `selfcal_apply` would put into use.
    SELFCAL_SOURCE_APPLICABLE = 2,
}

/// Rectifying rotations `R_l`, `R_r`, which align the rows of both views.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_rotations_t {
    /// `R_l`, left camera frame to rectified frame, row by row.
    pub left: [f32; 9],
    /// `R_r`, right camera frame to rectified frame, row by row.
    pub right: [f32; 9],
}

/// Common camera of both rectified views, without distortion.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_rectified_camera_t {
    /// Focal length, px.
    pub focal_px: f32,
    /// Principal point cx, cy, px.
    pub principal_px: [f32; 2],
}

/// Homographies from undistorted pixels of each camera to pixels of the rectified camera.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct selfcal_homographies_t {
    /// `H_l = K R_l K_l^-1`, row by row.
    pub left: [f32; 9],
    /// `H_r = K R_r K_r^-1`, row by row.
    pub right: [f32; 9],
}

fn rows(m: &Matrix3<f32>) -> [f32; 9] {
    [m.m11, m.m12, m.m13, m.m21, m.m22, m.m23, m.m31, m.m32, m.m33]
}

/// Returns the extrinsics of a source, and the correction of the cameras that they belong to; `None` for the cameras in
/// use.
fn extrinsics(
    instance: &Instance,
    source: u32,
) -> Result<(Extrinsics<f32>, Option<LensCorrection<f32>>), selfcal_error_t> {
    const IN_USE: u32 = selfcal_source_t::SELFCAL_SOURCE_IN_USE as u32;
    const PROPOSED: u32 = selfcal_source_t::SELFCAL_SOURCE_PROPOSED as u32;
    const APPLICABLE: u32 = selfcal_source_t::SELFCAL_SOURCE_APPLICABLE as u32;
    let calibrator = &instance.calibrator;
    let proposal = || calibrator.proposal().ok_or(SELFCAL_ERROR_NO_ESTIMATE);
    match source {
        IN_USE => Ok((calibrator.in_use().extrinsics, None)),
        PROPOSED => proposal().map(|p| (p.extrinsics, Some(p.correction))),
        APPLICABLE => proposal().map(|p| (p.applicable, Some(p.applicable_correction))),
        _ => Err(SELFCAL_ERROR_VALUE),
    }
}

/// Returns the cameras of a source, and the rotations that belong to them.
fn calibration(
    instance: &Instance,
    source: u32,
) -> Result<(Cameras<f32>, RectifyingRotations<f32>), selfcal_error_t> {
    let (extrinsics, correction) = extrinsics(instance, source)?;
    let calibrator = &instance.calibrator;
    let cameras = match correction {
        None => calibrator.in_use().cameras,
        Some(correction) => {
            let corrected = instance.cameras.corrected(&correction);
            corrected.map_err(|_| SELFCAL_ERROR_INCONSISTENT)?
        }
    };
    Ok((cameras, (&extrinsics).into()))
}

/// Computes the two rectifying rotations.
///
/// * `source`: a `selfcal_source_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_rotations(
    cal: *const selfcal_t,
    source: u32,
    rectifying: *mut selfcal_rotations_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(rectifying)?) };
        let rotations = RectifyingRotations::from(&extrinsics(instance, source)?.0);
        out.set(selfcal_rotations_t {
            left: rows(rotations.left().matrix()),
            right: rows(rotations.right().matrix()),
        });
        Ok(())
    })
}

/// Chooses the common camera of both rectified images, which have the size of the left image. This is for cameras side
/// by side. It takes 136 undistortions: call it when the generation changes, and not for each frame.
///
/// * `source`: a `selfcal_source_t`.
/// * `alpha`: 0 to 1. 0 zooms in until both cameras see every rectified pixel; 1 zooms out until every
///   pixel of both is kept.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_choose_camera(
    cal: *const selfcal_t,
    source: u32,
    alpha: f32,
    camera: *mut selfcal_rectified_camera_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, out) = unsafe { (shared(cal)?, Out::checked(camera)?) };
        let (cameras, rotations) = calibration(instance, source)?;
        let chosen = RectifiedCamera::try_choose(&cameras, &rotations, alpha)?;
        out.set(selfcal_rectified_camera_t {
            focal_px: chosen.focal,
            principal_px: chosen.principal,
        });
        Ok(())
    })
}

/// Computes the two rectifying homographies.
///
/// * `source`: a `selfcal_source_t`.
/// * `camera`: from `selfcal_choose_camera`, or any other camera with finite numbers and a focal length above 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_homographies(
    cal: *const selfcal_t,
    source: u32,
    camera: *const selfcal_rectified_camera_t,
    homographies: *mut selfcal_homographies_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, camera, out) =
            unsafe { (shared(cal)?, read(camera)?, Out::checked(homographies)?) };
        let camera = RectifiedCamera { focal: camera.focal_px, principal: camera.principal_px };
        let [cx, cy] = camera.principal;
        let finite = camera.focal.is_finite() && cx.is_finite() && cy.is_finite();
        if !finite || camera.focal <= 0.0 {
            return Err(SELFCAL_ERROR_VALUE);
        }
        let (cameras, rotations) = calibration(instance, source)?;
        let [left, right] = camera.homographies(&cameras, &rotations);
        out.set(selfcal_homographies_t { left: rows(&left), right: rows(&right) });
        Ok(())
    })
}
