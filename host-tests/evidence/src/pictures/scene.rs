//! A stereo pair with its images.

use anyhow::{Context, Result};
use nalgebra::{Matrix3, Vector3};
use stereo_selfcal::Camera;
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};

use images::pictures::{Grey, projected, ray_of, turned};
use rigs::data::{Dataset, TurnedView};

/// Disparity steps a pixel in the published file.
const STEPS_PER_PX: f64 = 4.0;

/// A data set, the images of one of its pairs, and the published depth, if any.
#[derive(Debug, Clone)]
pub struct PicturedScene {
    /// All pairs; the left view is turned.
    pub set: Dataset,
    /// Index of the pair of the images.
    pub pair: usize,
    /// The left image, turned like the points.
    pub left: Grey,
    /// The right image.
    pub right: Grey,
    depth: Option<Depth>,
}

/// Published disparities, in the left image before it was turned.
#[derive(Debug, Clone)]
struct Depth {
    disparities: Grey,
    camera: Camera<f64>,
    /// `cx_r - cx_l`, px.
    offset: f64,
    /// Rotation of the view, old to new left camera frame.
    rotation: Matrix3<f64>,
}

impl PicturedScene {
    /// Names of the shipped scenes.
    pub const SHIPPED: [&str; 3] = ["motorcycle_sift", "opencv_chess_sift", "opencv_chess_corners"];

    /// A shipped scene, its left view turned up by so many degrees.
    ///
    /// # Errors
    /// If there is no such scene, or its files are damaged.
    pub fn shipped(name: &str, degrees: f64) -> Result<Self> {
        let [left, right] = match name {
            "motorcycle_sift" => ["motorcycle_left.jpg", "motorcycle_right.jpg"],
            "opencv_chess_sift" | "opencv_chess_corners" => {
                ["chess_01_left.jpg", "chess_01_right.jpg"]
            }
            _ => anyhow::bail!("{name} has no images; {} have", Self::SHIPPED.join(", ")),
        };
        let images = Dataset::shipped().join("images");
        let set = Dataset::load(&Dataset::shipped().join(name))?;
        let [left, right] = [Grey::read(&images.join(left))?, Grey::read(&images.join(right))?];
        let cameras = set.cameras::<f64>()?;
        let rotation = TurnedView::Top.rotation(degrees);
        let depth = || -> Result<Depth> {
            let [l, r] = [&cameras.left, &cameras.right].map(|c| c.intrinsics().principal[0]);
            let disparities = Grey::read(&images.join("motorcycle_disparity_quarter_px.png"))?;
            Ok(Depth { disparities, camera: cameras.left, offset: r - l, rotation })
        };
        Ok(Self {
            left: turned(&left, &cameras.left, &rotation),
            right,
            depth: (name == "motorcycle_sift").then(depth).transpose()?,
            set: TurnedView::Top.turn(&set, degrees)?,
            pair: 0,
        })
    }

    /// The true disparity of a pixel of the rectified left image under a rectification, px; `None` if the depth is
    /// unknown.
    #[must_use]
    pub fn true_disparity(
        &self,
        rotations: &RectifyingRotations<f64>,
        target: &RectifiedCamera<f64>,
        pixel: [f64; 2],
    ) -> Option<f64> {
        let depth = self.depth.as_ref()?;
        let p = depth.point(rotations.left().inverse() * ray_of(target, pixel))?;
        let in_rectified = rotations.left() * p;
        Some(target.focal / in_rectified.z)
    }

    /// Whether the depth of the scene is published.
    #[must_use]
    pub fn has_depth(&self) -> bool {
        self.depth.is_some()
    }

    /// The matches of the pair.
    ///
    /// # Errors
    /// If the set has no such pair.
    pub fn matches(&self) -> Result<&[rigs::data::Match]> {
        let pair = self.set.pairs.get(self.pair).context("the set has no such pair")?;
        Ok(pair)
    }
}

impl Depth {
    /// The point on a ray of the turned left camera, in its frame, baselines.
    fn point(&self, ray: Vector3<f64>) -> Option<Vector3<f64>> {
        let ray = self.rotation.transpose() * ray;
        let [u, v] = projected(&self.camera, ray)?;
        let disparity = self.disparities.sample([u.round(), v.round()]).filter(|&d| d > 0.0)?;
        let [focal, _] = self.camera.intrinsics().focal;
        let z = focal / (disparity / STEPS_PER_PX + self.offset);
        Some(self.rotation * ray * (z / ray.z))
    }
}
