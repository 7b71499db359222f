//! Calibrations of `RealSense` cameras: JSON of the library's structures, and the output of its tools.
//!
//! JSON: the fields of `rs2_intrinsics` under `left` and `right`, those of `rs2_extrinsics` (left to right,
//! `rotation` by columns, metres) under `extrinsics`. `rs-enumerate-devices -c` prints the rotation by rows. The
//! calibration table that the tools save has the rectified streams.

use anyhow::{Context, Result, bail};
use nalgebra::{Matrix3, Vector3};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// Largest number of sizes in a calibration table.
const MODES: u8 = 16;

/// The streams of a pair, left and right.
const STREAMS: [[&str; 2]; 2] = [["Infrared 1", "Infrared 2"], ["Fisheye 1", "Fisheye 2"]];

/// A camera from the fields of `rs2_intrinsics`; those of a printed text are in lower case too.
fn view(of: &Value) -> Result<View> {
    let size = of.size_at(&["width"], &["height"])?;
    let k = of.numbers_at(["fx", "fy", "ppx", "ppy"])?;
    let (lens, given) = lens(of)?;
    View::try_new(k, lens, &given, size).map_err(|why| of.refuse(why))
}

/// The lens of a model's name in any spelling, and its coefficients.
fn lens(of: &Value) -> Result<(LensModel, Vec<f64>)> {
    let model = of.get(&["model", "distortion"]);
    let coeffs = of
        .get(&["coeffs", "distortion_coeffs"])
        .map(|all| all.numbers())
        .transpose()?
        .unwrap_or_default();
    // `distortion.brown_conrady`, `Brown Conrady` and `RS2_DISTORTION_BROWN_CONRADY` are the same model.
    let name = model.as_ref().map(Value::text).unwrap_or_default().to_lowercase();
    let name = name.rsplit('.').next().unwrap_or_default().replace("rs2_distortion", "");
    let name: String = name.chars().filter(char::is_ascii_alphanumeric).collect();
    match name.as_str() {
        "kannalabrandt4" => Ok((LensModel::Fisheye, coeffs)),
        "brownconrady" | "none" | "" => Ok((LensModel::RadialTangential, coeffs)),
        _ if coeffs.iter().all(|k| *k == 0.0) => Ok((LensModel::RadialTangential, Vec::new())),
        _ => bail!(model.context("a model")?.refuse(
            "expected Brown Conrady or Kannala Brandt4, or a rectified stream (all coefficients 0): give one of these"
        )),
    }
}

/// The rig of a JSON.
pub(super) fn json(files: &Files, _: Unknowns) -> Result<Meta> {
    let file = files.one(&["extrinsics"])?;
    let side = |key: &str| view(&file.need(&[key], "rs2_intrinsics")?);
    let extrinsics = file.need(&["extrinsics"], "rs2_extrinsics")?;
    let rotation = extrinsics.need(&["rotation"], "9 numbers by columns")?;
    let r = Matrix3::from_column_slice(&rotation.array::<9>("a rotation by columns")?);
    Rigid { r, ..Rigid::NONE }.check().map_err(|why| rotation.refuse(why))?;
    let t = extrinsics.need(&["translation"], "3 numbers, m")?;
    let rigid = Rigid { r, t: t.array::<3>("a translation, m")?.into() };
    let pose = Pose::of(&rigid, &format!("{}, of left to right", t.place()))?;
    rig::meta([side("left")?, side("right")?], &pose, format!("RealSense: {files}"))
}

/// The rig of a calibration table: rectified streams, each size with its numbers as texts, baseline in millimetres.
pub(super) fn table(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["rectified.0.fx", "rectified.1.fx"])?;
    let mut views: Vec<View> = Vec::new();
    for n in 0..MODES {
        let key = |key: &str| format!("rectified.{n}.{key}");
        let keys = ["fx", "fy", "ppx", "ppy"].map(key);
        let size = file.size_if(&[&key("width")], &[&key("height")])?;
        let Some(size) = size.filter(|_| keys.iter().all(|key| file.get(&[key]).is_some())) else {
            continue;
        };
        let k = file.numbers_at(keys)?;
        if k[0] > 0.0 && k[1] > 0.0 && !size.contains(&0) {
            views.push(View::pinhole(camera_matrix(k), size));
        }
    }
    if views.is_empty() {
        bail!("{}: no rectified stream has both a size and a focal length", file.place());
    }
    let wanted = unknowns.sizes.map(|[left, _]| left);
    let view = rig::of_size(&views, |view| view.size, wanted, file.place())?;
    let baseline = file.need(&["baseline"], "the baseline, mm")?;
    let t = Vector3::new(-baseline.number()?.abs() / 1000.0, 0.0, 0.0);
    let pose = Pose::of(&Rigid { t, ..Rigid::NONE }, baseline.place())?;
    rig::meta([view.clone(), view.clone()], &pose, format!("RealSense: {files}"))
}

/// The rig of a text: the streams of a pair, with the given size or the only one.
pub(super) fn printed(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["rs intrinsics"])?;
    let all = file.need(&["rs intrinsics"], "blocks of intrinsics")?.items();
    let name = |block: &Value, key: &str| block.text_at(&[key]);
    let there = |stream: &str| all.iter().any(|block| name(block, "stream") == stream);
    let Some(pair) = STREAMS.into_iter().find(|pair| pair.iter().all(|stream| there(stream)))
    else {
        bail!(
            "{}: there are no intrinsics of Infrared 1 and 2, or Fisheye 1 and 2: print them with rs-enumerate-devices -c",
            file.place()
        );
    };
    let views = [0, 1].map(|side| -> Result<View> {
        let of_stream = all.iter().filter(|block| name(block, "stream") == pair[side]);
        let found = of_stream.map(view).collect::<Result<Vec<_>>>()?;
        let mut each: Vec<View> = Vec::new();
        for view in found {
            if each.iter().all(|other| other.size != view.size) {
                each.push(view);
            }
        }
        let wanted = unknowns.sizes.map(|sizes| sizes[side]);
        let wanted = wanted.filter(|size| each.iter().any(|view| view.size == *size));
        let place = format!("{}: {}", file.place(), pair[side]);
        rig::of_size(&each, |view| view.size, wanted, &place).cloned()
    });
    let [left, right] = views;
    let ways = file.need(&["rs extrinsics"], "blocks of extrinsics")?.items();
    let way = |from: &str, to: &str| {
        ways.iter().find(|way| name(way, "from") == from && name(way, "to") == to)
    };
    let read = |way: &Value| -> Result<Rigid> {
        let numbers =
            way.need(&["numbers"], "12 numbers")?.array::<12>("a rotation and a translation")?;
        let (r, t) = numbers.split_at(9);
        let rigid = Rigid { r: Matrix3::from_row_slice(r), t: Vector3::from_column_slice(t) };
        rigid.check().map_err(|why| way.refuse(why))?;
        Ok(rigid)
    };
    let rigid = match (way(pair[0], pair[1]), way(pair[1], pair[0])) {
        (Some(there), _) => read(there)?,
        (None, Some(back)) => read(back)?.inverse(),
        _ => bail!(
            "{}: there are no extrinsics from {} to {}: print them with rs-enumerate-devices -c",
            file.place(),
            pair[0],
            pair[1]
        ),
    };
    let pose =
        Pose::of(&rigid, &format!("{}: Extrinsic from {} to {}", file.place(), pair[0], pair[1]))?;
    rig::meta([left?, right?], &pose, format!("RealSense: {files}"))
}

/// The rig of the streams that `rs-sensor-control` prints; it prints no sizes.
pub(super) fn sensors(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["rs sensors"])?;
    let all = file.need(&["rs sensors"], "the streams")?.items();
    let [left, right] = all.as_slice() else {
        bail!(
            "{}: {} streams with a Principal Point: print the left and the right one",
            file.place(),
            all.len()
        );
    };
    let view = |side: usize, of: &Value| -> Result<View> {
        let [cx, cy] = of.need(&["principal point"], "x, y")?.array("a Principal Point")?;
        let [fx, fy] = of.need(&["focal length"], "x, y")?.array("a Focal Length")?;
        let (lens, given) = lens(of)?;
        let size = unknowns.size(side, None, of.place())?;
        View::try_new([fx, fy, cx, cy], lens, &given, size).map_err(|why| of.refuse(why))
    };
    let r = rig::rotation(&file.need(&["rotation matrix"], "Rotation Matrix")?)?;
    let t = file.need(&["translation vector"], "Translation Vector")?;
    let rigid = Rigid { r, t: t.array::<3>("a Translation Vector")?.into() };
    let pose = Pose::of(&rigid, t.place())?;
    rig::meta([view(0, left)?, view(1, right)?], &pose, format!("RealSense: {files}"))
}
