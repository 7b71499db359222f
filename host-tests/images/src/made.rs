//! Synthetic pairs with exact truth: a shipped image, and the view that a second camera would have of a scene of
//! planes.
//!
//! The left image is cut into tiles. Each tile lies on a slanted plane at a depth of its own. A pixel of the right
//! image shows the nearest tile that it sees, through the homography of the plane of this tile, or mid grey if it sees
//! none. Both images get noise.

use std::io::BufWriter;
use std::path::Path;

use anyhow::{Context, Result};
use host_tests::data::{Dataset, Meta};
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use rayon::prelude::*;
use stereo_selfcal::geometry::so3;

use crate::picture::Picture;
use crate::shipped::ShippedImages;

/// Number of scenes of each of the shipped images.
pub const SCENES: u64 = 4;

/// Numbers of columns and rows of tiles.
const TILES: [usize; 2] = [6, 5];

/// Standard deviation of the turn of `R` about each axis, and of the y and z components of `t` (down, forward), rad.
const TURN: f64 = 0.02;

/// Range of disparities in the middle of the tiles, in widths of the image.
const DISPARITY: [f64; 2] = [0.02, 0.1];

/// Standard deviation of the tangent of a plane's slant, across and down.
const SLANT: [f64; 2] = [0.6, 0.4];

/// Range of focal lengths, in widths of the image.
const FOCAL: [f64; 2] = [0.8, 1.4];

/// Standard deviation of the noise of the grey values.
const NOISE: f64 = 2.0;

/// A pair whose rig is known exactly.
#[derive(Debug)]
pub struct MadePair {
    /// Name of the image, and number of the scene.
    pub name: String,
    /// Left and right.
    pub pictures: [Picture; 2],
    /// Cameras and true rig.
    pub meta: Meta,
}

/// Plane `normal . X = 1` of a tile, in the left camera frame in baselines, and the map from a right pixel back to the
/// left image.
struct Plane {
    normal: Vector3<f64>,
    back: Matrix3<f64>,
}

/// Random draws of a scene.
struct Draw(ChaCha8Rng);

impl Draw {
    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.0)
    }

    fn within(&mut self, [low, high]: [f64; 2]) -> Result<f64> {
        Ok(Uniform::new(low, high)?.sample(&mut self.0))
    }
}

impl MadePair {
    /// The pair of a scene.
    ///
    /// * `scene`: number of the scene.
    ///
    /// # Errors
    /// If the shipped files are damaged.
    pub fn new(images: ShippedImages, scene: u64) -> Result<Self> {
        let files = images.files();
        let [left, _] = &files[scene as usize % files.len()];
        let texture = Picture::read(left)?;
        let mut draw = Draw(ChaCha8Rng::seed_from_u64(1000 * images as u64 + scene));
        let meta = rig(images.sift()?.meta, texture.size(), &mut draw)?;
        let planes = planes(&meta, &mut draw)?;
        let size = texture.size().map(usize::from);
        let right = seen(&texture, &planes, &matrix(&meta)?);
        let left = texture.pixels().iter().map(|pixel| f64::from(*pixel)).collect();
        let noisy = |values: Vec<f64>, draw: &mut Draw| {
            let grey = |x: f64| (x + NOISE * draw.normal()).round().clamp(0.0, 255.0) as u8;
            Picture::try_new(size, values.into_iter().map(grey).collect())
        };
        let pictures = [noisy(left, &mut draw)?, noisy(right, &mut draw)?];
        Ok(Self { name: format!("{}-{scene}", images.name()), pictures, meta })
    }

    /// Saves images and rig into a folder of their name; an older one is replaced.
    ///
    /// # Errors
    /// If a file cannot be written.
    pub fn save(&self, top: &Path) -> Result<()> {
        let dir = top.join(&self.name);
        std::fs::create_dir_all(&dir).with_context(|| format!("cannot write {}", dir.display()))?;
        for (picture, side) in self.pictures.iter().zip(["left", "right"]) {
            let [width, height] = picture.size().map(u32::from);
            let path = dir.join(format!("{side}.png"));
            let file = std::fs::File::create(&path);
            let file = file.with_context(|| format!("cannot write {}", path.display()))?;
            PngEncoder::new(BufWriter::new(file))
                .write_image(picture.pixels(), width, height, ExtendedColorType::L8)
                .with_context(|| format!("cannot write {}", path.display()))?;
        }
        let path = dir.join("meta.json");
        let mut meta = serde_json::to_value(&self.meta)?;
        meta["notes"] = "made: tiles of a shipped image on slanted planes".into();
        std::fs::write(&path, meta.to_string())
            .with_context(|| format!("cannot write {}", path.display()))
    }

    /// SIFT matches in the saved images, if `make_pairs.py` has written them.
    ///
    /// # Errors
    /// If they are damaged.
    pub fn sift(&self, top: &Path) -> Result<Option<Dataset>> {
        let dir = top.join(&self.name).join("sift");
        dir.exists().then(|| Dataset::load(&dir)).transpose()
    }
}

/// The rig of the shipped images with random pinholes, turn and baseline direction.
fn rig(mut meta: Meta, [width, height]: [u16; 2], draw: &mut Draw) -> Result<Meta> {
    let focal = f64::from(width) * draw.within(FOCAL)?;
    let [cx, cy] = [width, height].map(|n| f64::from(n) / 2.0 - 0.5);
    let k = [[focal, 0.0, cx], [0.0, focal, cy], [0.0, 0.0, 1.0]];
    let turn = Vector3::from_fn(|_, _| TURN * draw.normal());
    let turn = so3::exp(&turn).context("a turn")?;
    let t = Vector3::new(-1.0, TURN * draw.normal(), TURN * draw.normal()).normalize();
    (meta.k_l, meta.k_r) = (k, k);
    (meta.dist_l, meta.dist_r) = (vec![0.0; 5], vec![0.0; 5]);
    (meta.width, meta.height) = (width, height);
    meta.r = [0, 1, 2].map(|i| [0, 1, 2].map(|j| turn.matrix()[(i, j)]));
    meta.t = t.into();
    // Runs start from a side-by-side rig. It is a guess, and no calibration of rectified images.
    meta.other.insert(Meta::FACTORY_YAW_SD.into(), serde_json::Value::Null);
    Ok(meta)
}

/// Inverse of the camera matrix.
fn matrix(meta: &Meta) -> Result<Matrix3<f64>> {
    let k = Matrix3::from_fn(|i, j| meta.k_l[i][j]);
    k.try_inverse().context("the camera matrix")
}

fn planes(meta: &Meta, draw: &mut Draw) -> Result<Vec<Plane>> {
    let k = Matrix3::from_fn(|i, j| meta.k_l[i][j]);
    let rays = matrix(meta)?;
    let r = Matrix3::from_fn(|i, j| meta.r[i][j]);
    let [columns, rows] = TILES;
    let (width, height) = (f64::from(meta.width), f64::from(meta.height));
    let plane = |i: usize| {
        let [u, v] = [(i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5];
        let middle = rays * Vector3::new(u * width / columns as f64, v * height / rows as f64, 1.0);
        let depth = k[(0, 0)] / (width * draw.within(DISPARITY)?);
        let [across, down] = SLANT.map(|sd| sd * draw.normal().clamp(-1.5, 1.5));
        let normal = Vector3::new(across, down, 1.0);
        let normal = normal / (normal.dot(&middle) * depth);
        let to_right = k * (r + Vector3::from(meta.t) * normal.transpose()) * rays;
        Ok(Plane { normal, back: to_right.try_inverse().context("a plane through the camera")? })
    };
    (0..columns * rows).map(plane).collect()
}

/// The right image; mid grey where it shows no plane.
///
/// * `rays`: inverse of the camera matrix.
fn seen(texture: &Picture, planes: &[Plane], rays: &Matrix3<f64>) -> Vec<f64> {
    let [width, height] = texture.size().map(f64::from);
    let [columns, rows] = TILES;
    let nearest = |u: f64, v: f64| {
        let mut best = (0.0, 128.0);
        for (i, plane) in planes.iter().enumerate() {
            let p = plane.back * Vector3::new(u, v, 1.0);
            let [x, y] = [p.x / p.z, p.y / p.z];
            let inside = p.z > 0.0 && (0.0..width).contains(&x) && (0.0..height).contains(&y);
            let tile = |x: f64, length: f64, count: usize| (x / length * count as f64) as usize;
            if !inside || tile(x, width, columns) + columns * tile(y, height, rows) != i {
                continue;
            }
            let nearness = plane.normal.dot(&(rays * Vector3::new(x, y, 1.0)));
            if nearness > best.0
                && let Some(value) = cubic(texture, [x, y])
            {
                best = (nearness, value);
            }
        }
        best.1
    };
    let line = |v: u16| (0..texture.size()[0]).map(move |u| nearest(u.into(), v.into()));
    let lines: Vec<Vec<f64>> =
        (0..texture.size()[1]).into_par_iter().map(|v| line(v).collect()).collect();
    lines.concat()
}

/// Cubic interpolation (Catmull and Rom); `None` at the border. Bilinear interpolation would blur more in the middle
/// between pixels than near them.
fn cubic(picture: &Picture, [u, v]: [f64; 2]) -> Option<f64> {
    let [width, height] = picture.size().map(usize::from);
    let [left, top] = [u, v].map(|x| (x.floor() as usize).checked_sub(1));
    let (left, top) = (left?, top?);
    if left + 4 > width || top + 4 > height {
        return None;
    }
    let weights = |t: f64| {
        let (t2, t3) = (t * t, t * t * t);
        [-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2]
            .map(|weight| weight / 2.0)
    };
    let (across, down) = (weights(u.fract()), weights(v.fract()));
    let row = |y: usize| -> f64 {
        let at = (top + y) * width + left;
        let four = across.iter().zip(&picture.pixels()[at..at + 4]);
        four.map(|(weight, pixel)| weight * f64::from(*pixel)).sum()
    };
    Some(down.iter().enumerate().map(|(y, weight)| weight * row(y)).sum())
}
