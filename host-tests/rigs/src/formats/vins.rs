//! VINS-Fusion: a configuration with `body_T_cam0` and `body_T_cam1`, and a file of each camera beside it.
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
    let mut files = files.clone();
    let names = {
        let config = files.one(&["body_T_cam0", "cam0_calib"])?;
        let numbers = unknowns.cameras_or([0, 1]);
        let name =
            |n: u8| Ok(config.need(&[&format!("cam{n}_calib")], "the file of a camera")?.text());
        numbers.map(name).into_iter().collect::<Result<Vec<String>>>()?
    };
    for name in &names {
        files.beside(name)?;
    }
    let config = files.one(&["body_T_cam0", "cam0_calib"])?;
    let to_body = |n: u8| {
        config.need(&[&format!("body_T_cam{n}")], "4 x 4 numbers, camera to body")?.transform()
    };
    let [left, right] = unknowns.cameras_or([0, 1]);
    let way = Rigid::left_to_right([to_body(left)?, to_body(right)?]);
    let pose =
        Pose::of(&way, &format!("{}: body_T_cam{left} and body_T_cam{right}", config.place()))?;
    let view = |side: usize| -> Result<View> {
        let file = files
            .named(&names[side])
            .with_context(|| format!("{}: {} is missing", config.place(), names[side]))?;
        view(&file, side, unknowns)
    };
    rig::meta([view(0)?, view(1)?], &pose, format!("VINS-Fusion: {files}"))
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
