//! Calibrated camera: pixels to rays at unit depth and back.
//!
//! Pixel coordinates follow OpenCV: `(0, 0)` is the centre of the top left pixel, u right, v down. Camera frame: x
//! right, y down, z forward. A ray `(x, y)` is the point `(x, y, 1)`.

use nalgebra::{Matrix3, Vector2};

use super::distortion::Undistorted;
use super::lens::Lens;
use super::lens_correction::LensCorrection;
use crate::error::{CameraError, ProjectError, UndistortError};
use crate::scalar::Scalar;

/// Pinhole intrinsics `K`, px, and the size of the image that they are valid for.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Intrinsics<T> {
    /// Focal lengths `[fx, fy]`, px.
    pub focal: [T; 2],
    /// Principal point `[cx, cy]`, px.
    pub principal: [T; 2],
    /// Image `[width, height]`, px.
    pub size: [u16; 2],
}

/// Validated intrinsics with a validated lens model.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{Camera, Intrinsics, Lens};
/// use stereo_selfcal::geometry::RadialTangential;
/// let intrinsics = Intrinsics { focal: [534.0, 531.0], principal: [342.0, 234.5], size: [640, 480] };
/// // k1, k2, p1, p2, k3, as cv::calibrateCamera returns them.
/// let lens = RadialTangential::try_new([-0.283, 0.0429, 1.1e-3, -9.5e-5, 0.0])?;
/// let camera = Camera::<f32>::try_new(intrinsics, Lens::RadialTangential(lens))?;
/// let ray = camera.ray([100.0, 50.0])?; // at unit depth, undistorted
/// let [u, v] = camera.pixel(ray)?;
/// assert!((u - 100.0).abs() < 1e-3 && (v - 50.0).abs() < 1e-3);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(try_from = "Parts<T>", bound(deserialize = "T: Scalar + serde::Deserialize<'de>"))
)]
pub struct Camera<T> {
    intrinsics: Intrinsics<T>,
    lens: Lens<T>,
}

/// Ray of a pixel, and the density of the pixels there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct CameraRay<T> {
    /// Ray at unit depth, in the camera frame, dimensionless.
    pub(crate) ray: Vector2<T>,
    /// Number of pixels of an area at unit depth, relative to a pinhole of the same focal lengths; above 0.
    pub(crate) density: T,
}

/// Unchecked fields from which a camera is deserialised.
#[cfg(feature = "serde")]
#[derive(serde::Deserialize)]
struct Parts<T: Scalar> {
    intrinsics: Intrinsics<T>,
    lens: Lens<T>,
}

#[cfg(feature = "serde")]
impl<T: Scalar> TryFrom<Parts<T>> for Camera<T> {
    type Error = CameraError;

    fn try_from(Parts { intrinsics, lens }: Parts<T>) -> Result<Self, CameraError> {
        Self::try_new(intrinsics, lens)
    }
}

impl<T: Scalar> Camera<T> {
    /// Returns a camera. Focal lengths must be from 1 to 1e6 px, the image at least 2 x 2 px, and the principal point
    /// no further outside the image than the size of the image.
    ///
    /// # Errors
    /// [`CameraError`] names the quantity that is out of range or not finite.
    #[inline(never)]
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

    /// Returns the camera with corrected focal lengths and first radial coefficient.
    ///
    /// # Errors
    /// [`CameraError`] names the quantity that is then out of range.
    pub(crate) fn corrected(&self, by: &LensCorrection<T>) -> Result<Self, CameraError> {
        let focal = self.intrinsics.focal.map(|f| f * (T::ONE + by.focal));
        Self::try_new(Intrinsics { focal, ..self.intrinsics }, self.lens.corrected(by.k1)?)
    }

    /// Returns the intrinsics, px.
    pub fn intrinsics(&self) -> &Intrinsics<T> {
        &self.intrinsics
    }

    /// Returns the lens model.
    pub fn lens(&self) -> &Lens<T> {
        &self.lens
    }

    /// Returns the largest product `|x y|` over the rays `(x, y)` of the image, at unit depth, dimensionless.
    /// Distortion is ignored.
    pub(crate) fn corner(&self) -> T {
        let Intrinsics { focal, principal, size } = &self.intrinsics;
        let axes = focal.iter().zip(principal).zip(size);
        let reach = axes.map(|((f, c), n)| (*c).max(T::count((*n).into()) - *c) / *f);
        reach.fold(T::ONE, |product, reach| product * reach)
    }

    /// Returns the mean of the two focal lengths, px: the size in pixels of a row offset of 1 at unit depth.
    pub fn mean_focal(&self) -> T {
        let [fx, fy] = self.intrinsics.focal;
        (fx + fy) * T::HALF
    }

    /// Returns `K^-1`, which maps homogeneous undistorted pixels to rays at unit depth, 1/px.
    pub fn inverse_matrix(&self) -> Matrix3<T> {
        let [fx, fy] = self.intrinsics.focal;
        let [cx, cy] = self.intrinsics.principal;
        let (zero, one) = (T::ZERO, T::ONE);
        Matrix3::new(one / fx, zero, -cx / fx, zero, one / fy, -cy / fy, zero, zero, one)
    }

    /// Returns the ray `(x, y)` at unit depth through a pixel: the point `K^-1 [u v 1]`, undistorted.
    ///
    /// # Errors
    /// [`UndistortError`]: the pixel is not finite or more than half a pixel outside the image, the lens model is not
    /// invertible there, or the ray is more than 85 degrees off axis.
    pub fn ray(&self, pixel: [T; 2]) -> Result<Vector2<T>, UndistortError> {
        self.check(pixel)?;
        self.ray_of_checked(pixel).map(|found| found.ray)
    }

    /// Returns [`Camera::ray`] of a pixel that [`Camera::check`] accepts, with the density of the pixels there.
    #[inline(always)]
    pub(crate) fn ray_of_checked(&self, [u, v]: [T; 2]) -> Result<CameraRay<T>, UndistortError> {
        let [fx, fy] = self.intrinsics.focal;
        let [cx, cy] = self.intrinsics.principal;
        self.lens
            .undistort(Vector2::new((u - cx) / fx, (v - cy) / fy))
            .map(|Undistorted { point, density }| CameraRay { ray: point, density })
            .ok_or(UndistortError::NotInvertible)
    }

    /// Checks that a pixel is finite and in the image, as [`Camera::ray`] does before it undistorts.
    #[inline(always)]
    pub(crate) fn check(&self, [u, v]: [T; 2]) -> Result<(), UndistortError> {
        let [width, height] = self.intrinsics.size;
        // A NaN is outside.
        let inside = |x: T, n: u16| x >= T::MINUS_ONE && x <= T::count(n.into());
        if inside(u, width) && inside(v, height) {
            Ok(())
        } else if u.is_finite() && v.is_finite() {
            Err(UndistortError::OutsideImage)
        } else {
            Err(UndistortError::NotFinite)
        }
    }

    /// Returns the pixel of a ray at unit depth, px; the pixel may lie outside the image.
    ///
    /// # Errors
    /// [`ProjectError`]: the ray is not finite or beyond the range of the lens model.
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

#[cfg(test)]
mod tests {
    use super::super::lens::{Fisheye, RadialTangential};
    use super::super::rational::Rational;
    use super::*;
    use proptest::prelude::*;

    const SIZE: [u16; 2] = [640, 480];

    fn camera<T: Scalar>(lens: Lens<T>) -> Camera<T> {
        let [focal, principal] = [[534.0, 531.0], [342.0, 234.5]].map(|x| x.map(T::lit));
        Camera::try_new(Intrinsics { focal, principal, size: SIZE }, lens).unwrap()
    }

    fn lenses<T: Scalar>() -> [Lens<T>; 5] {
        let brown =
            |k: [f64; 5]| Lens::RadialTangential(RadialTangential::try_new(k.map(T::lit)).unwrap());
        let fisheye = |k: [f64; 4]| Lens::Fisheye(Fisheye::try_new(k.map(T::lit)).unwrap());
        [
            Lens::Pinhole,
            brown([-0.283, 0.0429, 1.1e-3, -9.5e-5, 0.115]),
            brown([0.118, -0.230, -5.6e-4, -2.6e-3, 0.0285]),
            fisheye([-0.013, 0.027, -0.031, 0.011]),
            Lens::Rational(
                Rational::try_new([9.1, 5.2, 1e-4, -2e-4, 0.3, 9.5, 7.6, 1.2].map(T::lit)).unwrap(),
            ),
        ]
    }

    /// Returns the largest distance, over all lenses, between a pixel and the pixel of its ray, px.
    fn largest_error<T: Scalar>([u, v]: [f64; 2]) -> f64 {
        let error = |lens| {
            let camera = camera(lens);
            let ray = camera.ray([T::lit(u), T::lit(v)]).unwrap();
            let [u2, v2] = camera.pixel(ray).unwrap().map(T::to_f64);
            (u2 - u).hypot(v2 - v)
        };
        lenses::<T>().map(error).into_iter().fold(0.0, f64::max)
    }

    proptest! {
        #[test]
        fn the_density_is_the_area_of_a_ray_in_the_image(u in 0.0..639.0_f64, v in 0.0..479.0_f64) {
            for lens in lenses() {
                let camera = camera::<f64>(lens);
                let CameraRay { ray, density } = camera.ray_of_checked([u, v]).unwrap();
                let h = 1e-4;
                let along = |d: Vector2<f64>| {
                    let [plus, minus] = [h, -h].map(|h| camera.pixel(ray + d * h).unwrap());
                    [plus[0] - minus[0], plus[1] - minus[1]].map(|d| d / (2.0 * h))
                };
                let ([a, b], [c, d]) = (along(Vector2::x()), along(Vector2::y()));
                let numeric = (a * d - b * c) / (534.0 * 531.0);
                prop_assert!((density / numeric - 1.0).abs() < 1e-5, "{lens:?}: {density} {numeric}");
            }
        }

        #[test]
        fn pixels_go_to_rays_and_back(u in 0.0..639.0_f64, v in 0.0..479.0_f64) {
            prop_assert!(largest_error::<f64>([u, v]) < 1e-9);
            prop_assert!(largest_error::<f32>([u, v]) < 3e-4);
        }

        #[test]
        fn every_ray_of_any_lens_returns_to_its_pixel(
            k in [-2.0..2.0_f64, -2.0..2.0, -0.1..0.1, -0.1..0.1, -2.0..2.0],
            u in -10.0..650.0_f64, v in -10.0..490.0_f64,
        ) {
            let [k1, k2, p1, p2, k3] = k;
            let brown = Lens::RadialTangential(RadialTangential::try_new(k).unwrap());
            let fisheye = Lens::Fisheye(Fisheye::try_new([k1, k2, p1 + p2, k3]).unwrap());
            let rational = [k1, k2, p1, p2, k3, k2, k3, k1];
            let rational = Lens::Rational(Rational::try_new(rational).unwrap());
            for lens in [brown, fisheye, rational] {
                let camera = camera(lens);
                if let Ok(ray) = camera.ray([u, v]) {
                    let [u2, v2] = camera.pixel(ray).unwrap();
                    prop_assert!((u2 - u).hypot(v2 - v) < 1e-6, "{lens:?}");
                }
            }
        }
    }

    #[test]
    fn distortion_matches_opencv() {
        // Evaluates the formulas of OpenCV's documentation at (0.3, -0.2).
        let [_, brown, _, fisheye, rational] = lenses::<f64>();
        let expect = |lens: Lens<f64>, x: f64, y: f64| {
            let [u, v] = camera(lens).pixel(Vector2::new(0.3, -0.2)).unwrap();
            let [dx, dy] = [(u - 342.0) / 534.0, (v - 234.5) / 531.0];
            assert!((dx - x).abs() < 1e-12 && (dy - y).abs() < 1e-12, "{dx} {dy}");
        };
        let (s, xy) = (0.13_f64, -0.06);
        let radial = 1.0 - 0.283 * s + 0.0429 * s * s + 0.115 * s * s * s;
        let (p1, p2) = (1.1e-3, -9.5e-5);
        expect(
            brown,
            0.3 * radial + 2.0 * p1 * xy + p2 * (s + 0.18),
            -0.2 * radial + p1 * (s + 0.08) + 2.0 * p2 * xy,
        );
        let g = (1.0 + 9.1 * s + 5.2 * s * s + 0.3 * s * s * s)
            / (1.0 + 9.5 * s + 7.6 * s * s + 1.2 * s * s * s);
        let (p1, p2) = (1e-4, -2e-4);
        expect(
            rational,
            0.3 * g + 2.0 * p1 * xy + p2 * (s + 0.18),
            -0.2 * g + p1 * (s + 0.08) + 2.0 * p2 * xy,
        );
        let r = s.sqrt();
        let theta = r.atan();
        let (t2, t4) = (theta.powi(2), theta.powi(4));
        let scale = theta * (1.0 - 0.013 * t2 + 0.027 * t4 - 0.031 * t2 * t4 + 0.011 * t4 * t4) / r;
        expect(fisheye, 0.3 * scale, -0.2 * scale);
    }

    #[test]
    fn pixels_and_rays_beyond_the_fold_of_the_model_are_refused() {
        // Radial slope 1 - 3 s vanishes at radius 0.577, where the distorted radius is 0.385.
        let lens =
            Lens::RadialTangential(RadialTangential::try_new([-1.0, 0.0, 0.0, 0.0, 0.0]).unwrap());
        let camera = camera::<f32>(lens);
        let at = |radius: f32| camera.ray([342.0 - 534.0 * radius, 234.5]);
        assert!(at(0.38).is_ok());
        assert_eq!(at(0.39), Err(UndistortError::NotInvertible));
        assert_eq!(camera.pixel(Vector2::new(0.6, 0.0)), Err(ProjectError::BeyondLens));
    }

    #[test]
    fn pixels_that_are_not_finite_or_not_in_the_image_are_refused() {
        let camera = camera::<f32>(Lens::Pinhole);
        for (pixel, why) in [
            ([f32::NAN, 0.0], UndistortError::NotFinite),
            ([0.0, f32::NEG_INFINITY], UndistortError::NotFinite),
            ([641.0, 0.0], UndistortError::OutsideImage),
            ([0.0, -1e30], UndistortError::OutsideImage),
        ] {
            assert_eq!(camera.ray(pixel), Err(why));
        }
        assert!(camera.ray([-0.5, 479.5]).is_ok());
    }

    #[test]
    fn cameras_out_of_range_are_refused_by_name() {
        let good = *camera::<f32>(Lens::Pinhole).intrinsics();
        let refused = |bad, why| assert_eq!(Camera::try_new(bad, Lens::Pinhole), Err(why));
        for bad in [0.0, -500.0, f32::NAN, f32::INFINITY, 1e9] {
            refused(Intrinsics { focal: [500.0, bad], ..good }, CameraError::FocalLength);
        }
        for bad in [f32::NAN, 1e5, -1e5] {
            refused(Intrinsics { principal: [bad, 240.0], ..good }, CameraError::PrincipalPoint);
        }
        refused(Intrinsics { size: [640, 1], ..good }, CameraError::ImageSize);
        assert_eq!(Fisheye::try_new([0.0, f32::NAN, 0.0, 0.0]), Err(CameraError::Distortion));
    }
}
