//! Lenses and cameras.

use core::hint::black_box;

use stereo_selfcal::geometry::{Fisheye, RadialTangential, Rational};
use stereo_selfcal::{Camera, Cameras, Intrinsics, Lens};

use crate::{numbers, show};

pub(crate) fn all() -> Option<Cameras<f32>> {
    let cameras = Cameras { left: camera()?, right: camera()? };
    show(cameras.mean_focal());
    Some(cameras)
}

fn camera() -> Option<Camera<f32>> {
    let intrinsics = Intrinsics { focal: numbers(), principal: numbers(), size: black_box([0; 2]) };
    let camera = Camera::try_new(intrinsics, lens()?).ok()?;
    show(camera.intrinsics());
    show(camera.lens());
    show(camera.mean_focal());
    show(camera.inverse_matrix());
    show(camera.ray(numbers()));
    show(camera.pixel(numbers().into()));
    Some(camera)
}

fn lens() -> Option<Lens<f32>> {
    let brown = RadialTangential::try_new(numbers()).ok()?;
    let fisheye = Fisheye::try_new(numbers()).ok()?;
    let rational = Rational::try_new(numbers()).ok()?;
    show(brown.coefficients());
    show(fisheye.coefficients());
    show(rational.coefficients());
    Some(match black_box(0) {
        0 => Lens::Pinhole,
        1 => Lens::RadialTangential(brown),
        2 => Lens::Fisheye(fisheye),
        _ => Lens::Rational(rational),
    })
}
