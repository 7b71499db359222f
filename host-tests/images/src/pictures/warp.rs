//! Images as another camera would show them.

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};
use rayon::prelude::*;
use stereo_selfcal::geometry::RectifiedCamera;
use stereo_selfcal::{Camera, Scalar};

use super::grey::Grey;

/// An image of that size whose pixel at `q` is the bilinear value of `image` at `source(q)`.
pub fn warp(
    image: &Grey,
    size: [u16; 2],
    source: impl Fn([f64; 2]) -> Option<[f64; 2]> + Sync,
) -> Grey {
    let [width, height] = size;
    let row = |v: u16| {
        let source = &source;
        (0..width).map(move |u| {
            let value = image.sample(source([u, v].map(f64::from))?)?;
            u8::try_from((value + 0.5).to_u16()).ok()
        })
    };
    let rows: Vec<Vec<Option<u8>>> =
        (0..height).into_par_iter().map(|v| row(v).collect()).collect();
    Grey::try_new(size, rows.concat()).unwrap_or_else(|_| image.clone())
}

/// The image of the camera after a rotation: `p' = Rot p` (see [`TurnedView`](rigs::data::TurnedView)).
pub fn turned(image: &Grey, camera: &Camera<f64>, rotation: &Matrix3<f64>) -> Grey {
    let back = rotation.transpose();
    warp(image, image.size(), |pixel| {
        let ray = camera.ray(pixel).ok()?;
        projected(camera, back * ray.push(1.0))
    })
}

/// The image of the rectified camera.
///
/// * `rotation`: rotation of this camera's frame into the rectified one.
/// * `size`: size of the rectified image, px; that of the left image for both.
pub fn rectified(
    image: &Grey,
    camera: &Camera<f64>,
    rotation: &Rotation3<f64>,
    target: &RectifiedCamera<f64>,
    size: [u16; 2],
) -> Grey {
    warp(image, size, |pixel| projected(camera, rotation.inverse() * ray_of(target, pixel)))
}

/// The ray of a rectified pixel, at unit depth.
pub fn ray_of(target: &RectifiedCamera<f64>, [u, v]: [f64; 2]) -> Vector3<f64> {
    let [cx, cy] = target.principal;
    Vector3::new((u - cx) / target.focal, (v - cy) / target.focal, 1.0)
}

/// Position in the image of a point of the camera's frame; `None` behind the camera or beyond the lens model.
pub fn projected(camera: &Camera<f64>, p: Vector3<f64>) -> Option<[f64; 2]> {
    if p.z <= 0.0 {
        return None;
    }
    camera.pixel(Vector2::new(p.x / p.z, p.y / p.z)).ok()
}
