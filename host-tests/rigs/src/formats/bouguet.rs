//! Stereo calibration of Bouguet's toolbox for MATLAB, as it saves or prints it.
//!
//! `om` is the rotation vector, rad: `x_r = R x_l + T`. The centre of the first pixel is at `(0, 0)`, the coefficients
//! are `k1 k2 p1 p2 k3`, and `T` is in the unit of the board.

use anyhow::{Result, ensure};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta, check_camera_matrix};

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["fc_left"])?;
    let r = rig::rotation(&file.need(&["om", "R"], "a rotation vector")?)?;
    let t = file.need(&["T"], "a translation")?;
    let rigid = Rigid { r, t: t.array::<3>("a translation")?.into() };
    let pose = Pose::of(&rigid, t.place())?.in_unit(unknowns.unit_m)?;
    let view = |side: usize| view(&file, side, unknowns);
    rig::meta([view(0)?, view(1)?], &pose, format!("Bouguet: {files}"))
}

fn view(file: &Value, side: usize, unknowns: Unknowns) -> Result<View> {
    let find =
        |key: &str, what: &str| file.need(&[&format!("{key}_{}", ["left", "right"][side])], what);
    let focal = find("fc", "two focal lengths")?;
    let [fx, fy] = focal.array("two focal lengths")?;
    let [cx, cy] = find("cc", "the principal point")?.array("the principal point")?;
    if let Ok(skew) = find("alpha_c", "the skew") {
        let why = "a skew is not supported: calibrate without it";
        ensure!(skew.number()? == 0.0, skew.refuse(why));
    }
    let k = camera_matrix([fx, fy, cx, cy]);
    check_camera_matrix(&k).map_err(|why| focal.refuse(why))?;
    let size = unknowns.size(side, None, file.place())?;
    View::of(k, LensModel::RadialTangential, Some(&find("kc", "k1 k2 p1 p2 k3")?), size)
}
