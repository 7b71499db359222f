//! The two cameras, and conversion between pixels and rays.

use nalgebra::Vector2;
use stereo_selfcal::{
    Calibration, Camera, CameraError, Cameras, Fisheye, Intrinsics, Lens, RadialTangential,
    Rational, Side,
};
use zerocopy::FromBytes;

use crate::error::selfcal_error_t::{self, *};
use crate::error::status;
use crate::instance::{Instance, exclusive, selfcal_t, shared};
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
    /// Lens coefficients in OpenCV's order, dimensionless; 0 where the model uses none.
    pub distortion: [f32; 8],
}

/// Errors beyond those of [`CameraError`]; numbers of the left camera as there.
const LENS_ERROR: u16 = SELFCAL_ERROR_LEFT_LENS as u16;
const COEFFICIENT_ERROR: u16 = SELFCAL_ERROR_LEFT_COEFFICIENT as u16;

/// The error of a camera, from the number of the left one.
pub(crate) fn error(side: Side, left: u16) -> selfcal_error_t {
    selfcal_error_t::of(left + 10 * side.code()).unwrap_or(SELFCAL_ERROR_UNKNOWN)
}

impl selfcal_camera_t {
    fn core(&self, side: Side) -> Result<Camera<f32>, selfcal_error_t> {
        self.try_core().map_err(|left| error(side, left))
    }

    fn try_core(&self) -> Result<Camera<f32>, u16> {
        let number = |why: CameraError| why.code();
        let [k1, k2, k3, k4, k5, beyond @ ..] = self.distortion;
        let none = |unused: &[f32]| {
            if unused.iter().all(|k| *k == 0.0) { Ok(()) } else { Err(COEFFICIENT_ERROR) }
        };
        let lens = match self.lens {
            PINHOLE => {
                none(&self.distortion)?;
                Lens::Pinhole
            }
            RADIAL_TANGENTIAL => {
                none(&beyond)?;
                let five = [k1, k2, k3, k4, k5];
                Lens::RadialTangential(RadialTangential::try_new(five).map_err(number)?)
            }
            FISHEYE => {
                none(&[k5])?;
                none(&beyond)?;
                Lens::Fisheye(Fisheye::try_new([k1, k2, k3, k4]).map_err(number)?)
            }
            RATIONAL => Lens::Rational(Rational::try_new(self.distortion).map_err(number)?),
            _ => return Err(LENS_ERROR),
        };
        let Self { focal_px: focal, principal_px: principal, size_px: size, .. } = *self;
        Camera::try_new(Intrinsics { focal, principal, size }, lens).map_err(number)
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

/// The cameras as given, if set.
pub(crate) fn given(instance: &Instance) -> Result<&Cameras<f32>, selfcal_error_t> {
    Ok(&instance.given()?.cameras)
}

/// The calibration in use.
pub(crate) fn in_use(instance: &Instance) -> Result<Calibration<f32>, selfcal_error_t> {
    instance.given()?;
    Ok(instance.calibrator.in_use())
}

/// A camera of the calibration in use.
fn camera(instance: &Instance, side: u32) -> Result<Camera<f32>, selfcal_error_t> {
    const LEFT: u32 = selfcal_side_t::SELFCAL_SIDE_LEFT as u32;
    const RIGHT: u32 = selfcal_side_t::SELFCAL_SIDE_RIGHT as u32;
    let cameras = in_use(instance)?.cameras;
    match side {
        LEFT => Ok(cameras.left),
        RIGHT => Ok(cameras.right),
        _ => Err(SELFCAL_ERROR_VALUE),
    }
}

/// Sets both cameras and resets the calibrator.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_set_cameras(
    cal: *mut selfcal_t,
    left: *const selfcal_camera_t,
    right: *const selfcal_camera_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, left, right) = unsafe { (exclusive(cal)?, read(left)?, read(right)?) };
        let left = left.core(Side::Left)?;
        let right = right.core(Side::Right)?;
        instance.set_cameras(Cameras { left, right });
        Ok(())
    })
}

/// Reads the cameras as given.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn selfcal_cameras(
    cal: *const selfcal_t,
    left: *mut selfcal_camera_t,
    right: *mut selfcal_camera_t,
) -> selfcal_error_t {
    status(|| {
        // SAFETY: the caller keeps the contract of the crate.
        let (instance, left, right) =
            unsafe { (shared(cal)?, Out::checked(left)?, Out::checked(right)?) };
        let cameras = given(instance)?;
        left.set((&cameras.left).into());
        right.set((&cameras.right).into());
        Ok(())
    })
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

/// Distorts a ray at unit depth to its pixel, inside the image or not, with a camera of the calibration in
/// use.
///
/// * `side`: a `selfcal_side_t`.
/// * `ray`: x, y at z = 1, camera frame, dimensionless.
/// * `pixel`: column u, row v in the raw image, px; not limited to the image.
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
