//! Calibrations of rectified data sets: KITTI's `calib.txt` and Middlebury's.
//!
//! Both are rectified: `R = I`, `t = (-1, 0, 0)`. KITTI: `P1[0][3] = -fx b`, metres. Middlebury: `cam0`, `cam1` and
//! the baseline in millimetres.

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

use super::Files;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use host_tests::data::Rows;
use host_tests::data::{LensModel, Meta};

const SQUARE: Rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Odometry's `P0` and `P1`, or those of the raw recordings; rows of numbers.
#[derive(Debug, Clone, Deserialize)]
struct Kitti {
    #[serde(rename = "P0", alias = "P_rect_00")]
    left: String,
    #[serde(rename = "P1", alias = "P_rect_01")]
    right: String,
    #[serde(rename = "S_rect_00")]
    size: Option<String>,
}

/// `name=value` a line.
#[derive(Debug, Clone, Deserialize)]
struct Middlebury {
    cam0: String,
    cam1: String,
    baseline: Option<f64>,
    width: Option<u16>,
    height: Option<u16>,
}

fn one<T: Clone>(files: &Files, all: &[(String, T)]) -> Result<T> {
    ensure!(all.len() == 1, "{files}: one calibration is expected, not {}", all.len());
    Ok(all[0].1.clone())
}

fn numbers<const N: usize>(text: &str) -> Result<[f64; N]> {
    let text = text.replace(['[', ']', ';', ','], " ");
    let all: Vec<f64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>()?;
    all.try_into()
        .map_err(|all: Vec<f64>| anyhow::anyhow!("{N} numbers are expected, not {}", all.len()))
}

fn size_of(files: &Files, own: Option<[u16; 2]>, unknowns: Unknowns) -> Result<[u16; 2]> {
    let size = unknowns.size.or(own);
    size.with_context(|| format!("{files}: no size of the images: give it (--size W,H)"))
}

fn view(k: [f64; 4], size: [u16; 2]) -> View {
    let dist = vec![0.0; 5];
    View { k: camera_matrix(k), lens: LensModel::RadialTangential, dist, size }
}

/// The rig of KITTI's cameras 0 (left) and 1, grey.
pub(super) fn kitti(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let read: Kitti = one(files, &files.parsed()?)?;
    let own = read.size.as_deref().map(numbers::<2>).transpose()?;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "sizes of images")]
    let size = size_of(files, own.map(|size| size.map(|n| n as u16)), unknowns)?;
    let p =
        |name: &str, text: &str| numbers::<12>(text).with_context(|| format!("{files}: {name}"));
    let [left, right] = [p("P0", &read.left)?, p("P1", &read.right)?];
    let shift = right[3] / right[0] - left[3] / left[0];
    let pose = Pose::of(SQUARE, [shift, 0.0, 0.0])?;
    let views = [left, right].map(|p| view([p[0], p[5], p[2], p[6]], size));
    rig::meta(views, &pose, format!("KITTI: {files}"))
}

/// The rig of a Middlebury pair.
pub(super) fn middlebury(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let read: Middlebury = one(files, &files.parsed()?)?;
    let size = size_of(files, read.width.zip(read.height).map(Into::into), unknowns)?;
    let k = |name: &str, text: &str| numbers::<9>(text).with_context(|| format!("{files}: {name}"));
    let [left, right] = [k("cam0", &read.cam0)?, k("cam1", &read.cam1)?];
    let baseline_m = read.baseline.filter(|b| *b > 0.0).map(|mm| mm / 1000.0);
    let pose = Pose { r: SQUARE, t: [-1.0, 0.0, 0.0], baseline_m };
    let views = [left, right].map(|k| view([k[0], k[4], k[2], k[5]], size));
    rig::meta(views, &pose, format!("Middlebury: {files}"))
}
