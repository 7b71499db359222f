//! One pair rectified by different extrinsics, and what a dense matcher then finds.

use anyhow::{Context, Result};
use nalgebra::Vector3;
use rayon::prelude::*;
use stereo_selfcal::{
    Cameras, Config, Extrinsics, RayPair, RectifiedCamera, RectifyingRotations, row_offset,
};

use super::grey::Grey;
use super::scene::PicturedScene;
use super::sgm::{Disparities, share};
use super::warp::rectified;
use crate::baselines::{Bundle, Front, Setting, Tuning, Variant};
use crate::data::{Match, Rays};
use crate::run::{SCREEN_PX, replay};

/// A disparity further than this from the published one is wrong, px.
pub const WRONG_PX: f64 = 2.0;

/// Largest range of disparities searched, px.
const MOST_RANGE: u16 = 192;

/// What one set of extrinsics came to.
#[derive(Debug, Clone)]
pub struct Attempt {
    /// Whose extrinsics.
    pub name: &'static str,
    /// The rectified pair, or why there is none.
    pub outcome: Result<Rectification, String>,
}

/// A pair as one set of extrinsics rectifies it.
#[derive(Debug, Clone)]
pub struct Rectification {
    /// Rectified left and right image.
    pub images: [Grey; 2],
    /// Disparities of the left image.
    pub disparities: Disparities,
    /// Range that was searched, px.
    pub range: u16,
    /// Ends of matches that are in row under the robust preset's extrinsics, rectified, px.
    pub matches: Vec<[[f64; 2]; 2]>,
    /// Its numbers.
    pub scores: Scores,
}

/// What a rectification came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    /// Share of the left pixels whose disparity is found alike from left and right.
    pub valid: f64,
    /// Share of the left pixels of known depth whose disparity is found and within [`WRONG_PX`].
    pub right: Option<f64>,
    /// Median row offset of those matches that are in row under the robust preset's, px.
    pub row_offset_px: f64,
}

/// The start, the estimate of bundle adjustment, and those of the presets as published and robust, over all
/// pairs of the scene, each rectifying its images.
///
/// Each chooses a camera in which every rectified pixel is seen by both (alpha 0). The matches shown and
/// measured are those that the robust preset keeps within [`SCREEN_PX`].
///
/// # Errors
/// If there is no estimate of ours to measure with, or the scene's cameras are not valid.
pub fn comparison(scene: &PicturedScene) -> Result<Vec<Attempt>> {
    let start = Extrinsics::SIDE_BY_SIDE;
    let ours = calibrated(scene, Config::robust())?;
    let cameras = scene.set.cameras::<f64>()?;
    let kept = in_row(scene, &cameras, &ours)?;
    let range = range(&cameras, &ours, &kept)?;
    let bundle = bundle(scene, &cameras, start);
    let paper = calibrated(scene, Config::paper());
    let all = [
        ("start", Ok(start)),
        ("bundle: noise estimated", bundle),
        ("ours: paper", paper),
        ("ours: robust", Ok(ours)),
    ];
    let attempt = |(name, extrinsics): (&'static str, Result<Extrinsics<f64>>)| {
        let rectified = |e| rectification(scene, &cameras, &e, &kept, range);
        let outcome = extrinsics.and_then(rectified).map_err(|why| format!("{why:#}"));
        Attempt { name, outcome }
    };
    Ok(all.into_par_iter().map(attempt).collect())
}

fn calibrated(scene: &PicturedScene, config: Config) -> Result<Extrinsics<f64>> {
    let start = Extrinsics::<f32>::SIDE_BY_SIDE;
    let log = replay(&scene.set, config, start, |_| ())?;
    Ok(log.fused().context("no pair of the scene could be fused")?.extrinsics)
}

/// Bundle adjustment with estimated noise: best of all rivals with one setting on the recordings.
fn bundle(
    scene: &PicturedScene,
    cameras: &Cameras<f64>,
    start: Extrinsics<f64>,
) -> Result<Extrinsics<f64>> {
    let rays = |m: &Match| -> Option<Rays> {
        let [l, r] = [cameras.left.ray([m.ul, m.vl]), cameras.right.ray([m.ur, m.vr])];
        Some([l.ok()?.push(1.0), r.ok()?.push(1.0)])
    };
    let pairs: Vec<Vec<Rays>> =
        scene.set.pairs.iter().map(|pair| pair.iter().filter_map(rays).collect()).collect();
    let setting =
        Setting { start, focal: cameras.mean_focal(), noise_px: 0.3, tuning: Tuning::default() };
    let tuning = Tuning { noise_estimated: true, ..setting.tuning };
    let front = Front::new(&pairs, &setting);
    let by = Variant { method: Box::new(Bundle), tuning };
    by.fused(&pairs, &front, &setting).context("bundle adjustment found no estimate")
}

/// The matches of the scene's pair that the extrinsics keep in row.
fn in_row(
    scene: &PicturedScene,
    cameras: &Cameras<f64>,
    extrinsics: &Extrinsics<f64>,
) -> Result<Vec<Match>> {
    let kept =
        |m: &&Match| offset_px(cameras, extrinsics, m).is_some_and(|px| px.abs() <= SCREEN_PX);
    Ok(scene.matches()?.iter().filter(kept).copied().collect())
}

fn offset_px(cameras: &Cameras<f64>, extrinsics: &Extrinsics<f64>, m: &Match) -> Option<f64> {
    let rays: RayPair<f64> = cameras.rays(&m.correspondence()).ok()?;
    let offset = row_offset(&RectifyingRotations::from(extrinsics), &rays)?;
    Some(offset * cameras.mean_focal())
}

/// Wide enough for nineteen in twenty of the matches, and an eighth more, px; a multiple of 16.
fn range(cameras: &Cameras<f64>, extrinsics: &Extrinsics<f64>, kept: &[Match]) -> Result<u16> {
    let rotations = RectifyingRotations::from(extrinsics);
    let target = RectifiedCamera::try_choose(cameras, &rotations, 0.0)?;
    let mut disparities: Vec<f64> =
        ends(cameras, &rotations, &target, kept).map(|[l, r]| l[0] - r[0]).collect();
    disparities.sort_by(f64::total_cmp);
    let high = disparities.get(disparities.len() * 19 / 20).context("no match is in row")?;
    let sixteens = (16..=MOST_RANGE).step_by(16);
    Ok(sixteens.into_iter().find(|&n| f64::from(n) > high * 1.125).unwrap_or(MOST_RANGE))
}

fn rectification(
    scene: &PicturedScene,
    cameras: &Cameras<f64>,
    extrinsics: &Extrinsics<f64>,
    kept: &[Match],
    range: u16,
) -> Result<Rectification> {
    let rotations = RectifyingRotations::from(extrinsics);
    let target = RectifiedCamera::try_choose(cameras, &rotations, 0.0)
        .context("no camera sees what both see after this rectification")?;
    let images = [
        rectified(&scene.left, &cameras.left, rotations.left(), &target),
        rectified(&scene.right, &cameras.right, rotations.right(), &target),
    ];
    let disparities = Disparities::of(&images[0], &images[1], range);
    let mut offsets: Vec<f64> =
        kept.iter().filter_map(|m| offset_px(cameras, extrinsics, m).map(f64::abs)).collect();
    offsets.sort_by(f64::total_cmp);
    let scores = Scores {
        valid: disparities.valid_share(&images[0]),
        right: right_share(scene, &rotations, &target, &disparities),
        row_offset_px: offsets.get(offsets.len() / 2).copied().context("no match is in row")?,
    };
    let matches = ends(cameras, &rotations, &target, kept).collect();
    Ok(Rectification { images, disparities, range, matches, scores })
}

/// Where the ends of matches are in the rectified images, px.
fn ends(
    cameras: &Cameras<f64>,
    rotations: &RectifyingRotations<f64>,
    target: &RectifiedCamera<f64>,
    matches: &[Match],
) -> impl Iterator<Item = [[f64; 2]; 2]> {
    let [cx, cy] = target.principal;
    let pixel = move |p: Vector3<f64>| {
        (p.z > 0.0).then(|| [cx + target.focal * p.x / p.z, cy + target.focal * p.y / p.z])
    };
    matches.iter().filter_map(move |m| {
        let left = cameras.left.ray([m.ul, m.vl]).ok()?.push(1.0);
        let right = cameras.right.ray([m.ur, m.vr]).ok()?.push(1.0);
        Some([pixel(rotations.left() * left)?, pixel(rotations.right() * right)?])
    })
}

fn right_share(
    scene: &PicturedScene,
    rotations: &RectifyingRotations<f64>,
    target: &RectifiedCamera<f64>,
    disparities: &Disparities,
) -> Option<f64> {
    if !scene.has_depth() {
        return None;
    }
    let [width, height] = disparities.size;
    let places = (0..height).flat_map(|v| (0..width).map(move |u| [u, v].map(f64::from)));
    let known = places.zip(&disparities.pixels).filter_map(|(pixel, found)| {
        Some((scene.true_disparity(rotations, target, pixel)?, *found))
    });
    let right =
        |(truth, found): (f64, Option<f64>)| found.is_some_and(|d| (d - truth).abs() <= WRONG_PX);
    let all: Vec<bool> = known.map(right).collect();
    Some(share(all.iter().filter(|&&right| right).count(), all.len()))
}
