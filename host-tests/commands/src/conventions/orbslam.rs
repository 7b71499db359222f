//! Settings of ORB-SLAM2 and ORB-SLAM3.
//!
//! ORB-SLAM3: `Camera1`, `Camera2`, and `Stereo.T_c1_c2` (`Tlr` of its first version), which takes points of the right
//! camera to the left one. ORB-SLAM2: `LEFT` and `RIGHT` with the `K D R P` of ROS, or a rectified camera
//! with `Camera.bf`, focal length times baseline. All in metres.

use anyhow::{Result, bail};
use nalgebra::{Matrix3, Vector3};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use super::rigid::Rigid;
use host_tests::data::{LensModel, Meta};

fn number(file: &Value, key: &str) -> Result<f64> {
    file.need(&[key], "a number")?.number()
}

/// Width and height of all images, px.
fn size_of(file: &Value, side: usize, unknowns: Unknowns) -> Result<[u16; 2]> {
    let own = match (file.get(&["Camera.width"]), file.get(&["Camera.height"])) {
        (Some(width), Some(height)) => Some([width.count()?, height.count()?]),
        _ => None,
    };
    unknowns.size(side, own, file.place())
}

/// A camera whose keys begin with a name.
fn view(file: &Value, name: &str, fisheye: bool, size: [u16; 2]) -> Result<View> {
    let key = |key: &str| format!("{name}.{key}");
    let k = camera_matrix([
        number(file, &key("fx"))?,
        number(file, &key("fy"))?,
        number(file, &key("cx"))?,
        number(file, &key("cy"))?,
    ]);
    let place = || format!("{}: {name}", file.place());
    host_tests::data::check_camera_matrix(&k)
        .map_err(|why| anyhow::anyhow!("{}: {why}", place()))?;
    let (lens, names): (_, &[&str]) = if fisheye {
        (LensModel::Fisheye, &["k1", "k2", "k3", "k4"])
    } else {
        (LensModel::RadialTangential, &["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"])
    };
    let mut given = Vec::new();
    for one in names {
        given.push(match file.get(&[key(one).as_str()]) {
            Some(value) => value.number()?,
            None => 0.0,
        });
    }
    View::with(k, lens, &given, size).map_err(|why| anyhow::anyhow!("{}: {why}", place()))
}

/// Whether the cameras are fisheyes, and whether they are rectified.
fn model(file: &Value) -> Result<(bool, bool)> {
    let model = file.get(&["Camera.type"]);
    match model.as_ref().map(Value::text).unwrap_or_default().as_str() {
        "PinHole" | "Pinhole" | "" => Ok((false, false)),
        "KannalaBrandt8" => Ok((true, false)),
        "Rectified" => Ok((false, true)),
        _ => {
            bail!(file.need(&["Camera.type"], "a model")?.refuse(
                "expected PinHole, KannalaBrandt8 or Rectified: calibrate with one of them"
            ))
        }
    }
}

/// The rig of ORB-SLAM3.
pub(super) fn third(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["Camera1.fx", "Camera2.fx", "Stereo.T_c1_c2", "Stereo.b", "Tlr"])?;
    let (fisheye, rectified) = model(&file)?;
    let first = if file.get(&["Camera1.fx"]).is_some() { "Camera1" } else { "Camera" };
    let second = if file.get(&["Camera2.fx"]).is_some() { "Camera2" } else { first };
    let views = [
        view(&file, first, fisheye, size_of(&file, 0, unknowns)?)?,
        view(&file, second, fisheye, size_of(&file, 1, unknowns)?)?,
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
pub(super) fn second(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["LEFT.K", "Camera.fx", "Camera.bf"])?;
    let source = format!("ORB-SLAM2: {files}");
    if file.get(&["LEFT.K"]).is_some() {
        return raw(&file, unknowns, source);
    }
    let bf = file.need(&["Camera.bf"], "focal length times baseline, px m, of a stereo rig")?;
    let (fisheye, _) = model(&file)?;
    let left = view(&file, "Camera", fisheye, size_of(&file, 0, unknowns)?)?;
    let baseline = bf.number()? / left.k[0][0];
    let side_by_side = Rigid { t: Vector3::new(-baseline, 0.0, 0.0), ..Rigid::NONE };
    let pose = Pose::of(&side_by_side, bf.place())?;
    rig::meta([left.clone(), left], &pose, source)
}

/// A rig with `LEFT` and `RIGHT`, before its rectification.
fn raw(file: &Value, unknowns: Unknowns, source: String) -> Result<Meta> {
    let side = |side: usize| -> Result<(View, Matrix3<f64>, [f64; 12])> {
        let name = ["LEFT", "RIGHT"][side];
        let find = |key: &str, what: &str| file.need(&[&format!("{name}.{key}")], what);
        let own = match (find("width", "px"), find("height", "px")) {
            (Ok(width), Ok(height)) => Some([width.count()?, height.count()?]),
            _ => None,
        };
        let size = match own {
            Some(size) => size,
            None => size_of(file, side, unknowns)?,
        };
        let k = rig::intrinsics(&find("K", "3 x 3 numbers")?)?;
        let d = find("D", "1 x 5 numbers")?;
        let view = View::of(k, LensModel::RadialTangential, Some(&d), size)?;
        Ok((
            view,
            rig::rotation(&find("R", "3 x 3 numbers")?)?,
            find("P", "3 x 4 numbers")?.shaped(3, 4)?,
        ))
    };
    let [(left, r_l, p_l), (right, r_r, p_r)] = [side(0)?, side(1)?];
    let place = format!("{}: RIGHT.R and RIGHT.P", file.place());
    let baseline = p_l[3] / p_l[0] - p_r[3] / p_r[0];
    let t = -r_r.row(0).transpose() * baseline;
    let pose = Pose::of(&Rigid { r: r_r.transpose() * r_l, t }, &place)?;
    rig::meta([left, right], &pose, source)
}
