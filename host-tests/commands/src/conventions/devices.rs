//! Calibrations as stereo cameras give them out, in JSON: `RealSense` and Luxonis.
//!
//! `RealSense`: the fields of `rs2_intrinsics` under `left` and `right`, those of `rs2_extrinsics` (left to right,
//! `rotation` by columns, metres) under `extrinsics`. Luxonis: the calibration that `DepthAI` reads from a device;
//! `extrinsics` take points of a camera to that of `toCameraSocket`, in centimetres.

use anyhow::{Context, Result, bail, ensure};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::Files;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use host_tests::data::{LensModel, Meta};
use host_tests::data::{Rows, matrix, rows};

/// `rs2_intrinsics`.
#[derive(Debug, Clone, Deserialize)]
struct Intrinsics {
    width: u16,
    height: u16,
    ppx: f64,
    ppy: f64,
    fx: f64,
    fy: f64,
    #[serde(default)]
    model: String,
    #[serde(default)]
    coeffs: Vec<f64>,
}

/// `rs2_extrinsics`.
#[derive(Debug, Clone, Deserialize)]
struct Extrinsics {
    rotation: [f64; 9],
    translation: [f64; 3],
}

#[derive(Debug, Clone, Deserialize)]
struct RealSense {
    left: Intrinsics,
    right: Intrinsics,
    extrinsics: Extrinsics,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Luxonis {
    camera_data: Vec<(i32, Socket)>,
    stereo_rectification_data: Stereo,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Stereo {
    left_camera_socket: i32,
    right_camera_socket: i32,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Socket {
    #[serde(default)]
    camera_type: i32,
    distortion_coeff: Vec<f64>,
    extrinsics: ToSocket,
    intrinsic_matrix: Rows,
    width: u16,
    height: u16,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(rename_all = "camelCase")]
struct ToSocket {
    rotation_matrix: Rows,
    translation: Centimetres,
    to_camera_socket: i32,
}

#[derive(Debug, Clone, Copy, Deserialize)]
struct Centimetres {
    x: f64,
    y: f64,
    z: f64,
}

fn the<T>(files: &Files, mut all: Vec<(String, T)>) -> Result<T> {
    ensure!(all.len() == 1, "{files}: a calibration is one file, not {}", all.len());
    all.pop().map(|(_, one)| one).context("a calibration is one file")
}

/// The rig of a `RealSense`.
pub(super) fn realsense(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    complete(files, unknowns)?;
    let read: RealSense = the(files, files.parsed()?)?;
    let view = |name: &str, one: &Intrinsics| -> Result<View> {
        let model = one.model.to_lowercase();
        let (lens, given) = match model.rsplit('.').next().unwrap_or_default() {
            "kannala_brandt4" => (LensModel::Fisheye, one.coeffs.get(..4).unwrap_or_default()),
            "brown_conrady" | "none" | "" => (LensModel::RadialTangential, &one.coeffs[..]),
            _ if one.coeffs.iter().all(|k| *k == 0.0) => {
                (LensModel::RadialTangential, &one.coeffs[..])
            }
            other => bail!(
                "{files}: {name}: model {other}: brown_conrady and kannala_brandt4 are handled"
            ),
        };
        let k = camera_matrix([one.fx, one.fy, one.ppx, one.ppy]);
        View::of(k, lens, given, [one.width, one.height])
            .with_context(|| format!("{files}: {name}: coeffs"))
    };
    let r = Matrix3::from_column_slice(&read.extrinsics.rotation);
    let pose = Pose::of(rows(&r), read.extrinsics.translation)
        .with_context(|| format!("{files}: extrinsics of left to right"))?;
    rig::meta(
        [view("left", &read.left)?, view("right", &read.right)?],
        &pose,
        format!("RealSense: {files}"),
    )
}

/// The rig of a Luxonis camera.
pub(super) fn luxonis(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    complete(files, unknowns)?;
    let read: Luxonis = the(files, files.parsed()?)?;
    let Stereo { left_camera_socket: left, right_camera_socket: right } =
        read.stereo_rectification_data;
    let socket = |number: i32| {
        let mut all = read.camera_data.iter();
        let found = all.find(|(n, _)| *n == number).map(|(_, socket)| socket);
        found.with_context(|| format!("{files}: cameraData has no socket {number}"))
    };
    let [l, r] = [socket(left)?, socket(right)?];
    let view = |one: &Socket, number: i32| -> Result<View> {
        let lens =
            if one.camera_type == 1 { LensModel::Fisheye } else { LensModel::RadialTangential };
        let given = match lens {
            LensModel::Fisheye => one.distortion_coeff.get(..4).unwrap_or_default(),
            _ => &one.distortion_coeff[..],
        };
        View::of(one.intrinsic_matrix, lens, given, [one.width, one.height])
            .with_context(|| format!("{files}: distortionCoeff of socket {number}"))
    };
    let way = |one: &Socket| {
        let Centimetres { x, y, z } = one.extrinsics.translation;
        (matrix(&one.extrinsics.rotation_matrix), Vector3::new(x, y, z) / 100.0)
    };
    let (rotation, t) = if l.extrinsics.to_camera_socket == right {
        way(l)
    } else if r.extrinsics.to_camera_socket == left {
        let (rotation, t) = way(r);
        (rotation.transpose(), -(rotation.transpose() * t))
    } else {
        bail!("{files}: extrinsics lead neither from socket {left} to {right} nor back")
    };
    let pose =
        Pose::of(rows(&rotation), t.into()).with_context(|| format!("{files}: extrinsics"))?;
    rig::meta([view(l, left)?, view(r, right)?], &pose, format!("Luxonis: {files}"))
}

fn complete(files: &Files, unknowns: Unknowns) -> Result<()> {
    ensure!(unknowns == Unknowns::default(), "{files}: has the size of its images, and its unit");
    Ok(())
}
