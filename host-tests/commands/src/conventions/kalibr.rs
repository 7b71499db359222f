//! Kalibr's `camchain.yaml`: pinhole cameras with radtan or equidistant lenses.
//!
//! `T_cn_cnm1` of cam1 takes points of cam0 to cam1, in metres: `[R b t; 0 1]` with cam0 left.
//! Kalibr's radtan is `k1 k2 p1 p2`, without `k3`.

use std::fmt::Write;

use anyhow::{Context, Result, bail, ensure};
use serde::Deserialize;

use super::number::list;
use super::rig::{self, NO_SCALE, Pose, Unknowns, View, camera_matrix};
use super::{Document, Files, scale};
use host_tests::data::Rows;
use host_tests::data::{LensModel, Meta};

/// The keys of a camera that are read; all others are ignored.
#[derive(Debug, Clone, Deserialize)]
struct Cam {
    camera_model: String,
    intrinsics: Vec<f64>,
    distortion_model: String,
    #[serde(default)]
    distortion_coeffs: Vec<f64>,
    resolution: [u16; 2],
    #[serde(rename = "T_cn_cnm1")]
    transform: Option<Vec<Vec<f64>>>,
}

/// The first two cameras; all others are ignored.
#[derive(Debug, Clone, Deserialize)]
struct Chain {
    cam0: Cam,
    cam1: Cam,
}

fn chain(files: &Files) -> Result<Chain> {
    match files.parsed()?.as_slice() {
        [(_, chain)] => Ok(Chain::clone(chain)),
        several => bail!("{files}: a camchain is one file, not {}", several.len()),
    }
}

/// `R` and `t` of `T_cn_cnm1`.
pub(super) fn pose(files: &Files) -> Result<Pose> {
    let chain = chain(files)?;
    let read = || -> Result<Pose> {
        let rows = chain.cam1.transform.as_ref().context("is missing: 4 x 4 are expected")?;
        let rows: Vec<[f64; 4]> = rows
            .iter()
            .map(|row| row.as_slice().try_into())
            .collect::<Result<_, _>>()
            .context("has a row that is not of 4 numbers")?;
        let [a, b, c, last]: [[f64; 4]; 4] = rows.try_into().ok().context("has not 4 rows")?;
        let homogeneous = last.iter().zip([0.0, 0.0, 0.0, 1.0]).all(|(a, b)| (a - b).abs() < 1e-9);
        ensure!(homogeneous, "has {last:?} for its last row, not [0, 0, 0, 1]");
        let r = [a, b, c].map(|[x, y, z, _]| [x, y, z]);
        Pose::of(r, [a, b, c].map(|[.., t]| t))
    };
    read().with_context(|| format!("{files}: T_cn_cnm1 of cam1"))
}

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    ensure!(
        unknowns == Unknowns::default(),
        "{files}: a camchain has the size of its images, and is in metres"
    );
    let chain = chain(files)?;
    let view = |name: &str, cam: &Cam| view(cam).with_context(|| format!("{files}: {name}"));
    let views = [view("cam0", &chain.cam0)?, view("cam1", &chain.cam1)?];
    rig::meta(views, &pose(files)?, format!("Kalibr: {files}"))
        .with_context(|| format!("the rig of {files}"))
}

fn view(cam: &Cam) -> Result<View> {
    ensure!(
        cam.camera_model == "pinhole",
        "camera_model {}: pinhole is handled, omni, eucm and ds are not",
        cam.camera_model
    );
    let lens = match cam.distortion_model.as_str() {
        "radtan" | "none" => LensModel::RadialTangential,
        "equidistant" => LensModel::Fisheye,
        other => bail!("distortion_model {other}: radtan, equidistant and none are handled"),
    };
    let intrinsics: [f64; 4] = cam.intrinsics.as_slice().try_into().with_context(|| {
        format!("{} intrinsics: fu fv pu pv are expected", cam.intrinsics.len())
    })?;
    View::of(camera_matrix(intrinsics), lens, &cam.distortion_coeffs, cam.resolution)
        .context("distortion_coeffs")
}

/// `camchain.yaml`.
pub(super) fn write(meta: &Meta) -> Result<Vec<Document>> {
    let mut text = String::from("# T_cn_cnm1: points of cam0 (left) to cam1 (right), metres.\n");
    if meta.baseline_m.is_none() {
        text.push_str(NO_SCALE);
    }
    text.push_str(&rig::lens_yaw_comment(meta));
    text.push_str(&cam("cam0", meta, &meta.k_l, &meta.dist_l)?);
    text.push_str(&cam("cam1", meta, &meta.k_r, &meta.dist_r)?);
    text.push_str("  T_cn_cnm1:\n");
    let scaled = scale::scaled(meta.t, meta.baseline_m);
    for ([x, y, z], t) in meta.r.into_iter().zip(scaled) {
        writeln!(text, "  - [{}]", list(&[x, y, z, t]))?;
    }
    writeln!(text, "  - [{}]", list(&[0.0, 0.0, 0.0, 1.0]))?;
    Ok(vec![Document { name: "camchain.yaml", text }])
}

fn cam(name: &str, meta: &Meta, k: &Rows, dist: &[f64]) -> Result<String> {
    let (model, coefficients) = match meta.lens {
        LensModel::Fisheye => ("equidistant", dist),
        LensModel::Rational => {
            bail!("{name} has a rational lens, which Kalibr has not: use opencv or ros")
        }
        LensModel::RadialTangential => {
            let (four, k3) = dist.split_at(dist.len().min(4));
            ensure!(
                k3.iter().all(|&k| k == 0.0),
                "{name} has a lens coefficient k3, which Kalibr's radtan has not: use opencv or ros"
            );
            ("radtan", four)
        }
    };
    let [[fx, _, cx], [_, fy, cy], _] = k;
    let mut text = format!("{name}:\n  cam_overlaps: [{}]\n", u8::from(name == "cam0"));
    writeln!(text, "  camera_model: pinhole\n  distortion_model: {model}")?;
    writeln!(text, "  distortion_coeffs: [{}]", list(coefficients))?;
    writeln!(text, "  intrinsics: [{}]", list(&[*fx, *fy, *cx, *cy]))?;
    writeln!(text, "  resolution: [{}, {}]", meta.width, meta.height)?;
    writeln!(text, "  rostopic: /{name}/image_raw")?;
    Ok(text)
}
