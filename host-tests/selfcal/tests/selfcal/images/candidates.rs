//! Several calibrations scored on the same matches.

use std::path::Path;

use crate::call::check;
use crate::images::scene::{K, SIZE, folders, moving, rig};

/// The rig of the scene, its right camera pitched by degrees.
fn pitched(path: &Path, degrees: f64) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let minus = -sin;
    let rows =
        format!("  - [1, 0, 0, -0.16]\n  - [0, {cos}, {minus}, 0]\n  - [0, {sin}, {cos}, 0]\n");
    rig(path, [(K, SIZE); 2], &rows)
}

#[test]
fn the_better_of_two_calibrations_is_named_with_its_significance_on_pairs_not_seen() {
    let dir = tempfile::tempdir().unwrap();
    let all = moving(6);
    folders(all.iter().map(|[l, r]| [l, r]), dir.path());
    let [good, off] = [("good.yaml", 0.0), ("off.yaml", 0.06)]
        .map(|(name, degrees)| pitched(&dir.path().join(name), degrees));
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
