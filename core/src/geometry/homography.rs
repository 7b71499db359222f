//! Rectifying homographies (eq 5), and the choice of the common rectified camera.
//!
//! `H_l = K R_l K_l^-1`, `H_r = K R_r K_r^-1`: they map undistorted pixels of each camera to pixels of the common
//! rectified camera `K`, in homogeneous coordinates.

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};

use crate::error::{RectifyError, Side};
use crate::geometry::camera::Camera;
use crate::geometry::cameras::Cameras;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::thresholds::MIN_DEPTH;

/// Number of equal parts into which the sampled points divide each border of an image.
const BORDER_SAMPLES: u16 = 16;

/// The common camera of both rectified views: one focal length, no distortion.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{Camera, Cameras, Extrinsics, Intrinsics, Lens};
/// use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};
/// let intrinsics = Intrinsics { focal: [1400.0; 2], principal: [959.5, 599.5], size: [1920, 1200] };
/// let camera = Camera::try_new(intrinsics, Lens::Pinhole)?;
/// let cameras = Cameras { left: camera, right: camera };
/// let rotations = RectifyingRotations::from(&Extrinsics::<f32>::SIDE_BY_SIDE);
/// let rectified = RectifiedCamera::try_choose(&cameras, &rotations, 0.0)?;
/// let [left, right] = rectified.homographies(&cameras, &rotations); // undistorted to rectified px
/// assert_eq!(left, right);
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RectifiedCamera<T> {
    /// Focal length, px.
    pub focal: T,
    /// Principal point `[cx, cy]`, px.
    pub principal: [T; 2],
}

impl<T: Scalar> core::fmt::Display for RectifiedCamera<T> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let [cx, cy] = self.principal;
        write!(f, "focal length {:.2} px, principal point {cx:.2}, {cy:.2} px", self.focal)
    }
}

impl<T: Scalar> RectifiedCamera<T> {
    /// Chooses a camera for rectified images of the left camera's size, as `cv::stereoRectify` does
    /// with `CALIB_ZERO_DISPARITY`: one principal point for both views.
    ///
    /// * `alpha`: zoom, 0 to 1. 0 zooms in until both cameras see every rectified pixel; 1 zooms out until every pixel
    ///   of both images is kept. In between, the focal length is linear in `alpha`.
    ///
    /// This is for rigs whose rectified images are upright: cameras side by side, the left one to the left. Cost: 136
    /// undistortions; call it when the extrinsics change, not per frame.
    ///
    /// # Errors
    /// [`RectifyError`]: `alpha` out of range, a border pixel not rectifiable, or no common view.
    pub fn try_choose(
        cameras: &Cameras<T>,
        rotations: &RectifyingRotations<T>,
        alpha: T,
    ) -> Result<Self, RectifyError> {
        if !(alpha >= T::ZERO && alpha <= T::ONE) {
            return Err(RectifyError::Alpha);
        }
        let left = View::of(&cameras.left, rotations.left(), Side::Left)?;
        let right = View::of(&cameras.right, rotations.right(), Side::Right)?;
        let inner = left.inner.intersection(&right.inner);
        let outer = left.outer.union(&right.outer);
        if !inner.has_area() {
            return Err(RectifyError::NoCommonView);
        }
        let [width, height] = cameras.left.intrinsics().size;
        let last = Vector2::new(width, height).map(|n| T::count(n.into()) - T::ONE);
        let zoom = |r: &Rectangle<T>| last.component_div(&(r.high - r.low));
        let (inside, outside) = (zoom(&inner), zoom(&outer));
        let near = inside.x.max(inside.y);
        let far = outside.x.min(outside.y);
        let focal = near + (far - near) * alpha;
        let middle = inner.middle() + (outer.middle() - inner.middle()) * alpha;
        // The middle of the chosen rectangle falls on the middle of the image.
        let principal = last * T::HALF - middle * focal;
        Ok(Self { focal, principal: principal.into() })
    }

    /// Returns `K`, px, which maps rectified rays at unit depth to pixels.
    pub fn matrix(&self) -> Matrix3<T> {
        let [cx, cy] = self.principal;
        let (zero, one) = (T::ZERO, T::ONE);
        Matrix3::new(self.focal, zero, cx, zero, self.focal, cy, zero, zero, one)
    }

    /// Returns `[H_l, H_r]` of eq 5, which map homogeneous undistorted pixels of each camera to rectified pixels.
    pub fn homographies(
        &self,
        cameras: &Cameras<T>,
        rotations: &RectifyingRotations<T>,
    ) -> [Matrix3<T>; 2] {
        let k = self.matrix();
        [
            k * rotations.left().matrix() * cameras.left.inverse_matrix(),
            k * rotations.right().matrix() * cameras.right.inverse_matrix(),
        ]
    }
}

/// Axis-aligned rectangle of the rectified plane at unit depth.
#[derive(Debug, Clone, Copy)]
struct Rectangle<T> {
    low: Vector2<T>,
    high: Vector2<T>,
}

impl<T: Scalar> Rectangle<T> {
    #[inline(always)]
    fn intersection(&self, other: &Self) -> Self {
        Self { low: self.low.sup(&other.low), high: self.high.inf(&other.high) }
    }

    #[inline(always)]
    fn union(&self, other: &Self) -> Self {
        Self { low: self.low.inf(&other.low), high: self.high.sup(&other.high) }
    }

    fn has_area(&self) -> bool {
        self.high.x > self.low.x && self.high.y > self.low.y
    }

    fn middle(&self) -> Vector2<T> {
        (self.low + self.high) * T::HALF
    }
}

/// Field of view of one camera on the rectified plane: the largest rectangle inside the image border, and the smallest
/// rectangle around the border.
struct View<T> {
    inner: Rectangle<T>,
    outer: Rectangle<T>,
}

impl<T: Scalar> View<T> {
    fn of(camera: &Camera<T>, r: &Rotation3<T>, side: Side) -> Result<Self, RectifyError> {
        let huge = Vector2::repeat(T::lit(1e6));
        let mut outer = Rectangle { low: huge, high: -huge };
        let mut inner = Rectangle { low: -huge, high: huge };
        let [width, height] = camera.intrinsics().size;
        let [right, bottom] = [width, height].map(|n| T::count(n.into()) - T::ONE);
        for i in 0..=BORDER_SAMPLES {
            let share = T::count(i.into()) / T::count(BORDER_SAMPLES.into());
            let seen = |u: T, v: T| rectified(camera, r, side, [u, v]);
            let (u, v) = (right * share, bottom * share);
            let [top, below] = [seen(u, T::ZERO)?, seen(u, bottom)?];
            let [before, after] = [seen(T::ZERO, v)?, seen(right, v)?];
            for point in [top, below, before, after] {
                outer = outer.union(&Rectangle { low: point, high: point });
            }
            let low = Vector2::new(before.x, top.y);
            let high = Vector2::new(after.x, below.y);
            inner = inner.intersection(&Rectangle { low, high });
        }
        Ok(Self { inner, outer })
    }
}

/// Returns the point of a pixel on the rectified plane at unit depth.
///
/// # Errors
/// [`RectifyError`]: the pixel has no ray, or the rectified depth is below 0.05.
fn rectified<T: Scalar>(
    camera: &Camera<T>,
    r: &Rotation3<T>,
    side: Side,
    pixel: [T; 2],
) -> Result<Vector2<T>, RectifyError> {
    let ray = camera.ray(pixel).map_err(|e| RectifyError::Border(side, e))?;
    let p = r * Vector3::new(ray.x, ray.y, T::ONE);
    if !(p.z >= T::lit(MIN_DEPTH)) {
        return Err(RectifyError::Behind(side));
    }
    Ok(Vector2::new(p.x / p.z, p.y / p.z))
}
