//! The calibration that `get_img_params` of MYNT EYE cameras prints.
//!
//! `Extrinsics right to left` hold `R` and `T` of `cv::stereoRectify`, despite their name: `x_r = R x_l + T`, with `T`
//! in millimetres.

use anyhow::Result;
use nalgebra::Vector3;

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
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
    let size = of.size_at(&["width"], &["height"])?;
    if of.get(&["mu"]).is_some() {
        // The k2 to k5 of the device are k1 to k4 of OpenCV's fisheye, as in VINS-Fusion.
        let given = of.numbers_at(["k2", "k3", "k4", "k5"])?;
        return View::try_new(
            of.numbers_at(["mu", "mv", "u0", "v0"])?,
            LensModel::Fisheye,
            &given,
            size,
        )
        .map_err(|why| of.refuse(why));
    }
    let given = of.get(&["coeffs"]).map_or(Ok(Vec::new()), |given| given.numbers())?;
    let k = of.numbers_at(["fx", "fy", "cx", "cy"])?;
    View::try_new(k, LensModel::RadialTangential, &given, size).map_err(|why| of.refuse(why))
}
