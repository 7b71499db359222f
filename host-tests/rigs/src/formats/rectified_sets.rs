//! Calibrations of rectified data sets: KITTI, Middlebury, Cityscapes.
//!
//! All are rectified: `R = I`. KITTI: `P = K [I | c]`, so a camera sees points moved by `K^-1` times the last column,
//! metres; the cameras 2 and 3 are a little off a common row. Middlebury: `cam0`, `cam1` and the baseline in
//! millimetres, `t = (-1, 0, 0)`. Cityscapes: one camera for both sides, and the baseline in metres.

use anyhow::{Context, Result};
use nalgebra::{Matrix3, Vector3};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{Meta, Rows, check_camera_matrix, matrix};

/// The rig of KITTI's grey cameras 0 (left) and 1, or of the chosen ones: 2 and 3 are the colour cameras.
pub(super) fn kitti(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let is_numbered_from_101 = files.get(&["P_rect_101"]).is_some();
    let cameras = unknowns.cameras_or(if is_numbered_from_101 { [101, 103] } else { [0, 1] });
    let mut views = Vec::new();
    let mut moved = Vec::new();
    for (side, n) in cameras.into_iter().enumerate() {
        let p = files.find(&[&format!("P{n}"), &format!("P_rect_{n:02}")], "12 numbers")?;
        let [a, b, c, x, d, e, f, y, g, h, i, z] = p.array::<12>("a projection matrix")?;
        let k = [[a, b, c], [d, e, f], [g, h, i]];
        check_camera_matrix(&k).map_err(|why| p.refuse(why))?;
        let own = files.get(&[&format!("S_rect_{n:02}")]).map(|size| size.size()).transpose()?;
        let size = unknowns.size(side, own, p.place())?;
        let back = matrix(&k).try_inverse().with_context(|| p.place().to_owned())?;
        moved.push(back * Vector3::new(x, y, z));
        views.push(View::pinhole(k, size));
    }
    let [left, right] = cameras;
    let t = moved[1] - moved[0];
    let pose =
        Pose::of(&Rigid { r: Matrix3::identity(), t }, &format!("{files}: P{left} and P{right}"))?;
    let views: [View; 2] = views.try_into().ok().context("two cameras")?;
    rig::meta(views, &pose, format!("KITTI, cameras {left} and {right}: {files}"))
}

/// The rig of a Middlebury pair.
pub(super) fn middlebury(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["doffs", "ndisp", "cam0"])?;
    let own = file.size_if(&["width"], &["height"])?;
    let view = |side: usize| -> Result<View> {
        let k = rig::intrinsics(&file.need(&[["cam0", "cam1"][side]], "a camera matrix (3 x 3)")?)?;
        Ok(View::pinhole(k, unknowns.size(side, own, file.place())?))
    };
    let baseline = file.get(&["baseline"]).map(|b| b.number()).transpose()?.filter(|b| *b > 0.0);
    let side_by_side = Rigid { t: -Vector3::x(), ..Rigid::NONE };
    let mut pose = Pose::of(&side_by_side, file.place())?;
    pose.baseline_m = baseline.map(|mm| mm / 1000.0);
    rig::meta([view(0)?, view(1)?], &pose, format!("Middlebury: {files}"))
}

/// The rig of a camera file of Cityscapes.
pub(super) fn cityscapes(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["intrinsic"])?;
    let camera = file.need(&["intrinsic"], "fx, fy, u0 and v0")?;
    let k = rig::camera_matrix(camera.numbers_at(["fx", "fy", "u0", "v0"])?);
    check_camera_matrix(&k).map_err(|why| camera.refuse(why))?;
    let baseline = file.need(&["extrinsic.baseline"], "the baseline, m")?;
    one_camera(k, baseline.number()?, &baseline, unknowns, format!("Cityscapes: {files}"))
}

/// A rectified rig with the same camera on both sides.
///
/// * `baseline`: its length, m.
/// * `at`: where the numbers stand.
pub(super) fn one_camera(
    k: Rows,
    baseline: f64,
    at: &Value,
    unknowns: Unknowns,
    source: String,
) -> Result<Meta> {
    let t = Vector3::new(-baseline, 0.0, 0.0);
    let pose = Pose::of(&Rigid { t, ..Rigid::NONE }, at.place())?;
    let view =
        |side| -> Result<View> { Ok(View::pinhole(k, unknowns.size(side, None, at.place())?)) };
    rig::meta([view(0)?, view(1)?], &pose, source)
}
