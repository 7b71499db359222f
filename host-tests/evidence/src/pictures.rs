//! The picture of the README: a real pair whose left camera is knocked, before and after calibration.

use anyhow::{Context, Result};
use nalgebra::{Matrix3, Vector3};
use rigs::data::{Dataset, TurnedView};
use sim::run::{Start, replay};
use stereo_selfcal::geometry::{RectifiedCamera, RectifyingRotations};
use stereo_selfcal::{Camera, Config, Extrinsics};

use images::pictures::{
    Grey, Rectification, StereoImages, before_and_after, projected, ray_of, share, turned,
};

/// Turn of the left camera in the README, degrees.
pub const KNOCKED: f64 = 1.0;

/// Least difference of a wrong disparity from the published one, px.
pub const WRONG_PX: f64 = 2.0;

/// Disparity steps a pixel in the published file.
const STEPS_PER_PX: f64 = 4.0;

/// Largest range of disparities searched, px.
const MOST_RANGE: u16 = 192;

/// A rectification of the pair.
#[derive(Debug, Clone)]
pub struct Rectified {
    /// The rectified pair and its disparities.
    pub rectification: Rectification,
    /// Share of the left pixels whose disparity from the left image agrees with that from the right.
    pub valid: f64,
    /// Share of the left pixels of known depth whose disparity is found and within [`WRONG_PX`].
    pub right: f64,
    /// Median row offset of the matches that are in row under the estimate, px.
    pub row_offset_px: f64,
}

/// The pair before and after calibration.
#[derive(Debug, Clone)]
pub struct Knocked {
    /// With the extrinsics of before the knock, and with the estimate of the robust preset.
    pub rectified: [Rectified; 2],
    /// Two rows of left image, right image and disparities, JPEG.
    pub jpeg: Vec<u8>,
}

/// The motorcycle, its published depth, and its left camera turned up.
#[derive(Debug, Clone)]
pub struct Motorcycle {
    /// The pair; the left view is turned.
    pub set: Dataset,
    /// The left image, turned like the points, and the right one.
    pub images: [Grey; 2],
    depth: Depth,
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

/// The motorcycle, whose left camera is turned up by so many degrees, before and after calibration.
///
/// The matches shown and measured are those that the estimate keeps within [`SCREEN_PX`](sim::run::SCREEN_PX).
///
/// # Errors
/// If a shipped file is damaged, or the pair has no estimate.
pub fn knocked(degrees: f64) -> Result<Knocked> {
    let scene = Motorcycle::turned(degrees)?;
    let start = Extrinsics::<f32>::SIDE_BY_SIDE;
    let log = replay(&scene.set, Config::robust(), Start::Calibration(start), |_| ())?;
    let found = log.fused().context("the pair could not be fused")?.extrinsics;
    let images = StereoImages {
        images: scene.images.clone(),
        cameras: scene.set.cameras()?,
        matches: scene.set.pairs.first().context("the set has a pair")?.clone(),
        scale: 1.0,
    };
    let kept = images.in_row(&found);
    let range = images.range(&found, &kept, MOST_RANGE).context("no match is in row")?;
    let rectified = |extrinsics: &Extrinsics<f64>| -> Result<Rectified> {
        let rectification = images.rectification(extrinsics, &kept, range)?;
        let row_offset_px = images.median_px(extrinsics, &kept).context("no match is in row")?;
        let [valid, right] = [rectification.found(), scene.right_share(&rectification)];
        Ok(Rectified { rectification, valid, right, row_offset_px })
    };
    let rectified = [rectified(&Extrinsics::SIDE_BY_SIDE)?, rectified(&found)?];
    let jpeg = before_and_after(rectified.each_ref().map(|one| &one.rectification))?;
    Ok(Knocked { rectified, jpeg })
}

impl Motorcycle {
    /// The scene with its left view turned up by so many degrees.
    ///
    /// # Errors
    /// If its files are damaged.
    pub fn turned(degrees: f64) -> Result<Self> {
        let images = Dataset::shipped().join("images");
        let set = Dataset::load(&Dataset::shipped().join("motorcycle_sift"))?;
        let read = |name: &str| Grey::read(&images.join(name));
        let cameras = set.cameras::<f64>()?;
        let [l, r] = [&cameras.left, &cameras.right].map(|c| c.intrinsics().principal[0]);
        let rotation = TurnedView::Top.rotation(degrees);
        let left = turned(&read("motorcycle_left.jpg")?, &cameras.left, &rotation);
        let disparities = read("motorcycle_disparity_quarter_px.png")?;
        let depth = Depth { disparities, camera: cameras.left, offset: r - l, rotation };
        let images = [left, read("motorcycle_right.jpg")?];
        Ok(Self { set: TurnedView::Top.turn(&set, degrees)?, images, depth })
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
        let p = self.depth.point(rotations.left().inverse() * ray_of(target, pixel))?;
        Some(target.focal / (rotations.left() * p).z)
    }

    fn right_share(&self, one: &Rectification) -> f64 {
        let [width, height] = one.disparities.size;
        let places = (0..height).flat_map(|v| (0..width).map(move |u| [u, v].map(f64::from)));
        let known = places.zip(&one.disparities.pixels).filter_map(|(pixel, found)| {
            let truth = self.true_disparity(&one.rotations, &one.camera, pixel)?;
            Some(found.is_some_and(|d| (d - truth).abs() <= WRONG_PX))
        });
        let all: Vec<bool> = known.collect();
        share(all.iter().filter(|&&right| right).count(), all.len())
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
