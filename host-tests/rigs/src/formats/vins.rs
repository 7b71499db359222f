//! VINS-Fusion: a configuration with `body_T_cam0` and `body_T_cam1`, and a file of each camera beside it. `OV2SLAM`: the
//! same transforms with the cameras in the configuration, `Camera.fxl` to `Camera.p2r`.
//!
//! `body_T_cam` takes points of a camera to the body, in metres.

use anyhow::{Context, Result, bail};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let config = files.one(&["body_T_cam0", "cam0_calib"])?;
    let numbers = unknowns.cameras_or([0, 1]);
    let to_body = |n: u8| {
        config.need(&[&format!("body_T_cam{n}")], "4 x 4 numbers, camera to body")?.transform()
    };
    let [left, right] = numbers;
    let way = Rigid::left_to_right([to_body(left)?, to_body(right)?]);
    let pose =
        Pose::of(&way, &format!("{}: body_T_cam{left} and body_T_cam{right}", config.place()))?;
    if config.get(&["Camera.fxl"]).is_some() {
        let views =
            [view_within(&config, left, 0, unknowns)?, view_within(&config, right, 1, unknowns)?];
        return rig::meta(views, &pose, format!("OV2SLAM: {files}"));
    }
    let name = |n: u8| Ok(config.need(&[&format!("cam{n}_calib")], "the file of a camera")?.text());
    let names = numbers.map(name).into_iter().collect::<Result<Vec<String>>>()?;
    let mut cameras = files.clone();
    for name in &names {
        cameras.beside(name)?;
    }
    let view = |side: usize| -> Result<View> {
        let file = cameras
            .named(&names[side])
            .with_context(|| format!("{}: {} is missing", config.place(), names[side]))?;
        view(&file, side, unknowns)
    };
    rig::meta([view(0)?, view(1)?], &pose, format!("VINS-Fusion: {cameras}"))
}

/// A camera of OV2SLAM.
fn view_within(config: &Value, number: u8, side: usize, unknowns: Unknowns) -> Result<View> {
    let (name, letter) = if number == 0 { ("left", "l") } else { ("right", "r") };
    let key = |key: &str| format!("Camera.{key}{letter}");
    let model = format!("Camera.model_{name}");
    let lens = rig::lens_at(config, &[&model])?;
    let [width, height] = ["width", "height"].map(|which| format!("Camera.{name}_n{which}"));
    let size = unknowns.size(side, config.size_if(&[&width], &[&height])?, config.place())?;
    let k = config.numbers_at(["fx", "fy", "cx", "cy"].map(key))?;
    let coefficients: &[&str] = match lens {
        LensModel::Fisheye => &["k1", "k2", "k3", "k4"],
        _ => &["k1", "k2", "p1", "p2"],
    };
    let keys: Vec<String> = coefficients.iter().map(|one| key(one)).collect();
    View::try_new(k, lens, &config.numbers_or_0(&keys)?, size)
        .with_context(|| format!("{}: the {name} camera", config.place()))
}

fn view(file: &Value, side: usize, unknowns: Unknowns) -> Result<View> {
    let model = file.need(&["model_type"], "PINHOLE or KANNALA_BRANDT")?;
    let own = file.size_if(&["image_width"], &["image_height"])?;
    let size = unknowns.size(side, own, file.place())?;
    let projection = file.need(&["projection_parameters"], "the camera's parameters")?;
    let (k, lens, given) = match model.text().to_uppercase().as_str() {
        "PINHOLE" => {
            let k = projection.numbers_at(["fx", "fy", "cx", "cy"])?;
            let distortion = file.need(&["distortion_parameters"], "k1 k2 p1 p2")?;
            (k, LensModel::RadialTangential, distortion.numbers_at(["k1", "k2", "p1", "p2"])?)
        }
        // The k2 to k5 of the file multiply the powers 3 to 9 of the angle: k1 to k4 of OpenCV's fisheye.
        "KANNALA_BRANDT" => (
            projection.numbers_at(["mu", "mv", "u0", "v0"])?,
            LensModel::Fisheye,
            projection.numbers_at(["k2", "k3", "k4", "k5"])?,
        ),
        _ => bail!(model.refuse("expected PINHOLE or KANNALA_BRANDT: calibrate with one of them")),
    };
    View::try_new(k, lens, &given, size).map_err(|why| file.refuse(why))
}
