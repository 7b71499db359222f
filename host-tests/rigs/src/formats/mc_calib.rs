//! MC-Calib's `calibrated_cameras_data.yml`: `camera_pose_matrix` takes points of a camera to the reference camera, in
//! the unit of the board.

use anyhow::{Result, bail};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["camera_0", "camera_1", "nb_camera"])?;
    let cameras = unknowns.cameras_or([0, 1]);
    let of = |n: u8| file.need(&[&format!("camera_{n}")], "a camera");
    let [left, right] = [of(cameras[0])?, of(cameras[1])?];
    let to_reference =
        |camera: &Value| camera.need(&["camera_pose_matrix"], "4 x 4 numbers")?.transform();
    let way = Rigid::left_to_right([to_reference(&left)?, to_reference(&right)?]);
    let pose = Pose::of(&way, &format!("{}: camera_pose_matrix", right.place()))?
        .in_unit(unknowns.unit_m)?;
    rig::meta([view(&left)?, view(&right)?], &pose, format!("MC-Calib: {files}"))
}

fn view(camera: &Value) -> Result<View> {
    let lens = match camera.text_at(&["distortion_type"]).as_str() {
        "0" | "" => LensModel::RadialTangential,
        "1" => LensModel::Fisheye,
        _ => bail!(
            camera
                .need(&["distortion_type"], "0 or 1")?
                .refuse("expected 0 (Brown) or 1 (fisheye): calibrate with one of them")
        ),
    };
    let size = camera.size_at(&["img_width"], &["img_height"])?;
    let k = rig::intrinsics(&camera.need(&["camera_matrix"], "3 x 3 numbers")?)?;
    View::of(k, lens, camera.get(&["distortion_vector"]).as_ref(), size)
}
