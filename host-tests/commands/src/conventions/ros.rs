//! ROS `camera_info` files of a pair, as `camera_calibration` writes them.
//!
//! The extrinsics are in the rectification: `R = R_r^T R_l` and `t` is minus the first row of `R_r`,
//! whatever turn about the baseline the rectified frame has; `P[0][3] = -fx b` of the right camera.

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use super::mat::Mat;
use super::number::list;
use super::rectified::Rectified;
use super::rig::{self, NO_SCALE, Pose, Unknowns, View, square};
use super::{Document, Files};
use host_tests::data::{LensModel, Meta};
use host_tests::data::{Rows, matrix, rows};

/// `camera_info` in YAML; the camera's name is ignored.
#[derive(Debug, Clone, Deserialize)]
struct CameraInfo {
    image_width: u16,
    image_height: u16,
    camera_matrix: Mat,
    distortion_model: String,
    distortion_coefficients: Mat,
    rectification_matrix: Mat,
    projection_matrix: Mat,
}

/// Left and right, told by the right one's `P[0][3] < 0`.
fn pair(files: &Files) -> Result<[(String, CameraInfo); 2]> {
    let infos: Vec<(String, CameraInfo)> = files.parsed()?;
    let both: [(String, CameraInfo); 2] = infos.try_into().map_err(|all: Vec<_>| {
        anyhow::anyhow!("{files}: two files are expected, left and right, not {}", all.len())
    })?;
    let [(_, a), (_, b)] = &both;
    let shifts = [a, b].map(|info| info.projection_matrix.data.get(3).copied());
    match shifts {
        [Some(l), Some(r)] if l == 0.0 && r < 0.0 => Ok(both),
        [Some(r), Some(l)] if l == 0.0 && r < 0.0 => {
            let [right, left] = both;
            Ok([left, right])
        }
        _ => bail!(
            "{files}: projection_matrix: P[0][3] must be 0 of the left camera and -fx b of the right one, not {shifts:?}"
        ),
    }
}

/// `R` and `t` of the rectification matrices.
pub(super) fn pose(files: &Files) -> Result<Pose> {
    let [(left_name, left), (right_name, right)] = pair(files)?;
    let rotation = |name: &str, info: &CameraInfo| -> Result<Rows> {
        let read = info.rectification_matrix.shaped([3, 3]).and_then(square);
        read.with_context(|| format!("{name}: rectification_matrix"))
    };
    let [r_l, r_r] = [rotation(&left_name, &left)?, rotation(&right_name, &right)?];
    let p = right.projection_matrix.shaped([3, 4]);
    let p = p.with_context(|| format!("{right_name}: projection_matrix"))?;
    ensure!(p[0] > 0.0, "{right_name}: projection_matrix: fx must be above 0");
    let r = matrix(&r_r).transpose() * matrix(&r_l);
    let (t, _) = super::scale::split(r_r[0].map(|x| -x))?;
    let baseline = -p[3] / p[0];
    // The length is that of P: the row is of unit length.
    let pose = Pose { r: rows(&r), t, baseline_m: super::scale::known(baseline) };
    pose.extrinsics().with_context(|| format!("rectification matrices of {files}"))?;
    Ok(pose)
}

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    ensure!(
        unknowns == Unknowns::default(),
        "{files}: camera_info has the size of its images, and is in metres"
    );
    let [left, right] = pair(files)?;
    let view = |(name, info): &(String, CameraInfo)| view(info).with_context(|| name.clone());
    rig::meta([view(&left)?, view(&right)?], &pose(files)?, format!("ROS: {files}"))
        .with_context(|| format!("the rig of {files}"))
}

fn view(info: &CameraInfo) -> Result<View> {
    let lens = match info.distortion_model.as_str() {
        // Five or eight coefficients tell the two.
        "plumb_bob" | "rational_polynomial" => LensModel::RadialTangential,
        "equidistant" | "fisheye" => LensModel::Fisheye,
        other => bail!(
            "distortion_model {other}: plumb_bob, rational_polynomial and equidistant are handled"
        ),
    };
    let given = info.distortion_coefficients.numbers();
    let k = info.camera_matrix.shaped([3, 3]).and_then(square).context("camera_matrix")?;
    let size = [info.image_width, info.image_height];
    given.and_then(|given| View::of(k, lens, given, size)).context("distortion_coefficients")
}

/// `left.yaml` and `right.yaml`.
pub(super) fn write(meta: &Meta) -> Result<Vec<Document>> {
    let Rectified { rotations: [r_l, r_r], projections: [p_l, p_r], .. } = Rectified::of(meta)?;
    let left = camera_info("left", meta, &meta.k_l, &meta.dist_l, &r_l, &p_l);
    let right = camera_info("right", meta, &meta.k_r, &meta.dist_r, &r_r, &p_r);
    let left = rig::lens_yaw_comment(meta) + &left;
    Ok(vec![
        Document { name: "left.yaml", text: left },
        Document { name: "right.yaml", text: right },
    ])
}

fn camera_info(name: &str, meta: &Meta, k: &Rows, dist: &[f64], r: &Rows, p: &[f64; 12]) -> String {
    let model = match meta.lens {
        LensModel::RadialTangential => "plumb_bob",
        LensModel::Fisheye => "equidistant",
        LensModel::Rational => "rational_polynomial",
    };
    let mut five = dist.to_vec();
    if meta.lens == LensModel::RadialTangential {
        five.resize(5, 0.0);
    }
    let comment = if meta.baseline_m.is_none() { NO_SCALE } else { "" };
    let mat = |name: &str, cols: usize, numbers: &[f64]| {
        let rows = numbers.len() / cols;
        format!("{name}:\n  rows: {rows}\n  cols: {cols}\n  data: [{}]\n", list(numbers))
    };
    [
        format!("{comment}image_width: {}\nimage_height: {}\n", meta.width, meta.height),
        format!("camera_name: {name}\n"),
        mat("camera_matrix", 3, &k.concat()),
        format!("distortion_model: {model}\n"),
        mat("distortion_coefficients", five.len(), &five),
        mat("rectification_matrix", 3, &r.concat()),
        mat("projection_matrix", 4, p),
    ]
    .concat()
}
