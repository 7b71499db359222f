//! Error of depth: measured where true depths are known, and expected from the calibrator's estimate.

use anyhow::{Context, Result};
use nalgebra::Vector3;
use serde::Serialize;
use stereo_selfcal::geometry::{LensCorrection, RectifyingRotations};
use stereo_selfcal::{Calibration, Extrinsics, State};

use super::log::RunLog;
use super::summary::SCREEN_PX;
use rigs::data::depths::TrueDepth;
use rigs::data::{Dataset, Match};

/// Largest errors of a correct match, px of disparity and of rows, with the reference. Without a reference, the errors
/// are with the extrinsics of the start. A match with a larger error does not count.
const WRONG_PX: [f64; 2] = [6.0, 3.0];

/// A match counts as behind infinity if its disparity is minus this or less, px. Noise alone may make the disparity of
/// a far match slightly negative.
const BEHIND_PX: f64 = 1.0;

/// Depths at which errors are given, m.
pub const DEPTHS_M: [f64; 2] = [10.0, 30.0];

/// Error of depth that the calibrator's last estimate predicts for other extrinsics: root of the sum of the squared
/// distance of their yaw from the estimate and the variance of the estimated yaw, with the lens uncertain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ExpectedDepth {
    /// With the extrinsics of the start, px of disparity.
    pub before_px: f64,
    /// With the extrinsics in use after the last pair, px of disparity.
    pub in_use_px: f64,
    /// With the estimate, px of disparity.
    pub estimate_px: f64,
    /// `before_px` at [`DEPTHS_M`], m; `None` if the length of the baseline is unknown.
    pub before_m: Option<[f64; 2]>,
    /// `in_use_px` at [`DEPTHS_M`], m; `None` if the length of the baseline is unknown.
    pub in_use_m: Option<[f64; 2]>,
}

impl ExpectedDepth {
    /// The prediction after the last pair; `None` unless the calibrator is locked then.
    pub(super) fn of(set: &Dataset, log: &RunLog) -> Result<Option<Self>> {
        let Some(fused) = log.fused().filter(|fused| fused.state == State::Locked) else {
            return Ok(None);
        };
        let estimate = RectifyingRotations::from(&fused.extrinsics);
        let error = |of: &Extrinsics<f64>| {
            estimate.unknowns_to(&RectifyingRotations::from(of)).y.hypot(fused.yaw_sd)
        };
        let in_use = log.steps().last().and_then(|step| step.checked).map(|used| used.in_use);
        let focal = set.cameras::<f64>()?.mean_focal();
        let [before_px, in_use_px] =
            [*log.factory(), in_use.unwrap_or(*log.factory())].map(|of| error(&of) * focal);
        let [before_m, in_use_m] = [before_px, in_use_px].map(|px| metres(set, px)).map(Result::ok);
        let estimate_px = fused.yaw_sd * focal;
        Ok(Some(Self { before_px, in_use_px, estimate_px, before_m, in_use_m }))
    }
}

/// An error of disparity, px, converted to an error of depth at [`DEPTHS_M`], m, by the factor `Z^2 / (f b)`.
///
/// # Errors
/// If the length of the baseline is not known, or the cameras are not valid.
pub fn metres(set: &Dataset, px: f64) -> Result<[f64; 2]> {
    let baseline_m = set.meta.baseline_m.context("no baseline_m in meta.json")?;
    let focal = set.cameras::<f64>()?.mean_focal();
    Ok(DEPTHS_M.map(|z| z * z * px / (focal * baseline_m)))
}

/// Median of `|1/Z - 1/Z_true| f b` over the correct matches of known depth, px of disparity.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DepthErrors {
    /// With the extrinsics of the start.
    pub before_px: f64,
    /// With the extrinsics in use after the last pair.
    pub in_use_px: f64,
    /// With the reference of the data set, if there is one.
    pub reference_px: Option<f64>,
    /// Number of matches in the medians.
    pub matches: usize,
}

impl DepthErrors {
    /// The medians over the pairs with the same rig as the last pair. `None` without correct matches of known depth.
    ///
    /// * `truth`: true depths of the matches of each pair.
    ///
    /// # Errors
    /// If the length of the baseline is not known, or the cameras are not valid.
    pub fn of(set: &Dataset, truth: &[Vec<TrueDepth>], log: &RunLog) -> Result<Option<Self>> {
        let baseline_m = set.meta.baseline_m.context("depths without baseline_m in meta.json")?;
        let before = set.meta.calibration(log.factory(), &LensCorrection::NONE)?;
        let in_use = calibration_in_use(set, log)?;
        let reference = set.meta.has_reference().then(|| set.truth()).transpose()?;
        let reference = reference
            .map(|truth| set.meta.calibration(&truth, &LensCorrection::NONE))
            .transpose()?;
        let moved = |pair: usize| set.rigs.get(pair) != set.rigs.last();
        let mut errors = [const { Vec::new() }; 3];
        for (i, (pair, depths)) in set.pairs.iter().zip(truth).enumerate() {
            if moved(i) {
                continue;
            }
            for depth in depths {
                let Some(m) = pair.get(depth.row) else { continue };
                let error = |of: &Calibration<f64>| error_px(of, m, depth.depth_m, baseline_m);
                let judge = error(&reference.unwrap_or(before));
                let is_right =
                    |[px, row]: [f64; 2]| px.abs() <= WRONG_PX[0] && row.abs() <= WRONG_PX[1];
                if !judge.is_some_and(is_right) {
                    continue;
                }
                let of = [Some(before), Some(in_use), reference];
                for (all, of) in errors.iter_mut().zip(of) {
                    all.extend(of.and_then(|of| error(&of)).map(|[px, _]| px.abs()));
                }
            }
        }
        let matches = errors[0].len();
        let [before_px, in_use_px, reference_px] = errors.map(median);
        Ok(before_px.zip(in_use_px).map(|(before_px, in_use_px)| Self {
            before_px,
            in_use_px,
            reference_px,
            matches,
        }))
    }
}

/// Share of the matches within [`SCREEN_PX`] of their row that are behind infinity, with the calibration in use after
/// the last pair. `None` without matches in row.
pub(super) fn behind_infinity(set: &Dataset, log: &RunLog) -> Result<Option<f64>> {
    let in_use = calibration_in_use(set, log)?;
    let focal = in_use.cameras.mean_focal();
    let mut counts = [0_u32; 2];
    for [disparity, row, _] in set.pairs.iter().flatten().filter_map(|m| offsets(&in_use, m)) {
        let in_row = row.abs() * focal <= SCREEN_PX;
        let behind = disparity * focal <= -BEHIND_PX;
        counts[0] += u32::from(in_row);
        counts[1] += u32::from(in_row && behind);
    }
    let [in_row, behind] = counts.map(f64::from);
    Ok((in_row > 0.0).then(|| behind / in_row))
}

/// The calibration in use after the last pair; the start of the run if the run has not recorded it.
pub(super) fn calibration_in_use(set: &Dataset, log: &RunLog) -> Result<Calibration<f64>> {
    match log.steps().last().and_then(|step| step.checked) {
        Some(used) => set.meta.calibration(&used.in_use, &used.correction),
        None => set.meta.calibration(log.factory(), &LensCorrection::NONE),
    }
}

/// Errors of disparity and of row of a match at a known depth, px; `None` if a pixel has no ray.
fn error_px(of: &Calibration<f64>, m: &Match, depth_m: f64, baseline_m: f64) -> Option<[f64; 2]> {
    let [disparity, row, depth] = offsets(of, m)?;
    let focal = of.cameras.mean_focal();
    Some([(disparity * depth - baseline_m / depth_m) * focal, row * focal])
}

/// Disparity and row offset of the rectified rays at unit depth, and the rectified z of the left ray, whose z is 1 in
/// the left camera frame. `None` if a pixel has no ray, or its ray points behind the rectified camera.
pub fn offsets(of: &Calibration<f64>, m: &Match) -> Option<[f64; 3]> {
    let rays = of.cameras.rays(&m.correspondence()).ok()?;
    let rotations = RectifyingRotations::from(&of.extrinsics);
    let ray = |[x, y]: [f64; 2]| Vector3::new(x, y, 1.0);
    let [a, b] = [rotations.left() * ray(rays.left()), rotations.right() * ray(rays.right())];
    let in_front = a.z > 0.0 && b.z > 0.0;
    in_front.then_some([a.x / a.z - b.x / b.z, a.y / a.z - b.y / b.z, a.z])
}

fn median(mut all: Vec<f64>) -> Option<f64> {
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied()
}
