//! The two cameras, and the conversion between pixels and rays.

use core::ffi::CStr;

use nalgebra::Vector2;
use stereo_selfcal::geometry::{CameraError, Fisheye, RadialTangential, Rational};
use stereo_selfcal::{Camera, Intrinsics, Lens};
use zerocopy::FromBytes;

use crate::enumeration::text;
use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::instance::{Instance, selfcal_t, shared};
use crate::pointer::{Out, read};

/// Lens models, with OpenCV's coefficients.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_lens_t {
    /// No distortion.
    SELFCAL_LENS_PINHOLE = 0,
    /// Brown's model, `cv::undistortPoints` with k1 k2 p1 p2 k3.
    SELFCAL_LENS_RADIAL_TANGENTIAL = 1,
    /// Kannala-Brandt equidistant, `cv::fisheye` with k1 k2 k3 k4.
    SELFCAL_LENS_FISHEYE = 2,
    /// Rational model, `cv::undistortPoints` with k1 k2 p1 p2 k3 k4 k5 k6.
    SELFCAL_LENS_RATIONAL = 3,
}

const PINHOLE: u32 = selfcal_lens_t::SELFCAL_LENS_PINHOLE as u32;
const RADIAL_TANGENTIAL: u32 = selfcal_lens_t::SELFCAL_LENS_RADIAL_TANGENTIAL as u32;
const FISHEYE: u32 = selfcal_lens_t::SELFCAL_LENS_FISHEYE as u32;
const RATIONAL: u32 = selfcal_lens_t::SELFCAL_LENS_RATIONAL as u32;

/// One of the two cameras.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_side_t {
    /// Left: its frame is the frame of the rig, `p_r = R p_l + t`.
    SELFCAL_SIDE_LEFT = 0,
    /// Right.
    SELFCAL_SIDE_RIGHT = 1,
}

/// A calibrated camera.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, FromBytes)]
pub struct selfcal_camera_t {
    /// Focal lengths fx, fy, px; 1 to 1e6.
    pub focal_px: [f32; 2],
    /// Principal point cx, cy, px; (0, 0) is the centre of the top left pixel.
    pub principal_px: [f32; 2],
    /// Image width, height, px.
    pub size_px: [u16; 2],
    /// A `selfcal_lens_t`.
    pub lens: u32,
    /// Lens coefficients in OpenCV's order, dimensionless. Coefficients that the model does not use must be 0.
    pub distortion: [f32; 8],
}

/// Texts of a fault of a camera: for the left camera and for the right camera.
pub(crate) type Fault = [&'static CStr; 2];

/// Returns both texts of a fault.
macro_rules! of_either {
    ($text:literal) => {
        [text(concat!("left camera: ", $text, "\0")), text(concat!("right camera: ", $text, "\0"))]
    };
}

const UNUSED: Fault = of_either!("a coefficient that the lens model does not use is not 0");
const NO_LENS: Fault = of_either!("the lens model is no value of selfcal_lens_t");

fn fault(error: CameraError) -> Fault {
    match error {
        CameraError::FocalLength => {
            of_either!("a focal length is not finite or not within 1 to 1e6 px")
        }
        CameraError::PrincipalPoint => {
            of_either!("the principal point is not finite, or further from the image than its size")
        }
        CameraError::ImageSize => of_either!("the image is smaller than 2 x 2 px"),
        CameraError::Distortion => {
            of_either!("a lens coefficient is above 1e3 in size or not finite")
        }
        _ => of_either!("unknown"),
    }
}

impl selfcal_camera_t {
    /// Returns the camera of the core, or the texts of the fault. It checks all fields, because the caller may have
    /// written any bits.
    pub(crate) fn core(&self) -> Result<Camera<f32>, Fault> {
        let [k1, k2, k3, k4, k5, beyond @ ..] = self.distortion;
        let none = |unused: &[f32]| {
            if unused.iter().all(|k| *k == 0.0) { Ok(()) } else { Err(UNUSED) }
        };
        let lens = match self.lens {
            PINHOLE => {
                none(&self.distortion)?;
                Lens::Pinhole
            }
            RADIAL_TANGENTIAL => {
                none(&beyond)?;
                let five = [k1, k2, k3, k4, k5];
                Lens::RadialTangential(RadialTangential::try_new(five).map_err(fault)?)
            }
            FISHEYE => {
                none(&[k5])?;
                none(&beyond)?;
                Lens::Fisheye(Fisheye::try_new([k1, k2, k3, k4]).map_err(fault)?)
            }
            RATIONAL => Lens::Rational(Rational::try_new(self.distortion).map_err(fault)?),
            _ => return Err(NO_LENS),
        };
        let Self { focal_px: focal, principal_px: principal, size_px: size, .. } = *self;
        Camera::try_new(Intrinsics { focal, principal, size }, lens).map_err(fault)
    }
}

impl From<&Camera<f32>> for selfcal_camera_t {
    fn from(camera: &Camera<f32>) -> Self {
        let Intrinsics { focal, principal, size } = *camera.intrinsics();
        let (lens, distortion) = match camera.lens() {
            Lens::Pinhole => (PINHOLE, [0.0; 8]),
            Lens::RadialTangential(lens) => {
                let [k1, k2, p1, p2, k3] = lens.coefficients();
                (RADIAL_TANGENTIAL, [k1, k2, p1, p2, k3, 0.0, 0.0, 0.0])
            }
            Lens::Fisheye(lens) => {
                let [k1, k2, k3, k4] = lens.coefficients();
                (FISHEYE, [k1, k2, k3, k4, 0.0, 0.0, 0.0, 0.0])
            }
            Lens::Rational(lens) => (RATIONAL, lens.coefficients()),
        };
        Self { focal_px: focal, principal_px: principal, size_px: size, lens, distortion }
    }
}

/// Returns a camera of the calibration in use.
fn camera(instance: &Instance, side: u32) -> Result<Camera<f32>, selfcal_error_t> {
    const LEFT: u32 = selfcal_side_t::SELFCAL_SIDE_LEFT as u32;
    const RIGHT: u32 = selfcal_side_t::SELFCAL_SIDE_RIGHT as u32;
    let cameras = instance.calibrator.in_use().cameras;
    match side {
        LEFT => Ok(cameras.left),
        RIGHT => Ok(cameras.right),
        _ => Err(SELFCAL_ERROR_VALUE),
    }
}

/// Undistorts a pixel to the ray at unit depth, with a camera of the calibration in use.
///
/// * `side`: a `selfcal_side_t`.
/// * `pixel`: column u, row v in the raw image, px.
/// * `ray`: x, y at z = 1, camera frame, dimensionless.
///
/// cbindgen:ptrs-as-arrays=[[pixel; 2], [ray; 2]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_ray(
    cal: *const selfcal_t,
    side: u32,
    pixel: *const f32,
    ray: *mut f32,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, pixel, out) = unsafe {
            (shared(cal)?, read::<[f32; 2]>(pixel.cast())?, Out::<[f32; 2]>::checked(ray.cast())?)
        };
        out.set(camera(instance, side)?.ray(pixel)?.into());
        Ok(())
    })
}

/// Distorts a ray at unit depth to its pixel, with a camera of the calibration in use.
///
/// * `side`: a `selfcal_side_t`.
/// * `ray`: x, y at z = 1, camera frame, dimensionless.
/// * `pixel`: column u, row v in the raw image, px; it may be outside the image.
///
/// cbindgen:ptrs-as-arrays=[[ray; 2], [pixel; 2]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_pixel(
    cal: *const selfcal_t,
    side: u32,
    ray: *const f32,
    pixel: *mut f32,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, ray, out) = unsafe {
            (shared(cal)?, read::<[f32; 2]>(ray.cast())?, Out::<[f32; 2]>::checked(pixel.cast())?)
        };
        out.set(camera(instance, side)?.pixel(Vector2::from(ray))?);
        Ok(())
    })
}
