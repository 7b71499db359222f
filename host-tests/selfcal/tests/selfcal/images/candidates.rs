//! Several calibrations scored on the same matches.

use std::fs;
use std::path::Path;

use crate::call::check;
use crate::images::scene::{FOCAL, PRINCIPAL, SIZE, folders, moving};

/// The rig of the scene, its right camera pitched by degrees.
fn rig(top: &Path, name: &str, degrees: f64) -> String {
    let [cx, cy] = PRINCIPAL;
    let (sin, cos) = degrees.to_radians().sin_cos();
    let [width, height] = SIZE;
    let cam = format!(
        "  camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]\n  intrinsics: [{FOCAL}, {FOCAL}, {cx}, {cy}]\n  resolution: \
         [{width}, {height}]\n"
    );
    let rows = format!(
        "  - [1, 0, 0, -0.16]\n  - [0, {cos}, {}, 0]\n  - [0, {sin}, {cos}, 0]\n  - [0, 0, 0, 1]\n",
        -sin
    );
    let path = top.join(name);
    fs::write(&path, format!("cam0:\n{cam}cam1:\n{cam}  T_cn_cnm1:\n{rows}")).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn the_better_of_two_calibrations_is_named_with_its_significance_on_pairs_not_seen() {
    let dir = tempfile::tempdir().unwrap();
    let all = moving(6);
    folders(all.iter().map(|[l, r]| [l, r]), dir.path());
    let [good, off] = [rig(dir.path(), "good.yaml", 0.0), rig(dir.path(), "off.yaml", 0.06)];
    let (json, said) = check(dir.path(), &["--rig", &off, "--rig", &good, "--hold-out"]);
    let scores = &json["scores"];
    assert_eq!(
        (&scores["pairs"], &scores["held_out"]),
        (&3.into(), &true.into()),
        "{json} {}",
        said.err
    );
    let first = &scores["comparisons"][0];
    assert_eq!((&first["better"], &first["significant"]), (&good.into(), &true.into()), "{scores}");
    let rows = |i: usize| scores["candidates"][i]["rows_px"].as_f64().unwrap();
    // 0.06 degrees are 1.3 px.
    assert!(rows(0) > 1.0 && rows(1) < 0.6 && rows(2) < 0.6, "{scores}");
    assert!(scores["candidates"][2]["name"].as_str().unwrap().contains("estimate"), "{scores}");
}
