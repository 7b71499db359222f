//! A calibrated camera: pixels to rays at unit depth and back.
//!
//! Pixel coordinates follow OpenCV: `(0, 0)` is the centre of the top left pixel, u right, v down.
//! Camera frame: x right, y down, z forward.

mod lens;

use nalgebra::{Matrix3, Vector2};

pub use lens::{Fisheye, Lens, RadialTangential};

use crate::error::{CameraError, ProjectError, UndistortError};
use crate::scalar::Scalar;

/// Rays further than this from the axis (85 degrees) have no useful unit-depth form.
pub(crate) const MAX_TANGENT: f64 = 11.43;

/// Pinhole intrinsics, in pixels, and the size of the image they hold for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Intrinsics<T> {
    /// Focal lengths `[fx, fy]`, px.
    pub focal: [T; 2],
    /// Principal point `[cx, cy]`, px.
    pub principal: [T; 2],
    /// Image `[width, height]`, px.
    pub size: [u16; 2],
}

/// Validated intrinsics with a validated lens model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera<T> {
    intrinsics: Intrinsics<T>,
    lens: Lens<T>,
}

impl<T: Scalar> Camera<T> {
    /// Checks the intrinsics: focal lengths finite and from 1 to 1e6 px, an image of at least
    /// 2 x 2 px, a principal point no further from the image than its own size.
    ///
    /// # Errors
    /// [`CameraError`] names the quantity.
    pub fn try_new(intrinsics: Intrinsics<T>, lens: Lens<T>) -> Result<Self, CameraError> {
        let within = |x: T, low: T, high: T| x >= low && x <= high;
        let [fx, fy] = intrinsics.focal;
        if !within(fx, T::ONE, T::lit(1e6)) || !within(fy, T::ONE, T::lit(1e6)) {
            return Err(CameraError::FocalLength);
        }
        let [width, height] = intrinsics.size;
        if width < 2 || height < 2 {
            return Err(CameraError::ImageSize);
        }
        let [cx, cy] = intrinsics.principal;
        let [w, h] = [T::count(width.into()), T::count(height.into())];
        if !within(cx, -w, w + w) || !within(cy, -h, h + h) {
            return Err(CameraError::PrincipalPoint);
        }
        Ok(Self { intrinsics, lens })
    }

    /// The intrinsics, px.
    pub fn intrinsics(&self) -> &Intrinsics<T> {
        &self.intrinsics
    }

    /// The lens model.
    pub fn lens(&self) -> &Lens<T> {
        &self.lens
    }

    /// Mean of the two focal lengths, px: what turns a row offset at unit depth into pixels.
    pub fn mean_focal(&self) -> T {
        let [fx, fy] = self.intrinsics.focal;
        (fx + fy) * T::HALF
    }

    /// `K^-1`, row-major as nalgebra prints it, 1/px.
    pub fn inverse_matrix(&self) -> Matrix3<T> {
        let [fx, fy] = self.intrinsics.focal;
        let [cx, cy] = self.intrinsics.principal;
        let (zero, one) = (T::ZERO, T::ONE);
        Matrix3::new(one / fx, zero, -cx / fx, zero, one / fy, -cy / fy, zero, zero, one)
    }

    /// Ray `(x, y)` at unit depth through a pixel: `p = K^-1 [u v 1]` after undistortion.
    ///
    /// # Errors
    /// [`UndistortError`]: the pixel is not finite, not in the image (half a pixel of grace), or
    /// the lens model is not invertible there.
    pub fn ray(&self, pixel: [T; 2]) -> Result<Vector2<T>, UndistortError> {
        let [u, v] = pixel;
        if !u.is_finite() || !v.is_finite() {
            return Err(UndistortError::NotFinite);
        }
        let [width, height] = self.intrinsics.size;
        let outside = |x: T, n: u16| x < T::MINUS_ONE || x > T::count(n.into());
        if outside(u, width) || outside(v, height) {
            return Err(UndistortError::OutsideImage);
        }
        let [fx, fy] = self.intrinsics.focal;
        let [cx, cy] = self.intrinsics.principal;
        self.lens
            .undistort(Vector2::new((u - cx) / fx, (v - cy) / fy))
            .ok_or(UndistortError::NotInvertible)
    }

    /// Pixel of a ray at unit depth, wherever it falls; the image bounds are not applied.
    ///
    /// # Errors
    /// [`ProjectError`]: the ray is not finite or lies beyond the range of the lens model.
    pub fn pixel(&self, ray: Vector2<T>) -> Result<[T; 2], ProjectError> {
        if !ray.x.is_finite() || !ray.y.is_finite() {
            return Err(ProjectError::NotFinite);
        }
        let d = self.lens.distort(ray).ok_or(ProjectError::BeyondLens)?;
        let [fx, fy] = self.intrinsics.focal;
        let [cx, cy] = self.intrinsics.principal;
        Ok([fx * d.x + cx, fy * d.y + cy])
    }
}
