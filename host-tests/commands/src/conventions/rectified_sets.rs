//! Calibrations of rectified data sets: KITTI's `calib.txt` and Middlebury's.
//!
//! Both are rectified: `R = I`. KITTI: `P = K [I | c]`, so a camera sees points moved by `K^-1` times the last column,
//! metres; the cameras 2 and 3 are a little off a common row. Middlebury: `cam0`, `cam1` and the baseline in
//! millimetres, `t = (-1, 0, 0)`.

use anyhow::{Context, Result};
use nalgebra::{Matrix3, Vector3};

use super::Files;
use super::kalibr::size_of;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use host_tests::data::{Meta, matrix};

/// The rig of KITTI's grey cameras 0 (left) and 1, or of the chosen ones: 2 and 3 are the colour cameras.
pub(super) fn kitti(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let cameras = unknowns.cameras_or([0, 1]);
    let mut views = Vec::new();
    let mut moved = Vec::new();
    for (side, n) in cameras.into_iter().enumerate() {
        let p = files.find(&[&format!("P{n}"), &format!("P_rect_0{n}")], "12 numbers")?;
        let [a, b, c, x, d, e, f, y, g, h, i, z] = p.array::<12>("a projection matrix")?;
        let k = [[a, b, c], [d, e, f], [g, h, i]];
        host_tests::data::check_camera_matrix(&k).map_err(|why| p.refuse(why))?;
        let own = files.get(&[&format!("S_rect_0{n}")]).map(|size| size_of(&size)).transpose()?;
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
    let file = files.one(&["doffs", "ndisp"])?;
    let own = match (file.get(&["width"]), file.get(&["height"])) {
        (Some(width), Some(height)) => Some([width.count()?, height.count()?]),
        _ => None,
    };
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
