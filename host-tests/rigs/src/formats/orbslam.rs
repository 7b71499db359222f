//! Settings of ORB-SLAM2, ORB-SLAM3 and `stella_vslam`.
//!
//! ORB-SLAM3: `Camera1`, `Camera2`, and `Stereo.T_c1_c2` (`Tlr` of its first version), which takes points of the right
//! camera to the left one. ORB-SLAM2: `LEFT` and `RIGHT` with the `K D R P` of ROS, or a rectified camera
//! with `Camera.bf`, focal length times baseline. `stella_vslam` (`OpenVSLAM`) gives `K D R` of both cameras below
//! `StereoRectifier`, and `Camera.focal_x_baseline` in place of `P` and `Camera.bf`; its keys may be flat or nested.
//! Lengths are in metres.

use anyhow::{Context, Result, bail};
use nalgebra::{Matrix3, Vector3};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// Width and height of a side's images, px. The file has one size for both sides.
fn size_of(file: &Value, side: usize, unknowns: Unknowns) -> Result<[u16; 2]> {
    let own = file.size_if(&["Camera.width", "Camera.cols"], &["Camera.height", "Camera.rows"])?;
    unknowns.size(side, own, file.place())
}

/// A camera whose keys begin with a name.
fn view(file: &Value, name: &str, lens: LensModel, size: [u16; 2]) -> Result<View> {
    let key = |key: &str| format!("{name}.{key}");
    let k = file.numbers_at(["fx", "fy", "cx", "cy"].map(key))?;
    let keys: Vec<String> = rig::coefficient_keys(lens).iter().map(|one| key(one)).collect();
    View::try_new(k, lens, &file.numbers_or_0(&keys)?, size)
        .with_context(|| format!("{}: {name}", file.place()))
}

/// The lens of the cameras, and whether they are rectified.
fn model(file: &Value) -> Result<(LensModel, bool)> {
    let keys = ["Camera.type", "Camera.model"];
    match file.text_at(&keys).as_str() {
        "PinHole" | "Pinhole" | "perspective" | "" => Ok((LensModel::RadialTangential, false)),
        "KannalaBrandt8" | "fisheye" => Ok((LensModel::Fisheye, false)),
        "Rectified" => Ok((LensModel::RadialTangential, true)),
        _ => {
            bail!(file.need(&keys, "a model")?.refuse(
                "expected PinHole, KannalaBrandt8 or Rectified: calibrate with one of them"
            ))
        }
    }
}

/// The rig of any of the three.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    if files.with(&THIRD).is_empty() { second(files, unknowns) } else { third(files, unknowns) }
}

/// Keys that only ORB-SLAM3 has.
const THIRD: [&str; 5] = ["Camera1.fx", "Camera2.fx", "Stereo.T_c1_c2", "Stereo.b", "Tlr"];

/// The rig of ORB-SLAM3.
fn third(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&THIRD)?;
    if file.get(&["LEFT.K"]).is_some() && file.get(&["Stereo.T_c1_c2", "Tlr", "Stereo.b"]).is_none()
    {
        return raw(&file, unknowns, format!("ORB-SLAM3: {files}"));
    }
    let (lens, rectified) = model(&file)?;
    let first = if file.get(&["Camera1.fx"]).is_some() { "Camera1" } else { "Camera" };
    let second = if file.get(&["Camera2.fx"]).is_some() { "Camera2" } else { first };
    let views = [
        view(&file, first, lens, size_of(&file, 0, unknowns)?)?,
        view(&file, second, lens, size_of(&file, 1, unknowns)?)?,
    ];
    let source = format!("ORB-SLAM3: {files}");
    match file.get(&["Stereo.T_c1_c2", "Tlr"]) {
        Some(value) if !rectified => {
            let pose = Pose::of(&value.transform()?.inverse(), value.place())?;
            rig::meta(views, &pose, source)
        }
        _ => {
            let b = file.need(
                &["Stereo.b"],
                "the baseline, m, or Stereo.T_c1_c2 of a rig that is not rectified",
            )?;
            let side_by_side = Rigid { t: Vector3::new(-b.number()?, 0.0, 0.0), ..Rigid::NONE };
            rig::meta(views, &Pose::of(&side_by_side, b.place())?, source)
        }
    }
}

/// The rig of ORB-SLAM2.
fn second(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["LEFT.K", "Camera.fx", "Camera.bf"])?;
    let source = format!("ORB-SLAM2: {files}");
    if file.get(&["LEFT.K", "StereoRectifier.K_left"]).is_some() {
        return raw(&file, unknowns, source);
    }
    let bf = focal_x_baseline(&file)?;
    let (lens, _) = model(&file)?;
    let left = view(&file, "Camera", lens, size_of(&file, 0, unknowns)?)?;
    let side_by_side = Rigid { t: Vector3::new(-bf / left.k[0][0], 0.0, 0.0), ..Rigid::NONE };
    let pose = Pose::of(&side_by_side, &format!("{}: focal length times baseline", file.place()))?;
    rig::meta([left.clone(), left], &pose, source)
}

/// A rig with `LEFT` and `RIGHT`, or `StereoRectifier`, before its rectification.
fn raw(file: &Value, unknowns: Unknowns, source: String) -> Result<Meta> {
    let is_fisheye = file.text_at(&["StereoRectifier.model"]) == "fisheye";
    let lens = if is_fisheye { LensModel::Fisheye } else { LensModel::RadialTangential };
    let side = |side: usize| -> Result<(View, Matrix3<f64>)> {
        let name = ["LEFT", "RIGHT"][side];
        let own = |key: &str| format!("{name}.{key}");
        let find = |key: &str, what: &str| {
            let stella = format!("StereoRectifier.{key}_{}", name.to_lowercase());
            file.need(&[&own(key), &stella], what)
        };
        let size = match file.size_if(&[&own("width")], &[&own("height")])? {
            Some(size) => size,
            None => size_of(file, side, unknowns)?,
        };
        let k = rig::intrinsics(&find("K", "3 x 3 numbers")?)?;
        let d = find("D", "1 x 5 numbers")?;
        let view = View::of(k, lens, Some(&d), size)?;
        Ok((view, rig::rotation(&find("R", "3 x 3 numbers")?)?))
    };
    let [(left, r_l), (right, r_r)] = [side(0)?, side(1)?];
    let p = |name: &str| file.get(&[&format!("{name}.P")]).map(|p| p.shaped::<12>(3, 4));
    let (baseline, place) = match (p("LEFT").transpose()?, p("RIGHT").transpose()?) {
        (Some(l), Some(r)) => (l[3] / l[0] - r[3] / r[0], "RIGHT.R and RIGHT.P"),
        _ => (focal_x_baseline(file)? / file.number_at("Camera.fx")?, "focal_x_baseline"),
    };
    let rigid = rig::of_rectification([&r_l, &r_r], [baseline, 0.0]);
    let pose = Pose::of(&rigid, &format!("{}: {place}", file.place()))?;
    rig::meta([left, right], &pose, source)
}

/// Focal length times baseline of a rectified pair, px m.
fn focal_x_baseline(file: &Value) -> Result<f64> {
    let keys = ["Camera.bf", "Camera.focal_x_baseline"];
    file.need(&keys, "focal length times baseline, px m, of a stereo rig")?.number()
}
