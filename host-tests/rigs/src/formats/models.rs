//! Models of structure from motion, of which two views make a rig: openMVG, OpenSfM, nerfstudio.
//!
//! openMVG: `rotation` and `center` of a pose, `x = R (X - C)`. OpenSfM: `rotation` (axis times angle) and `translation`
//! take points of the world to the camera; focal length and principal point are shares of the longer side, from the
//! image's centre. nerfstudio: `transform_matrix` takes points of a camera with the axes of OpenGL (y up, z back) to the
//! world; the corner of the first pixel is at `(0, 0)`. Lengths are in the unit of the model.

use anyhow::{Context, Result, bail, ensure};
use nalgebra::{Matrix3, Vector3};

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

use LensModel::{Fisheye, RadialTangential};

/// A view: the transform of the world to the camera, and the camera.
type Seen = (Rigid, View);

fn meta([left, right]: [Seen; 2], unknowns: Unknowns, what: &str, files: &Files) -> Result<Meta> {
    let way = left.0.inverse().then(&right.0);
    let pose = Pose::of(&way, &files.to_string())?.in_unit(unknowns.unit_m)?;
    rig::meta([left.1, right.1], &pose, format!("{what}: {files}"))
}

/// The views of the chosen ones.
fn two_of(
    all: &[Value],
    unknowns: Unknowns,
    place: &str,
    seen: impl Fn(&Value) -> Result<Seen>,
) -> Result<[Seen; 2]> {
    let [left, right] = rig::two(all, unknowns, place)?;
    Ok([seen(left)?, seen(right)?])
}

/// The rig of two views of openMVG.
pub(super) fn openmvg(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["sfm_data_version"])?;
    let list = |key: &str| Ok::<_, anyhow::Error>(file.need(&[key], "a list")?.items());
    let (views, cameras, poses) = (list("views")?, list("intrinsics")?, list("extrinsics")?);
    // A view that was not reconstructed has no pose.
    let posed = |view: &Value| {
        let pose = view.text_at(&["value.ptr_wrapper.data.id_pose"]);
        of_key(&poses, &pose, "the pose").is_ok()
    };
    let views: Vec<Value> = views.into_iter().filter(posed).collect();
    let seen = |view: &Value| -> Result<Seen> {
        let view = view.need(&["value.ptr_wrapper.data"], "a view")?;
        let pose = of_key(&poses, &view.text_at(&["id_pose"]), "the pose")?;
        let r = rig::rotation(&pose.need(&["rotation"], "3 x 3 numbers")?)?;
        let c = pose.need(&["center"], "3 numbers")?.array::<3>("a position")?;
        let camera = of_key(&cameras, &view.text_at(&["id_intrinsic"]), "the intrinsics")?;
        Ok((Rigid { r, t: -(r * Vector3::from(c)) }, openmvg_view(&camera)?))
    };
    meta(two_of(&views, unknowns, file.place(), seen)?, unknowns, "openMVG", files)
}

/// The value of a key in a list of keys and values.
fn of_key<'a>(all: &[Value<'a>], key: &str, what: &str) -> Result<Value<'a>> {
    let found = all.iter().find(|one| one.text_at(&["key"]) == key);
    found
        .and_then(|one| one.get(&["value"]))
        .with_context(|| format!("{what} {key} is missing: expected it in sfm_data.json"))
}

fn openmvg_view(camera: &Value) -> Result<View> {
    let data = camera.need(&["ptr_wrapper.data"], "a camera")?;
    // The first models have their pinhole in `value0`.
    let pinhole = data.get(&["value0"]).unwrap_or_else(|| data.clone());
    let given = data.get(&["disto_k1", "disto_k3", "disto_t2", "fisheye"]);
    let numbers = given.as_ref().map_or(Ok(Vec::new()), Value::numbers)?;
    let is_fisheye = data.get(&["fisheye"]).is_some();
    let (lens, dist) = match *numbers.as_slice() {
        _ if is_fisheye => (Fisheye, numbers),
        [] => (RadialTangential, Vec::new()),
        [k1] => (RadialTangential, vec![k1, 0.0]),
        [k1, k2, k3] => (RadialTangential, vec![k1, k2, 0.0, 0.0, k3]),
        [k1, k2, k3, t1, t2] => (RadialTangential, vec![k1, k2, t1, t2, k3]),
        _ => bail!(data.refuse("expected a pinhole of openMVG, or its fisheye")),
    };
    let f = pinhole.number_at("focal_length")?;
    let [x, y] = pinhole.need(&["principal_point"], "2 numbers")?.array("a principal point")?;
    let size = pinhole.size_at(&["width"], &["height"])?;
    View::try_new([f, f, x, y], lens, &dist, size).with_context(|| camera.place().to_owned())
}

/// The rig of two shots of OpenSfM, in the first reconstruction.
pub(super) fn opensfm(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let all = files.find(&[""], "a list of reconstructions")?.items();
    let first = all.first().with_context(|| format!("{files}: no reconstruction"))?;
    let (shots, cameras) = (first.need(&["shots"], "shots")?, first.need(&["cameras"], "cameras")?);
    let names = shots.keys();
    let views: Vec<Value> =
        names.iter().map(|name| shots.need(&[name], "a shot")).collect::<Result<_>>()?;
    let seen = |shot: &Value| -> Result<Seen> {
        let r = rig::rotation(&shot.need(&["rotation"], "a rotation vector, rad")?)?;
        let t = shot.need(&["translation"], "3 numbers")?.array::<3>("a translation")?;
        let camera = cameras.need(&[&shot.text_at(&["camera"])], "the camera of the shot")?;
        Ok((Rigid { r, t: t.into() }, opensfm_view(&camera)?))
    };
    meta(two_of(&views, unknowns, shots.place(), seen)?, unknowns, "OpenSfM", files)
}

fn opensfm_view(camera: &Value) -> Result<View> {
    let model = camera.text_at(&["projection_type"]);
    let (lens, keys): (_, &[&str]) = match model.as_str() {
        "perspective" => (RadialTangential, &["k1", "k2"]),
        "brown" => (RadialTangential, &["k1", "k2", "p1", "p2", "k3"]),
        "fisheye" | "fisheye_opencv" => (Fisheye, &["k1", "k2", "k3", "k4"]),
        _ => bail!(
            "{}: projection_type `{model}`: expected perspective, brown, fisheye or fisheye_opencv: calibrate with brown",
            camera.place()
        ),
    };
    let size = camera.size_at(&["width"], &["height"])?;
    let [w, h] = size.map(f64::from);
    let (longer, f) = (w.max(h), ["focal_x", "focal_y"].map(|key| camera.get(&[key, "focal"])));
    let [Some(fx), Some(fy)] = f else {
        bail!("{}: focal or focal_x is missing: expected a focal length", camera.place())
    };
    let shift = camera.numbers_or_0(&["c_x", "c_y"])?;
    let k = [
        fx.number()? * longer,
        fy.number()? * longer,
        shift[0] * longer + (w - 1.0) / 2.0,
        shift[1] * longer + (h - 1.0) / 2.0,
    ];
    View::try_new(k, lens, &camera.numbers_or_0(keys)?, size)
        .with_context(|| camera.place().to_owned())
}

/// The rig of two frames of nerfstudio.
pub(super) fn nerfstudio(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["frames"])?;
    let frames = file.need(&["frames"], "a list of frames")?;
    let seen = |frame: &Value| -> Result<Seen> {
        let to_world = frame.need(&["transform_matrix"], "4 x 4 numbers")?.transform()?;
        let axes = Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0));
        let to_world = Rigid { r: to_world.r * axes, ..to_world };
        Ok((to_world.inverse(), nerfstudio_view(&file, frame, unknowns)?))
    };
    meta(two_of(&frames.items(), unknowns, frames.place(), seen)?, unknowns, "nerfstudio", files)
}

/// The camera of a frame: its own keys, or those of the file.
fn nerfstudio_view(file: &Value, frame: &Value, unknowns: Unknowns) -> Result<View> {
    let of = |key: &str| frame.get(&[key]).or_else(|| file.get(&[key]));
    let number = |key: &str| -> Result<f64> {
        let place = || format!("{}: {key} is missing: expected a number", frame.place());
        of(key).with_context(place)?.number()
    };
    let model = of("camera_model").map_or_else(String::new, |model| model.text());
    let (lens, keys): (_, &[&str]) = match model.as_str() {
        "OPENCV_FISHEYE" => (Fisheye, &["k1", "k2", "k3", "k4"]),
        "" | "OPENCV" | "PINHOLE" | "SIMPLE_PINHOLE" => {
            (RadialTangential, &["k1", "k2", "p1", "p2", "k3"])
        }
        _ => bail!(
            "{}: camera_model {model}: expected OPENCV, PINHOLE or OPENCV_FISHEYE: calibrate with OPENCV",
            file.place()
        ),
    };
    let given: Vec<f64> =
        keys.iter().map(|key| of(key).map_or(Ok(0.0), |k| k.number())).collect::<Result<_>>()?;
    ensure!(
        lens == Fisheye || of("k4").map_or(Ok(0.0), |k4| k4.number())? == 0.0,
        "{}: k4 is of a fisheye: expected camera_model OPENCV_FISHEYE with it",
        file.place()
    );
    let [w, h] = [of("w"), of("h")].map(|n| n.map(|n| n.count()).transpose());
    let size = unknowns.size(0, w?.zip(h?).map(<[u16; 2]>::from), frame.place())?;
    let fy = if of("fl_y").is_some() { number("fl_y")? } else { number("fl_x")? };
    let k = [number("fl_x")?, fy, number("cx")? - 0.5, number("cy")? - 0.5];
    View::try_new(k, lens, &given, size).with_context(|| frame.place().to_owned())
}
