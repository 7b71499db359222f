//! The calibration that `get_img_params` of MYNT EYE cameras prints.
//!
//! `Extrinsics right to left` hold `R` and `T` of `cv::stereoRectify`, despite their name: `x_r = R x_l + T`, with `T`
//! in millimetres.

use anyhow::Result;
use nalgebra::Vector3;

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// The whole rig.
pub(super) fn rig(files: &Files, _: Unknowns) -> Result<Meta> {
    let file = files.one(&["Intrinsics left"])?;
    let way = file.need(&["Extrinsics right to left"], "a rotation and a translation")?;
    let r = rig::rotation(&way.need(&["rotation"], "9 numbers")?)?;
    let t = way.need(&["translation"], "3 numbers, mm")?;
    let rigid = Rigid { r, t: Vector3::from(t.array::<3>("a translation")?) / 1000.0 };
    let pose = Pose::of(&rigid, t.place())?;
    let view = |side: &str| view(&file.need(&[&format!("Intrinsics {side}")], "a camera")?);
    rig::meta([view("left")?, view("right")?], &pose, format!("MYNT EYE: {files}"))
}

fn view(of: &Value) -> Result<View> {
    let numbers = |keys: [&str; 4]| -> Result<[f64; 4]> {
        let [a, b, c, d] = keys.map(|key| of.need(&[key], "a number")?.number());
        Ok([a?, b?, c?, d?])
    };
    let size = [of.need(&["width"], "px")?.count()?, of.need(&["height"], "px")?.count()?];
    let is_fisheye = of.get(&["mu"]).is_some();
    let k = camera_matrix(numbers(if is_fisheye {
        ["mu", "mv", "u0", "v0"]
    } else {
        ["fx", "fy", "cx", "cy"]
    })?);
    crate::data::check_camera_matrix(&k).map_err(|why| of.refuse(why))?;
    if is_fisheye {
        // The k2 to k5 of the device are k1 to k4 of OpenCV's fisheye, as in VINS-Fusion.
        let given = numbers(["k2", "k3", "k4", "k5"])?;
        return View::with(k, LensModel::Fisheye, &given, size).map_err(|why| of.refuse(why));
    }
    View::of(k, LensModel::RadialTangential, of.get(&["coeffs"]).as_ref(), size)
}
