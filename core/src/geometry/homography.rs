//! Rectifying homographies for a chosen new camera, and a sensible choice of it (eq 5).
//!
//! `H_l = K R_l K_l^-1`, `H_r = K R_r K_r^-1`: from undistorted pixels of each camera to pixels of
//! the common rectified camera `K`, in homogeneous coordinates.

use nalgebra::{Matrix3, Rotation3, Vector2, Vector3};

use crate::batch::correspondence::Cameras;
use crate::error::{RectifyError, Side};
use crate::geometry::camera::Camera;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;

/// Points sampled along each border of an image.
const BORDER_SAMPLES: u16 = 16;

/// The common camera of both rectified views: one focal length, no distortion.
///
/// # Examples
///
/// ```
/// use stereo_selfcal::{
///     Camera, Cameras, Extrinsics, Intrinsics, Lens, RectifiedCamera, RectifyingRotations,
/// };
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
    /// Chooses a camera for rectified images of the left camera's size, as `cv::stereoRectify`
    /// does with one principal point for both (zero disparity at infinity).
    ///
    /// * `alpha`: 0 zooms in until every rectified pixel is seen by both cameras; 1 zooms out
    ///   until every pixel of both is kept; between, the focal length is interpolated.
    ///
    /// Cost: 136 undistortions; call it when the extrinsics change, not per frame.
    ///
    /// For rigs whose rectified images are upright: cameras side by side, the left one to the left.
    ///
    /// # Errors
    /// [`RectifyError`].
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
        // The principal point puts the middle of the chosen rectangle into the middle of the image.
        let zoom = |r: &Rectangle<T>| last.component_div(&(r.high - r.low));
        let (inside, outside) = (zoom(&inner), zoom(&outer));
        let near = inside.x.max(inside.y);
        let far = outside.x.min(outside.y);
        let focal = near + (far - near) * alpha;
        let middle = inner.middle() + (outer.middle() - inner.middle()) * alpha;
        let principal = last * T::HALF - middle * focal;
        Ok(Self { focal, principal: principal.into() })
    }

    /// `K`, px.
    pub fn matrix(&self) -> Matrix3<T> {
        let [cx, cy] = self.principal;
        let (zero, one) = (T::ZERO, T::ONE);
        Matrix3::new(self.focal, zero, cx, zero, self.focal, cy, zero, zero, one)
    }

    /// `[H_l, H_r]` of eq 5: undistorted pixels of each camera to rectified pixels.
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
    fn intersection(&self, other: &Self) -> Self {
        Self { low: self.low.sup(&other.low), high: self.high.inf(&other.high) }
    }

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

/// What one camera sees of the rectified plane: a rectangle inside its border and one around it.
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
            let along = [right * share, bottom * share];
            let seen = |u: T, v: T| rectified(camera, r, side, [u, v]);
            let [top, bottom_edge] = [seen(along[0], T::ZERO)?, seen(along[0], bottom)?];
            let [left, right_edge] = [seen(T::ZERO, along[1])?, seen(right, along[1])?];
            for point in [top, bottom_edge, left, right_edge] {
                outer.low = outer.low.inf(&point);
                outer.high = outer.high.sup(&point);
            }
            inner.low = inner.low.sup(&Vector2::new(left.x, top.y));
            inner.high = inner.high.inf(&Vector2::new(right_edge.x, bottom_edge.y));
        }
        Ok(Self { inner, outer })
    }
}

/// Where a pixel falls on the rectified plane at unit depth.
fn rectified<T: Scalar>(
    camera: &Camera<T>,
    r: &Rotation3<T>,
    side: Side,
    pixel: [T; 2],
) -> Result<Vector2<T>, RectifyError> {
    let ray = camera.ray(pixel).map_err(|e| RectifyError::Border(side, e))?;
    let p = r * Vector3::new(ray.x, ray.y, T::ONE);
    if p.z >= T::lit(0.05) {
        Ok(Vector2::new(p.x / p.z, p.y / p.z))
    } else {
        Err(RectifyError::Behind(side))
    }
}
