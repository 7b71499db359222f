//! Basalt's calibration, in JSON: `T_imu_cam` takes points of a camera to the IMU, as a quaternion and a translation in
//! metres.

use anyhow::{Context, Result, bail};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["value0"])?;
    let root = file.need(&["value0"], "the calibration")?;
    let chosen = unknowns.cameras_or([0, 1]);
    let of = |key: &str, side: usize| -> Result<Value> {
        let all = root.need(&[key], "a list with a value for each camera")?;
        let n = usize::from(chosen[side]);
        let count = all.items().len();
        all.items()
            .into_iter()
            .nth(n)
            .with_context(|| format!("{}: {count} cameras, there is no number {n}", all.place()))
    };
    let to_imu = |side: usize| -> Result<Rigid> {
        let value = of("T_imu_cam", side)?;
        let number = |key: &str| value.need(&[key], "a number")?.number();
        let q = [number("qw")?, number("qx")?, number("qy")?, number("qz")?];
        let t = [number("px")?, number("py")?, number("pz")?];
        Rigid::of_quaternion(q, t).map_err(|why| value.refuse(why))
    };
    let way = Rigid::left_to_right([to_imu(0)?, to_imu(1)?]);
    let pose = Pose::of(&way, &format!("{}: T_imu_cam", root.place()))?;
    let view = |side: usize| view(&of("intrinsics", side)?, of("resolution", side)?.size()?);
    rig::meta([view(0)?, view(1)?], &pose, format!("Basalt: {files}"))
}

fn view(camera: &Value, size: [u16; 2]) -> Result<View> {
    let model = camera.need(&["camera_type"], "a model")?;
    let numbers = camera.need(&["intrinsics"], "the camera's parameters")?;
    let of = |key: &str| numbers.need(&[key], "a number")?.number();
    let (lens, names): (_, &[&str]) = match model.text().as_str() {
        "pinhole" => (LensModel::RadialTangential, &[]),
        "kb4" => (LensModel::Fisheye, &["k1", "k2", "k3", "k4"]),
        "pinhole-radtan8" => {
            (LensModel::RadialTangential, &["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"])
        }
        _ => bail!(model.refuse(
            "expected pinhole, pinhole-radtan8 or kb4, not ds, eucm or ucm: calibrate with kb4"
        )),
    };
    let k = camera_matrix([of("fx")?, of("fy")?, of("cx")?, of("cy")?]);
    crate::data::check_camera_matrix(&k).map_err(|why| numbers.refuse(why))?;
    let given = names.iter().map(|name| of(name)).collect::<Result<Vec<_>>>()?;
    View::with(k, lens, &given, size).map_err(|why| numbers.refuse(why))
}
