//! The calibration that `DepthAI` reads from a Luxonis camera, in JSON.
//!
//! `extrinsics` take points of a camera to the camera of `toCameraSocket`, in centimetres. A socket of -1 or 255, or a
//! rotation of zeros, stands for no extrinsics. The extrinsics of a camera lead from socket to socket; the left and the
//! right camera are related through the first socket that both reach.

use anyhow::{Context, Result, bail, ensure};
use nalgebra::Vector3;

use super::Files;
use super::node::Value;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta};

/// Numbers of sockets that stand for no socket.
const NONE: [i32; 2] = [-1, 255];

/// Largest number of sockets in a chain of extrinsics; a wrong file may have a circular chain.
const MOST: usize = 16;

/// The left and right sockets on the vendor's boards.
const USUAL: [u8; 2] = [1, 2];

struct Socket<'a> {
    number: i32,
    value: Value<'a>,
}

/// The rig of a Luxonis camera.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let file = files.one(&["cameraData"])?;
    let data = file.need(&["cameraData"], "a list of sockets")?;
    let mut sockets = Vec::new();
    for item in data.items() {
        let [number, value] = <[Value; 2]>::try_from(item.items())
            .map_err(|_| item.refuse("expected a socket's number and its data"))?;
        sockets.push(Socket { number: whole(&number)?, value });
    }
    let [left, right] = sides(&file, unknowns)?;
    let find = |number: i32| {
        let found = sockets.iter().find(|socket| socket.number == number);
        found.with_context(|| {
            format!(
                "{}: socket {number} is missing: choose the left and the right one (--cameras)",
                data.place()
            )
        })
    };
    let [l, r] = [find(left)?, find(right)?];
    let way = way(&sockets, l, r)?;
    let pose =
        Pose::of(&way, &format!("{}: extrinsics of sockets {left} and {right}", data.place()))?;
    rig::meta([view(&l.value)?, view(&r.value)?], &pose, format!("Luxonis: {files}"))
}

/// The numbers of the left and the right socket.
fn sides(file: &Value, unknowns: Unknowns) -> Result<[i32; 2]> {
    if let Some(chosen) = unknowns.cameras {
        return Ok(chosen.map(i32::from));
    }
    let stereo = file.get(&["stereoRectificationData"]);
    let number = |key: &str| -> Result<Option<i32>> {
        let value = stereo.as_ref().and_then(|stereo| stereo.get(&[key]));
        let number = value.map(|value| whole(&value)).transpose()?;
        Ok(number.filter(|number| !NONE.contains(number)))
    };
    let sides = [number("leftCameraSocket")?, number("rightCameraSocket")?];
    Ok(match sides {
        [Some(left), Some(right)] => [left, right],
        _ => USUAL.map(i32::from),
    })
}

/// The sockets that the extrinsics of a camera lead to, its own socket first, and the transform of points to each, m.
fn ways<'a>(sockets: &'a [Socket<'a>], from: &'a Socket<'a>) -> Result<Vec<(i32, Rigid)>> {
    let mut ways = vec![(from.number, Rigid::NONE)];
    let mut here = from;
    while ways.len() < MOST {
        let extrinsics = here.value.need(&["extrinsics"], "the way to another socket")?;
        let to = whole(&extrinsics.need(&["toCameraSocket"], "a socket's number")?)?;
        let Some(next) = sockets.iter().find(|socket| socket.number == to && !NONE.contains(&to))
        else {
            break;
        };
        let r = extrinsics.need(&["rotationMatrix"], "3 x 3 numbers")?;
        if r.numbers()?.iter().all(|x| *x == 0.0) {
            // This camera was never calibrated against the next one.
            break;
        }
        let r = rig::rotation(&r)?;
        let t = extrinsics.need(&["translation"], "x, y and z, cm")?;
        let step = Rigid { r, t: Vector3::from(t.numbers_at(["x", "y", "z"])?) / 100.0 };
        let so_far = ways.last().map_or(Rigid::NONE, |(_, way)| *way);
        ways.push((to, so_far.then(&step)));
        here = next;
    }
    Ok(ways)
}

fn way(sockets: &[Socket<'_>], left: &Socket<'_>, right: &Socket<'_>) -> Result<Rigid> {
    let [from_left, from_right] = [ways(sockets, left)?, ways(sockets, right)?];
    for (number, way) in &from_left {
        if let Some((_, back)) = from_right.iter().find(|(other, _)| other == number) {
            return Ok(way.then(&back.inverse()));
        }
    }
    bail!(
        "{}: extrinsics: toCameraSocket leads neither from socket {} to {} nor both to a common one: calibrate the camera again, or choose \
         others (--cameras)",
        left.value.place(),
        left.number,
        right.number
    )
}

/// Names of the sockets by their numbers, and older ones.
#[rustfmt::skip]
const SOCKETS: [(&str, i32); 12] = [
    ("AUTO", -1), ("CAM_A", 0), ("CAM_B", 1), ("CAM_C", 2), ("CAM_D", 3), ("CAM_E", 4), ("CAM_F", 5), ("CAM_G", 6), ("CAM_H", 7),
    ("RGB", 0), ("LEFT", 1), ("RIGHT", 2),
];

/// Names of the kinds of cameras by their numbers.
const KINDS: [(&str, i32); 2] = [("PERSPECTIVE", 0), ("FISHEYE", 1)];

/// The number of a socket, or of a kind of camera, which may be written as its name.
#[expect(clippy::cast_possible_truncation, reason = "it is in range")]
fn whole(value: &Value) -> Result<i32> {
    let name = value.text().to_uppercase();
    let name = name.rsplit([':', '.']).next().unwrap_or_default();
    if let Some((_, number)) = SOCKETS.iter().chain(&KINDS).find(|(known, _)| *known == name) {
        return Ok(*number);
    }
    let number = value.number()?;
    let is_whole = number.fract() == 0.0 && number.abs() <= 1000.0;
    ensure!(is_whole, value.refuse("expected a small whole number"));
    Ok(number as i32)
}

fn view(of: &Value) -> Result<View> {
    let kind = of.get(&["cameraType"]).map(|kind| whole(&kind)).transpose()?.unwrap_or(0);
    let size = of.size_at(&["width"], &["height"])?;
    let k = rig::intrinsics(&of.need(&["intrinsicMatrix"], "3 x 3 numbers")?)?;
    let given = of.get(&["distortionCoeff"]);
    if kind != 1 {
        return View::of(k, LensModel::RadialTangential, given.as_ref(), size);
    }
    let given = given.context("distortionCoeff of a fisheye")?;
    let numbers = given.numbers()?;
    View::with(k, LensModel::Fisheye, numbers.get(..4).unwrap_or(&numbers), size)
        .map_err(|why| given.refuse(why))
}
