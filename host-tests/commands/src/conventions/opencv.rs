//! OpenCV's `FileStorage` YAML, as the sample `stereo_calib.cpp` writes it.
//!
//! `x_2 = R x_1 + T` with the left camera first (`cv::stereoCalibrate`), so ours but for the length.
//! Image size and `fisheye_model` are the keys of the sample `camera_calibration.cpp`.

use std::fmt::Write;

use anyhow::{Context, Result, ensure};
use serde::Deserialize;

use super::mat::Mat;
use super::number::list;
use super::rectified::Rectified;
use super::rig::{self, LENS_YAW, NO_SCALE, Pose, Unknowns, View, square};
use super::{Document, Files, scale};
use host_tests::data::{LensModel, Meta};

/// The keys that are read; all others are ignored.
#[derive(Debug, Clone, Deserialize)]
struct Storage {
    #[serde(rename = "M1", alias = "K1")]
    m1: Option<Mat>,
    #[serde(rename = "D1")]
    d1: Option<Mat>,
    #[serde(rename = "M2", alias = "K2")]
    m2: Option<Mat>,
    #[serde(rename = "D2")]
    d2: Option<Mat>,
    #[serde(rename = "R")]
    r: Option<Mat>,
    #[serde(rename = "T")]
    t: Option<Mat>,
    image_width: Option<u16>,
    image_height: Option<u16>,
    fisheye_model: Option<u8>,
}

/// `R` and `T`.
pub(super) fn pose(files: &Files) -> Result<Pose> {
    let parsed = files.parsed()?;
    let r = find(&parsed, files, "R (3 x 3)", |s| s.r.as_ref(), square)?;
    let t = find(
        &parsed,
        files,
        "T (3 x 1)",
        |s| s.t.as_ref(),
        |numbers| {
            let t: [f64; 3] = numbers
                .try_into()
                .with_context(|| format!("{} numbers: 3 x 1 are expected", numbers.len()))?;
            Ok(t)
        },
    )?;
    Pose::of(r, t).with_context(|| format!("R and T of {files}"))
}

/// The whole rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let parsed: Vec<(String, Storage)> = files.parsed()?;
    let number = |of: fn(&Storage) -> Option<u16>| parsed.iter().find_map(|(_, s)| of(s));
    let written = number(|s| s.image_width).zip(number(|s| s.image_height));
    let size = unknowns.size.or(written.map(Into::into)).with_context(|| {
        format!(
            "{files}: no image_width and image_height: give the size of the images (--size W,H)"
        )
    })?;
    let fisheye = parsed.iter().any(|(_, s)| s.fisheye_model.is_some_and(|model| model != 0));
    let lens = if fisheye { LensModel::Fisheye } else { LensModel::RadialTangential };
    let view = |names: [&str; 2], of: [fn(&Storage) -> Option<&Mat>; 2]| -> Result<View> {
        let k = find(&parsed, files, names[0], of[0], square)?;
        find(&parsed, files, names[1], of[1], |given| View::of(k, lens, given, size))
    };
    let left = view(["M1 (3 x 3)", "D1 (1 x 5)"], [|s| s.m1.as_ref(), |s| s.d1.as_ref()])?;
    let right = view(["M2 (3 x 3)", "D2 (1 x 5)"], [|s| s.m2.as_ref(), |s| s.d2.as_ref()])?;
    let mut pose = pose(files)?;
    // The scale of 1 is that of 1 m only where the unit is.
    let unit = unknowns.unit_m;
    ensure!(unit.is_normal() && unit > 0.0, "the unit of T must be longer than 0 m, not {unit}");
    if unit.to_bits() != 1.0_f64.to_bits() {
        pose.baseline_m = Some(pose.baseline_m.unwrap_or(1.0) * unit);
    }
    rig::meta([left, right], &pose, format!("OpenCV: {files}"))
        .with_context(|| format!("the rig of {files}"))
}

/// The first matrix of that name, understood; errors name file and key.
fn find<T>(
    parsed: &[(String, Storage)],
    files: &Files,
    name: &str,
    of: impl Fn(&Storage) -> Option<&Mat>,
    understand: impl FnOnce(&[f64]) -> Result<T>,
) -> Result<T> {
    let (file, mat) = parsed
        .iter()
        .find_map(|(file, storage)| Some((file, of(storage)?)))
        .with_context(|| format!("{files}: there is no {name}"))?;
    mat.numbers().and_then(understand).with_context(|| format!("{file}: {name}"))
}

/// `intrinsics.yml` and `extrinsics.yml`.
pub(super) fn write(meta: &Meta) -> Result<Vec<Document>> {
    let rectified = Rectified::of(meta)?;
    let mut intrinsics = String::from("%YAML:1.0\n---\n");
    writeln!(intrinsics, "image_width: {}\nimage_height: {}", meta.width, meta.height)?;
    writeln!(intrinsics, "fisheye_model: {}", u8::from(meta.lens == LensModel::Fisheye))?;
    for (m, k, d, dist) in
        [("M1", &meta.k_l, "D1", &meta.dist_l), ("M2", &meta.k_r, "D2", &meta.dist_r)]
    {
        intrinsics.push_str(&mat(m, 3, &k.concat()));
        intrinsics.push_str(&mat(d, dist.len(), dist));
    }
    let mut extrinsics = String::from("%YAML:1.0\n---\n");
    extrinsics.push_str("# x_2 = R x_1 + T, the left camera is the first; T in metres.\n");
    if meta.baseline_m.is_none() {
        extrinsics.push_str(NO_SCALE);
    }
    let [r1, r2] = rectified.rotations;
    let [p1, p2] = rectified.projections;
    extrinsics.push_str(&mat("R", 3, &meta.r.concat()));
    extrinsics.push_str(&mat("T", 1, &scale::scaled(meta.t, meta.baseline_m)));
    extrinsics.push_str(&mat("R1", 3, &r1.concat()));
    extrinsics.push_str(&mat("R2", 3, &r2.concat()));
    extrinsics.push_str(&mat("P1", 4, &p1));
    extrinsics.push_str(&mat("P2", 4, &p2));
    extrinsics.push_str(&mat("Q", 4, &rectified.reprojection));
    if let Some(a) = meta.lens_yaw() {
        writeln!(extrinsics, "{LENS_YAW}lens_yaw: {a:?}")?;
    }
    Ok(vec![
        Document { name: "intrinsics.yml", text: intrinsics },
        Document { name: "extrinsics.yml", text: extrinsics },
    ])
}

/// A matrix of so many columns.
fn mat(name: &str, cols: usize, numbers: &[f64]) -> String {
    let rows = numbers.len() / cols;
    let lines: Vec<String> = numbers.chunks(cols).map(list).collect();
    let data = lines.join(",\n       ");
    format!(
        "{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {data} ]\n"
    )
}
