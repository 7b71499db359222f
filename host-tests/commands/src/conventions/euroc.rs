//! `EuRoC`'s `sensor.yaml` of two cameras, in the order left, right.
//!
//! `T_BS` takes points of the camera to the body, in metres: `R = R_r^T R_l`, `b t = R_r^T (t_l - t_r)`.

use anyhow::{Context, Result, bail, ensure};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;

use super::Files;
use super::mat::Mat;
use super::rig::{self, Pose, Unknowns, View, camera_matrix};
use host_tests::data::rows;
use host_tests::data::{LensModel, Meta};

/// The keys that are read; all others are ignored.
#[derive(Debug, Clone, Deserialize)]
struct Sensor {
    #[serde(rename = "T_BS")]
    to_body: Mat,
    resolution: [u16; 2],
    camera_model: String,
    intrinsics: [f64; 4],
    distortion_model: String,
    distortion_coefficients: Vec<f64>,
}

fn sensors(files: &Files) -> Result<[(String, Sensor); 2]> {
    let all: Vec<(String, Sensor)> = files.parsed()?;
    all.try_into().map_err(|all: Vec<_>| {
        anyhow::anyhow!(
            "{files}: two sensor.yaml are expected, cam0 (left) and cam1, not {}",
            all.len()
        )
    })
}

/// `R` and `t` of the two `T_BS`.
pub(super) fn pose(files: &Files) -> Result<Pose> {
    let placed = |(name, sensor): &(String, Sensor)| -> Result<(Matrix3<f64>, Vector3<f64>)> {
        let m = sensor.to_body.shaped([4, 4]).with_context(|| format!("{name}: T_BS"))?;
        let at = |i: usize, j: usize| m[4 * i + j];
        Ok((Matrix3::from_fn(at), Vector3::from_fn(|i, _| at(i, 3))))
    };
    let [left, right] = sensors(files)?;
    let ((r_l, t_l), (r_r, t_r)) = (placed(&left)?, placed(&right)?);
    Pose::of(rows(&(r_r.transpose() * r_l)), (r_r.transpose() * (t_l - t_r)).into())
        .with_context(|| format!("T_BS of {files}"))
}

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    ensure!(
        unknowns == Unknowns::default(),
        "{files}: a sensor.yaml has the size of its images, and is in metres"
    );
    let [left, right] = sensors(files)?;
    let view = |(name, sensor): &(String, Sensor)| view(sensor).with_context(|| name.clone());
    rig::meta([view(&left)?, view(&right)?], &pose(files)?, format!("EuRoC: {files}"))
        .with_context(|| format!("the rig of {files}"))
}

fn view(sensor: &Sensor) -> Result<View> {
    ensure!(
        sensor.camera_model == "pinhole",
        "camera_model {}: pinhole is handled",
        sensor.camera_model
    );
    let lens = match sensor.distortion_model.as_str() {
        "radial-tangential" | "none" => LensModel::RadialTangential,
        "equidistant" => LensModel::Fisheye,
        other => bail!("distortion_model {other}: radial-tangential and equidistant are handled"),
    };
    let k = camera_matrix(sensor.intrinsics);
    View::of(k, lens, &sensor.distortion_coefficients, sensor.resolution)
        .context("distortion_coefficients")
}
