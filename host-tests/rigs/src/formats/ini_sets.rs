//! Files of sections: INI of iCub and MRPT, and TOML of Anipose.
//!
//! iCub: `HN` takes points of the left camera to the right one, metres. MRPT: `pose_quaternion` is the pose
//! `x y z qw qx qy qz` of the right camera in the frame of the left one, metres. Anipose: `rotation` (axis times angle)
//! and `translation` take points of the world to a camera, in the unit of the board.

use anyhow::{Context, Result};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// The rig of iCub.
pub(super) fn icub(files: &Files, _: Unknowns) -> Result<Meta> {
    let file = files.one(&["CAMERA_CALIBRATION_LEFT", "STEREO_DISPARITY"])?;
    let way = file.need(&["STEREO_DISPARITY.hn"], "4 x 4 numbers")?;
    let pose = Pose::of(&way.transform()?, way.place())?;
    let view = |side: &str| -> Result<View> {
        let camera = file.need(&[&format!("CAMERA_CALIBRATION_{side}")], "a camera")?;
        let given = camera.numbers_or_0(&["k1", "k2", "p1", "p2"])?;
        let size = camera.size_at(&["w"], &["h"])?;
        View::try_new(
            camera.numbers_at(["fx", "fy", "cx", "cy"])?,
            LensModel::RadialTangential,
            &given,
            size,
        )
        .with_context(|| camera.place().to_owned())
    };
    rig::meta([view("LEFT")?, view("RIGHT")?], &pose, format!("iCub: {files}"))
}

/// The rig of MRPT.
pub(super) fn mrpt(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["CAMERA_PARAMS_LEFT"])?;
    let pose = file.need(
        &["CAMERA_PARAMS_LEFT2RIGHT_POSE.pose_quaternion"],
        "the pose of the right camera, x y z qw qx qy qz",
    )?;
    let [x, y, z, q @ ..] = pose.array::<7>("x y z qw qx qy qz")?;
    let to_left = Rigid::of_quaternion(q, [x, y, z]).map_err(|why| pose.refuse(why))?;
    let pose = Pose::of(&to_left.inverse(), pose.place())?;
    let view = |side: usize, name: &str| -> Result<View> {
        let camera = file.need(&[&format!("CAMERA_PARAMS_{name}")], "a camera")?;
        let size = camera.get(&["resolution"]).map(|size| size.size()).transpose()?;
        let size = unknowns.size(side, size, camera.place())?;
        let lens = camera.get(&["dist"]).map(|dist| dist.numbers()).transpose()?;
        View::try_new(
            camera.numbers_at(["fx", "fy", "cx", "cy"])?,
            LensModel::RadialTangential,
            &lens.unwrap_or_default(),
            size,
        )
        .with_context(|| camera.place().to_owned())
    };
    rig::meta([view(0, "LEFT")?, view(1, "RIGHT")?], &pose, format!("MRPT: {files}"))
}

/// The rig of Anipose.
pub(super) fn anipose(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["CAM_0", "CAM_1"])?;
    let names: Vec<&str> = file.keys().into_iter().filter(|key| key.starts_with("CAM_")).collect();
    let cameras =
        rig::two(&names, unknowns, file.place())?.map(|name| file.need(&[name], "a camera"));
    let [left, right] = cameras;
    let [left, right] = [left?, right?];
    let from_world = |camera: &Value| -> Result<Rigid> {
        let r = rig::rotation(&camera.need(&["rotation"], "a rotation vector, rad")?)?;
        let t = camera.need(&["translation"], "3 numbers")?.array::<3>("a translation")?;
        Ok(Rigid { r, t: t.into() })
    };
    let way = from_world(&left)?.inverse().then(&from_world(&right)?);
    let pose = Pose::of(&way, right.place())?.in_unit(unknowns.unit_m)?;
    let view = |camera: &Value| -> Result<View> {
        let is_fisheye = camera.text_at(&["fisheye"]) == "true";
        let lens = if is_fisheye { LensModel::Fisheye } else { LensModel::RadialTangential };
        let k = rig::intrinsics(&camera.need(&["matrix"], "3 x 3 numbers")?)?;
        let size = camera.need(&["size"], "width and height, px")?.size()?;
        View::of(k, lens, camera.get(&["distortions"]).as_ref(), size)
    };
    rig::meta([view(&left)?, view(&right)?], &pose, format!("Anipose: {files}"))
}
