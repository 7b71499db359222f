//! Cameras of 1920 x 1200 px, focal length 1400 px.

use stereo_selfcal::geometry::RadialTangential;
use stereo_selfcal::{Camera, Cameras, Intrinsics, Lens, Scalar};

pub(crate) const SIZE: [u16; 2] = [1920, 1200];
pub(crate) const FOCAL_PX: f32 = 1400.0;

/// Coefficients of a wide-angle lens, in OpenCV's order.
const DISTORTION: [f64; 5] = [-0.283, 0.0429, 1.1e-3, -9.5e-5, 0.115];

pub(crate) fn pinholes<T: Scalar>() -> Cameras<T> {
    cameras(Lens::Pinhole)
}

/// Two cameras with radial and tangential distortion.
///
/// # Panics
/// Never: the constant coefficients are finite.
pub(crate) fn distorted<T: Scalar>() -> Cameras<T> {
    let lens = RadialTangential::try_new(DISTORTION.map(T::lit)).expect("coefficients are finite");
    cameras(Lens::RadialTangential(lens))
}

fn cameras<T: Scalar>(lens: Lens<T>) -> Cameras<T> {
    let focal = [T::lit(FOCAL_PX.into()); 2];
    let principal = SIZE.map(|n| T::count(n.into()) * T::HALF);
    let intrinsics = Intrinsics { focal, principal, size: SIZE };
    let camera = Camera::try_new(intrinsics, lens).expect("intrinsics are in range");
    Cameras { left: camera, right: camera }
}
