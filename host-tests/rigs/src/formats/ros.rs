//! ROS `camera_info` of a pair: files of `camera_calibration`, and the output of `rostopic echo` and `ros2 topic echo`.
//!
//! The extrinsics are in the rectification: `R = R_r^T R_l` and `t` is minus the first row of `R_r`, for any turn of
//! the rectified frame about the baseline; `P[0][3] = -fx b` of the right camera. If the cameras are above each other,
//! `t` is minus the second row, and `P[1][3] = -fy b`.

use anyhow::{Result, bail, ensure};
use nalgebra::Matrix3;

use super::node::Value;
use super::number::list;
use super::rectified::Rectified;
use super::rig::{self, NO_SCALE, Pose, Unknowns, View};
use super::{Document, Files};
use crate::data::{LensModel, Meta, Rows};

/// The keys of a `camera_info`.
struct Keys {
    width: &'static [&'static str],
    height: &'static [&'static str],
    k: &'static [&'static str],
    d: &'static [&'static str],
    r: &'static [&'static str],
    p: &'static [&'static str],
}

const FILE: Keys = Keys {
    width: &["image_width"],
    height: &["image_height"],
    k: &["camera_matrix"],
    d: &["distortion_coefficients"],
    r: &["rectification_matrix"],
    p: &["projection_matrix"],
};

const ECHO: Keys = Keys {
    width: &["width"],
    height: &["height"],
    k: &["K", "k"],
    d: &["D", "d"],
    r: &["R", "r"],
    p: &["P", "p"],
};

/// One camera.
pub(super) struct Info<'a> {
    /// The camera. Region of interest and binning of the file are not read.
    view: View,
    r: Matrix3<f64>,
    p: [f64; 12],
    place_of_p: String,
    value: Value<'a>,
}

impl<'a> Info<'a> {
    fn of(value: Value<'a>, keys: &Keys) -> Result<Self> {
        let size = value.size_at(keys.width, keys.height)?;
        let lens = rig::lens_at(&value, &["distortion_model"])?;
        let d = value.get(keys.d);
        let none = d.as_ref().map_or(Ok(true), |d| d.numbers().map(|d| d.is_empty()))?;
        let k = rig::intrinsics(&value.need(keys.k, "a camera matrix (3 x 3)")?)?;
        let view = if none { View::pinhole(k, size) } else { View::of(k, lens, d.as_ref(), size)? };
        let r = rig::rotation(&value.need(keys.r, "a rectification matrix (3 x 3)")?)?;
        let (p, place_of_p) = projection(&value, keys)?;
        Ok(Self { view, r, p, place_of_p, value })
    }

    /// `-Tx / fx`, `-Ty / fy`: position of the camera, m.
    fn stands(&self) -> [f64; 2] {
        [-self.p[3] / self.p[0], -self.p[7] / self.p[5]]
    }

    /// The camera of its rectified images: only `P` is read.
    fn of_rectified(value: Value<'a>, keys: &Keys) -> Result<Self> {
        let (p, place_of_p) = projection(&value, keys)?;
        let [fx, _, cx, _, _, fy, cy, ..] = p;
        let size = value.size_at(keys.width, keys.height)?;
        let view = View::pinhole(rig::camera_matrix([fx, fy, cx, cy]), size);
        Ok(Self { view, r: Matrix3::identity(), p, place_of_p, value })
    }
}

/// `P`, and its place. An error unless fx and fy are above 0.
fn projection(value: &Value, keys: &Keys) -> Result<([f64; 12], String)> {
    let p = value.need(keys.p, "a projection matrix (3 x 4)")?;
    let numbers = p.shaped::<12>(3, 4)?;
    ensure!(
        numbers[0] > 0.0 && numbers[5] > 0.0,
        p.refuse("fx and fy are not above 0: the rig was never calibrated as a pair; calibrate it")
    );
    Ok((numbers, p.place().to_owned()))
}

/// Left and right; the position of the right camera tells them apart.
fn pair<'a>(
    files: &'a Files,
    keys: &Keys,
    read: fn(Value<'a>, &Keys) -> Result<Info<'a>>,
) -> Result<[Info<'a>; 2]> {
    let found = files.with(keys.p);
    let count = found.len();
    // Files without P are ignored if exactly two files have it. Otherwise all files are taken: of two files, the error
    // then names the one without P, and the key.
    let found = if count == 2 { found } else { files.values().collect() };
    ensure!(found.len() == 2, "{files}: expected two files, left and right, not {}", found.len());
    let mut infos = found.into_iter().map(|value| read(value, keys)).collect::<Result<Vec<_>>>()?;
    let (right, left) = (infos.pop(), infos.pop());
    let (Some(a), Some(b)) = (left, right) else { bail!("{files}: expected two files") };
    sorted([a, b])
}

fn sorted([a, b]: [Info<'_>; 2]) -> Result<[Info<'_>; 2]> {
    let [here, there] = [a.stands(), b.stands()];
    let is_origin = |place: [f64; 2]| place == [0.0, 0.0];
    match (is_origin(here), is_origin(there)) {
        (true, false) => right_of(a, b),
        (false, true) => right_of(b, a),
        (true, true) => bail!(
            "{} and {}: P[0][3] = P[1][3] = 0 of both cameras: they were calibrated one by one, not as a pair; calibrate them \
             together, so that the right one has P[0][3] = -fx b",
            a.place_of_p,
            b.place_of_p
        ),
        (false, false) => bail!(
            "{} and {}: P[0][3] = {} and {}, P[1][3] = {} and {}: both cameras have Tx or Ty, so they were calibrated one by one, \
             not as a pair; P[0][3] must be 0 for the left camera, and -fx b for the right one",
            a.place_of_p,
            b.place_of_p,
            a.p[3],
            b.p[3],
            a.p[7],
            b.p[7]
        ),
    }
}

fn right_of<'a>(left: Info<'a>, right: Info<'a>) -> Result<[Info<'a>; 2]> {
    let [x, y] = right.stands();
    ensure!(
        x > 0.0 || y.abs() > x.abs(),
        "{}: P[0][3] = {}: for the right camera it is -fx b, so below 0; if the files are exchanged, exchange them",
        right.place_of_p,
        right.p[3]
    );
    Ok([left, right])
}

/// `R` and `t` of the rectification matrices.
fn pose([left, right]: &[Info<'_>; 2]) -> Result<Pose> {
    let stands = right.stands();
    let length = stands[0].hypot(stands[1]);
    // The baseline is along the first or the second axis of the rectified frame.
    let rigid = rig::of_rectification([&left.r, &right.r], stands.map(|x| x / length));
    let mut pose = Pose::of(
        &rigid,
        &format!("{} and {}: the rectification matrices", left.value.place(), right.value.place()),
    )?;
    // The translation has unit length, because it is made of rows of a rotation. `P` gives the length of the baseline.
    pose.baseline_m = super::scale::known(length);
    Ok(pose)
}

fn meta(infos: [Info<'_>; 2], unit_m: f64, source: String) -> Result<Meta> {
    let pose = pose(&infos)?.in_unit(unit_m)?;
    rig::meta(infos.map(|info| info.view), &pose, source)
}

/// The whole rig from files.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    meta(pair(files, &FILE, Info::of)?, unknowns.unit_m, format!("ROS: {files}"))
}

/// The whole rig from texts.
pub(super) fn echoed(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    meta(pair(files, &ECHO, Info::of)?, unknowns.unit_m, format!("ROS: {files}"))
}

/// The rig of a pair's rectified images: `P` is the camera, without distortion, side by side or above each other.
pub(super) fn of_rectified(files: &Files) -> Result<Meta> {
    meta(pair(files, &FILE, Info::of_rectified)?, 1.0, format!("ROS, rectified: {files}"))
}

/// `left.yaml` and `right.yaml`.
pub(super) fn write(meta: &Meta, field_deg: Option<f64>) -> Result<Vec<Document>> {
    let Rectified { rotations: [r_l, r_r], projections: [p_l, p_r], .. } =
        Rectified::of(meta, field_deg)?;
    let ([lens_l, lens_r], [size_l, size_r]) = (meta.lenses(), meta.sizes());
    let comment = if meta.baseline_m.is_none() { NO_SCALE } else { "" };
    let left = camera_info("left", lens_l, size_l, &meta.k_l, &meta.dist_l, &r_l, &p_l);
    let right = camera_info("right", lens_r, size_r, &meta.k_r, &meta.dist_r, &r_r, &p_r);
    let left = rig::lens_yaw_comment(meta) + &left;
    Ok(vec![
        Document { name: "left.yaml", text: format!("{comment}{left}") },
        Document { name: "right.yaml", text: format!("{comment}{right}") },
    ])
}

fn camera_info(
    name: &str,
    lens: LensModel,
    [width, height]: [u16; 2],
    k: &Rows,
    dist: &[f64],
    r: &Rows,
    p: &[f64; 12],
) -> String {
    let model = match lens {
        LensModel::RadialTangential => "plumb_bob",
        LensModel::Fisheye => "equidistant",
        LensModel::Rational => "rational_polynomial",
    };
    let mut five = dist.to_vec();
    if lens == LensModel::RadialTangential {
        five.resize(5, 0.0);
    }
    let mat = |name: &str, cols: usize, numbers: &[f64]| {
        let rows = numbers.len() / cols;
        format!("{name}:\n  rows: {rows}\n  cols: {cols}\n  data: [{}]\n", list(numbers))
    };
    [
        format!("image_width: {width}\nimage_height: {height}\n"),
        format!("camera_name: {name}\n"),
        mat("camera_matrix", 3, &k.concat()),
        format!("distortion_model: {model}\n"),
        mat("distortion_coefficients", five.len(), &five),
        mat("rectification_matrix", 3, &r.concat()),
        mat("projection_matrix", 4, p),
    ]
    .concat()
}
