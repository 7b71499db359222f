//! The two cameras: in, out, and pixels to rays and back.

use nalgebra::Vector2;
use stereo_selfcal::{
    Camera, CameraError, Cameras, Fisheye, Intrinsics, Lens, RadialTangential, Side,
};
use zerocopy::FromBytes;

use crate::code::code;
use crate::code::selfcal_error_t::{self, *};
use crate::code_of::{of_camera, of_side};
use crate::instance::{Instance, instance, shared};
use crate::pointer::{Out, read};
use crate::storage::selfcal_t;

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
}

const PINHOLE: u32 = selfcal_lens_t::SELFCAL_LENS_PINHOLE as u32;
const RADIAL_TANGENTIAL: u32 = selfcal_lens_t::SELFCAL_LENS_RADIAL_TANGENTIAL as u32;
const FISHEYE: u32 = selfcal_lens_t::SELFCAL_LENS_FISHEYE as u32;

/// One of the two cameras.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum selfcal_side_t {
    /// Left: the origin of the rig, `p_r = R p_l + t`.
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
    /// Lens coefficients in OpenCV's order, dimensionless; 0 where the model has none.
    pub distortion: [f32; 5],
}

/// Why a camera was refused, before the side is known.
enum Fault {
    Core(CameraError),
    Lens,
    Coefficient,
}

impl From<CameraError> for Fault {
    fn from(error: CameraError) -> Self {
        Self::Core(error)
    }
}

impl Fault {
    fn code(self, side: Side) -> selfcal_error_t {
        match self {
            Self::Core(error) => of_camera(side, error),
            Self::Lens => of_side(side, SELFCAL_ERROR_LEFT_LENS, SELFCAL_ERROR_RIGHT_LENS),
            Self::Coefficient => {
                of_side(side, SELFCAL_ERROR_LEFT_COEFFICIENT, SELFCAL_ERROR_RIGHT_COEFFICIENT)
            }
        }
    }
}

impl selfcal_camera_t {
    fn core(&self) -> Result<Camera<f32>, Fault> {
        let [k1, k2, k3, k4, k5] = self.distortion;
        let none = |unused: &[f32]| {
            if unused.iter().all(|k| *k == 0.0) { Ok(()) } else { Err(Fault::Coefficient) }
        };
        let lens = match self.lens {
            PINHOLE => {
                none(&self.distortion)?;
                Lens::Pinhole
            }
            RADIAL_TANGENTIAL => {
                Lens::RadialTangential(RadialTangential::try_new(self.distortion)?)
            }
            FISHEYE => {
                none(&[k5])?;
                Lens::Fisheye(Fisheye::try_new([k1, k2, k3, k4])?)
            }
            _ => return Err(Fault::Lens),
        };
        let Self { focal_px: focal, principal_px: principal, size_px: size, .. } = *self;
        Ok(Camera::try_new(Intrinsics { focal, principal, size }, lens)?)
    }
}

impl From<&Camera<f32>> for selfcal_camera_t {
    fn from(camera: &Camera<f32>) -> Self {
        let Intrinsics { focal, principal, size } = *camera.intrinsics();
        let (lens, distortion) = match camera.lens() {
            Lens::Pinhole => (PINHOLE, [0.0; 5]),
            Lens::RadialTangential(lens) => (RADIAL_TANGENTIAL, lens.coefficients()),
            Lens::Fisheye(lens) => {
                let [k1, k2, k3, k4] = lens.coefficients();
                (FISHEYE, [k1, k2, k3, k4, 0.0])
            }
        };
        Self { focal_px: focal, principal_px: principal, size_px: size, lens, distortion }
    }
}

/// The cameras, once set.
pub(crate) fn cameras(instance: &Instance) -> Result<&Cameras<f32>, selfcal_error_t> {
    instance.calibrator.cameras().ok_or(SELFCAL_ERROR_NO_CAMERAS)
}

fn camera(instance: &Instance, side: u32) -> Result<&Camera<f32>, selfcal_error_t> {
    const LEFT: u32 = selfcal_side_t::SELFCAL_SIDE_LEFT as u32;
    const RIGHT: u32 = selfcal_side_t::SELFCAL_SIDE_RIGHT as u32;
    let cameras = cameras(instance)?;
    match side {
        LEFT => Ok(&cameras.left),
        RIGHT => Ok(&cameras.right),
        _ => Err(SELFCAL_ERROR_VALUE),
    }
}

/// Sets both cameras and forgets all that was learnt with others.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_set_cameras(
    cal: *mut selfcal_t,
    left: *const selfcal_camera_t,
    right: *const selfcal_camera_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, left, right) = unsafe { (instance(cal)?, read(left)?, read(right)?) };
        let left = left.core().map_err(|fault| fault.code(Side::Left))?;
        let right = right.core().map_err(|fault| fault.code(Side::Right))?;
        instance.solved = None;
        instance.calibrator.set_cameras(Cameras { left, right });
        Ok(())
    })
}

/// The cameras, as they were set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_cameras(
    cal: *const selfcal_t,
    left: *mut selfcal_camera_t,
    right: *mut selfcal_camera_t,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, left, right) =
            unsafe { (shared(cal)?, Out::checked(left)?, Out::checked(right)?) };
        let cameras = cameras(instance)?;
        left.set((&cameras.left).into());
        right.set((&cameras.right).into());
        Ok(())
    })
}

/// Undistorts: the ray at unit depth through a pixel.
///
/// * `side`: a `selfcal_side_t`.
/// * `pixel`: column u, row v in the image as it is, px.
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
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, pixel, out) = unsafe {
            (shared(cal)?, read::<[f32; 2]>(pixel.cast())?, Out::<[f32; 2]>::checked(ray.cast())?)
        };
        out.set(camera(instance, side)?.ray(pixel)?.into());
        Ok(())
    })
}

/// Distorts: the pixel of a ray at unit depth, wherever it falls.
///
/// * `side`: a `selfcal_side_t`.
/// * `ray`: x, y at z = 1, camera frame, dimensionless.
/// * `pixel`: column u, row v in the image as it is, px; the image bounds are not applied.
///
/// cbindgen:ptrs-as-arrays=[[ray; 2], [pixel; 2]]
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_pixel(
    cal: *const selfcal_t,
    side: u32,
    ray: *const f32,
    pixel: *mut f32,
) -> selfcal_error_t {
    code(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, ray, out) = unsafe {
            (shared(cal)?, read::<[f32; 2]>(ray.cast())?, Out::<[f32; 2]>::checked(pixel.cast())?)
        };
        out.set(camera(instance, side)?.pixel(Vector2::from(ray))?);
        Ok(())
    })
}
