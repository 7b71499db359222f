//! One pair rectified by different extrinsics, and the disparities that a dense matcher then finds.

use crate::rivals::{Bundle, Front, Setting, Tuning, Variant};
use anyhow::{Context, Result};
use images::pictures::{Rectification, StereoImages, share};
use rayon::prelude::*;
use rigs::data::{Match, Rays};
use sim::run::replay;
use stereo_selfcal::{Cameras, Config, Extrinsics};

use super::scene::PicturedScene;

/// Least difference of a wrong disparity from the published one, px.
pub const WRONG_PX: f64 = 2.0;

/// Largest range of disparities searched, px.
const MOST_RANGE: u16 = 192;

/// Result of one set of extrinsics.
#[derive(Debug, Clone)]
pub struct Attempt {
    /// Name of the extrinsics.
    pub name: &'static str,
    /// The rectified pair with its scores, or the reason for its absence.
    pub outcome: Result<(Rectification, Scores), String>,
}

/// Scores of a rectification.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scores {
    /// Share of the left pixels whose disparity from the left image agrees with that from the right.
    pub valid: f64,
    /// Share of the left pixels of known depth whose disparity is found and within [`WRONG_PX`].
    pub right: Option<f64>,
    /// Median row offset of the matches that are in row under the robust preset's extrinsics, px.
    pub row_offset_px: f64,
}

/// The start and the estimates of bundle adjustment, of the paper preset and of the robust preset over all pairs of the
/// scene; each rectifies the images.
///
/// Each chooses a camera in which both cameras see every rectified pixel (alpha 0). The matches shown and measured are
/// those that the robust preset keeps within [`SCREEN_PX`](sim::run::SCREEN_PX).
///
/// # Errors
/// If the robust preset gives no estimate to measure with, no match is in row under it, or the scene's cameras are not
/// valid.
pub fn comparison(scene: &PicturedScene) -> Result<Vec<Attempt>> {
    let start = Extrinsics::SIDE_BY_SIDE;
    let ours = calibrated(scene, Config::robust())?;
    let images = StereoImages {
        images: [scene.left.clone(), scene.right.clone()],
        cameras: scene.set.cameras()?,
        matches: scene.matches()?.to_vec(),
        scale: 1.0,
    };
    let kept = images.in_row(&ours);
    let range = images.range(&ours, &kept, MOST_RANGE).context("no match is in row")?;
    let all = [
        ("start", Ok(start)),
        ("bundle: noise estimated", bundle(scene, &images.cameras, start)),
        ("ours: paper", calibrated(scene, Config::paper())),
        ("ours: robust", Ok(ours)),
    ];
    let attempt = |(name, extrinsics): (&'static str, Result<Extrinsics<f64>>)| {
        let rectified = |extrinsics| -> Result<_> {
            let one = images.rectification(&extrinsics, &kept, range)?;
            let median = images.median_px(&extrinsics, &kept).context("no match is in row")?;
            let scores = Scores {
                valid: one.found(),
                right: right_share(scene, &one),
                row_offset_px: median,
            };
            Ok((one, scores))
        };
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

/// Bundle adjustment with estimated noise: the best rival on the recordings, if each has one setting for all of them.
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

fn right_share(scene: &PicturedScene, one: &Rectification) -> Option<f64> {
    if !scene.has_depth() {
        return None;
    }
    let [width, height] = one.disparities.size;
    let places = (0..height).flat_map(|v| (0..width).map(move |u| [u, v].map(f64::from)));
    let known = places.zip(&one.disparities.pixels).filter_map(|(pixel, found)| {
        Some((scene.true_disparity(&one.rotations, &one.camera, pixel)?, *found))
    });
    let right =
        |(truth, found): (f64, Option<f64>)| found.is_some_and(|d| (d - truth).abs() <= WRONG_PX);
    let all: Vec<bool> = known.map(right).collect();
    Some(share(all.iter().filter(|&&right| right).count(), all.len()))
}
