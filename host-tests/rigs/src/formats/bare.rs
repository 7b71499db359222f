//! Rigs of bare numbers, whose order is all that tells their meaning: `K.txt` of FoundationStereo, `calib.txt` of DSOL,
//! `camera.txt` of Stereo-DSO, and the three files of the SLAM benchmark of ETH3D.
//!
//! All but the last are rectified, with one camera for both sides and the baseline in metres. ETH3D: `fx fy cx cy` of
//! each camera, and in `extrinsics_1_2.txt` the three rows `[R t]` that take points of camera 2, the left one, to camera 1.

use anyhow::{Result, bail, ensure};
use nalgebra::{Matrix3, Vector3};

use super::Files;
use super::node::Value;
use super::rectified_sets::one_camera;
use super::rig::{self, Pose, Unknowns, View};
use super::rigid::Rigid;
use crate::data::{LensModel, Meta, check_camera_matrix};

/// Key of the rows of such a file.
pub(super) const KEY: &str = "bare numbers";

/// Expected numbers, for errors.
const EXPECTED: &str = "expected nine numbers of K and the baseline; or fx fy cx cy and the baseline; or the five lines of \
    Stereo-DSO; or fx fy cx cy in calibration.txt with calibration2.txt and extrinsics_1_2.txt beside it; metres";

/// The rig.
pub(super) fn rig(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let all = files.with(&[KEY]);
    let rows = all[0].need(&[KEY], "numbers")?;
    if rows.items().len() == 5 && rows.items()[1].numbers().is_ok_and(|size| size.len() == 2) {
        return stereo_dso(&rows, files, unknowns);
    }
    let source = format!("bare numbers: {files}");
    match *rows.numbers()?.as_slice() {
        [fx, fy, cx, cy, b] => {
            let k = rig::camera_matrix([fx, fy, cx, cy]);
            check_camera_matrix(&k).map_err(|why| rows.refuse(why))?;
            one_camera(k, b, &rows, unknowns, source)
        }
        [a, b, c, d, e, f, g, h, i, baseline] => {
            let k = [[a, b, c], [d, e, f], [g, h, i]];
            check_camera_matrix(&k).map_err(|why| rows.refuse(why))?;
            one_camera(k, baseline, &rows, unknowns, source)
        }
        [_, _, _, _] => eth3d(files, unknowns),
        ref numbers => bail!(rows.refuse(format!("{} numbers: {EXPECTED}", numbers.len()))),
    }
}

/// Five lines: `fx fy cx cy` and the lens, or the same as shares of the size; size; crop; size after it; baseline.
fn stereo_dso(rows: &Value, files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let lines = rows.items();
    let words = lines[0].text();
    let words = words.trim_matches(['[', ']']).replace(',', " ");
    let numbers: Vec<f64> = words.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    let [fx, fy, cx, cy, lens @ ..] = numbers.as_slice() else {
        bail!(lines[0].refuse("expected fx fy cx cy and the lens"));
    };
    ensure!(
        lens.iter().all(|k| *k == 0.0),
        lines[0].refuse(
            "expected rectified images, whose lens is 0: rectify them, or write K1 D1 K2 D2 R T"
        )
    );
    let size = lines[1].size()?;
    let mut k = [*fx, *fy, *cx, *cy];
    if *cx < 1.0 && *cy < 1.0 {
        let [w, h] = size.map(f64::from);
        k = [fx * w, fy * h, cx * w - 0.5, cy * h - 0.5];
    }
    let k = rig::camera_matrix(k);
    check_camera_matrix(&k).map_err(|why| lines[0].refuse(why))?;
    let unknowns = Unknowns { sizes: Some(unknowns.sizes.unwrap_or([size; 2])), ..unknowns };
    one_camera(k, lines[4].number()?, rows, unknowns, format!("Stereo-DSO: {files}"))
}

/// The three files of ETH3D's SLAM benchmark.
fn eth3d(files: &Files, unknowns: Unknowns) -> Result<Meta> {
    let mut files = files.clone();
    // Camera 2 is the left one.
    let names = ["calibration2.txt", "calibration.txt", "extrinsics_1_2.txt"];
    for name in names {
        let _ = files.beside(name);
    }
    let [Some(left), Some(right), Some(pose)] = names.map(|name| files.named(name)) else {
        bail!("{files}: four numbers: {EXPECTED}");
    };
    let view = |side: usize, file: &Value| -> Result<View> {
        let numbers = file.need(&[KEY], "fx fy cx cy")?;
        let k = numbers.array::<4>("fx fy cx cy")?;
        let size = unknowns.size(side, None, file.place())?;
        View::try_new(k, LensModel::RadialTangential, &[], size).map_err(|why| numbers.refuse(why))
    };
    let numbers = pose.need(&[KEY], "three rows of [R t]")?;
    let rows = numbers.array::<12>("three rows of [R t]")?;
    let at = |i: usize, j: usize| rows[4 * i + j];
    let way = Rigid { r: Matrix3::from_fn(at), t: Vector3::from_fn(|i, _| at(i, 3)) };
    way.check().map_err(|why| numbers.refuse(why))?;
    let pose = Pose::of(&way, pose.place())?;
    rig::meta([view(0, &left)?, view(1, &right)?], &pose, format!("ETH3D: {files}"))
}
