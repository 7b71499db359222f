//! Basalt's calibration, in JSON: `T_imu_cam` takes points of a camera to the IMU, as a quaternion and a translation in
//! metres.

use anyhow::{Result, bail};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["value0"])?;
    let root = file.need(&["value0"], "the calibration")?;
    let chosen = unknowns.cameras_or([0, 1]);
    let of = |key: &str, side: usize| -> Result<Value> {
        root.need(&[key], "a list with a value for each camera")?.camera(chosen[side])
    };
    let to_imu = |side: usize| -> Result<Rigid> {
        let value = of("T_imu_cam", side)?;
        let q = value.numbers_at(["qw", "qx", "qy", "qz"])?;
        Rigid::of_quaternion(q, value.numbers_at(["px", "py", "pz"])?)
            .map_err(|why| value.refuse(why))
    };
    let way = Rigid::left_to_right([to_imu(0)?, to_imu(1)?]);
    let pose = Pose::of(&way, &format!("{}: T_imu_cam", root.place()))?;
    let view = |side: usize| view(&of("intrinsics", side)?, of("resolution", side)?.size()?);
    rig::meta([view(0)?, view(1)?], &pose, format!("Basalt: {files}"))
}

fn view(camera: &Value, size: [u16; 2]) -> Result<View> {
    let model = camera.need(&["camera_type"], "a model")?;
    let numbers = camera.need(&["intrinsics"], "the camera's parameters")?;
    let (lens, is_plain) = match model.text().as_str() {
        "pinhole" => (LensModel::RadialTangential, true),
        "kb4" => (LensModel::Fisheye, false),
        "pinhole-radtan8" => (LensModel::RadialTangential, false),
        _ => bail!(model.refuse(
            "expected pinhole, pinhole-radtan8 or kb4, not ds, eucm or ucm: calibrate with kb4"
        )),
    };
    let k = numbers.numbers_at(["fx", "fy", "cx", "cy"])?;
    let keys = rig::coefficient_keys(lens).iter().filter(|_| !is_plain);
    let given = keys.map(|key| numbers.number_at(key)).collect::<Result<Vec<_>>>()?;
    View::try_new(k, lens, &given, size).map_err(|why| numbers.refuse(why))
}
