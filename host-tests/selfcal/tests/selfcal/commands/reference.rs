//! The reference of a run: absent, incomplete, or in the opposite convention.

use std::fs;
use std::path::Path;

use rigs::data::Dataset;
use serde_json::{Map, Value, json};

use crate::call::{failure, json, scene, stdout};

/// Words of the error of a `t` that points to the right.
const OTHER: [&str; 3] = ["points to the right", "t = (-1, 0, 0)", "use -R t"];

/// A copy of a shipped set with its `meta.json` changed.
fn with_meta(dir: &Path, change: impl Fn(&mut Map<String, Value>)) -> String {
    let set = Dataset::load(&Dataset::shipped().join("opencv_chess_corners")).unwrap();
    let copy = dir.join("copy");
    set.save(&copy).unwrap();
    let path = copy.join("meta.json");
    let mut meta: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    change(meta.as_object_mut().unwrap());
    fs::write(&path, meta.to_string()).unwrap();
    copy.to_str().unwrap().to_owned()
}

#[test]
fn without_a_reference_the_estimate_is_the_same_and_has_no_errors() {
    let dir = tempfile::tempdir().unwrap();
    let copy = with_meta(dir.path(), |meta| {
        meta.remove("R").and(meta.remove("t")).unwrap();
    });
    let [known, unknown] =
        ["opencv_chess_corners", &copy].map(|set| json(&["replay", set, "--json"]));
    for same in ["R", "t", "sd_rotation", "rms_px_after", "state", "sigma_pairs"] {
        assert_eq!(known[same], unknown[same], "{same}");
    }
    for error in ["e_t", "e_theta", "sigma_t", "tracked_theta"] {
        assert!(known[error].is_f64() && unknown[error].is_null(), "{error}");
    }
    assert!(unknown["in_use"]["e_t"].is_null());
    let page = dir.path().join("page");
    stdout(&["replay", &copy, "--report", page.to_str().unwrap()]);
    assert!(failure(&["replay", &copy, "--view", "top"], 1).contains("lacks"));
}

#[test]
fn the_text_without_a_reference_says_so_and_says_the_rest() {
    let dir = tempfile::tempdir().unwrap();
    let copy = with_meta(dir.path(), |meta| {
        meta.remove("R").and(meta.remove("t")).unwrap();
    });
    let [known, unknown] = ["opencv_chess_corners", &copy].map(|set| stdout(&["replay", set]));
    assert!(unknown.contains("\nreference          none: no errors\n"), "{unknown}");
    assert!(unknown.contains(" deg, a rotation vector\nt                  (-0.99"), "{unknown}");
    assert!(unknown.contains("\npairs alone        13 of 13 have an estimate\n"), "{unknown}");
    assert!(!known.contains("\nreference"), "{known}");
    for gone in ["\ne_t ", "\ne_theta", "\nsigma_t", "\ntracked"] {
        assert!(known.contains(gone) && !unknown.contains(gone), "{gone}: {unknown}");
    }
    let says =
        ["pairs fused        13 of 13 (locked)", "sd of R, claimed", "RMS row offset", "within"];
    for line in known.lines().filter(|line| says.iter().any(|says| line.starts_with(says))) {
        assert!(unknown.contains(line), "{line}: {unknown}");
    }
    assert!(says.iter().all(|says| unknown.contains(says)), "{unknown}");
}

#[test]
fn half_a_reference_is_refused() {
    for (gone, said) in [("R", "t without R"), ("t", "R without t")] {
        let dir = tempfile::tempdir().unwrap();
        let copy = with_meta(dir.path(), |meta| drop(meta.remove(gone).unwrap()));
        let error = failure(&["replay", &copy], 1);
        assert!(error.contains(said) && error.contains("meta.json"), "{error}");
    }
}

#[test]
fn a_t_of_the_other_convention_is_named_wherever_extrinsics_are_read() {
    let dir = tempfile::tempdir().unwrap();
    let named = |args: &[&str], place: &str| {
        let error = failure(args, 1);
        assert!(OTHER.iter().all(|words| error.contains(words)), "{error}");
        assert!(error.contains(place), "{error}");
    };
    // The reference of a data set, and that of a rig for matches.
    let flipped = with_meta(dir.path(), |meta| {
        meta.insert("t".into(), json!([1.0, 0.0, 0.0]));
    });
    named(&["replay", &flipped], "meta.json");
    named(&["replay", "-", "--rig", &flipped], "meta.json");
    named(&["export", &flipped, "--format", "ros", "--out", "nowhere"], "meta.json");
    // The start: any length, JSON and YAML.
    let file = |name: &str, text: &str| {
        let path = dir.path().join(name);
        fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let start = file("start.json", r#"{"R": [[1,0,0],[0,1,0],[0,0,1]], "t": [0.12,0.01,0]}"#);
    named(&["replay", "opencv_chess_corners", "--initial", &start], "start.json");
    let chain = "cam0: &camera
  {camera_model: pinhole, intrinsics: [400, 400, 320, 240], distortion_model: radtan,
   distortion_coeffs: [0, 0, 0, 0], resolution: [640, 480]}
cam1:
  {camera_model: pinhole, intrinsics: [400, 400, 320, 240], distortion_model: radtan,
   distortion_coeffs: [0, 0, 0, 0], resolution: [640, 480],
   T_cn_cnm1: [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}
";
    let chain = file("camchain.yaml", chain);
    named(&["replay", "opencv_chess_corners", "--initial", &chain], "camchain.yaml");
    named(&["import", &chain, "--out", "nowhere.json"], "");
    // The rig of one pair.
    let (_set, set) = scene("step", &["--pairs", "4"]);
    let rigs = format!("{set}/rigs.csv");
    let text = fs::read_to_string(&rigs).unwrap();
    let mut lines: Vec<String> = text.lines().map(String::from).collect();
    lines[3] = "1,0,0,0,1,0,0,0,1,1,0,0".into();
    fs::write(&rigs, lines.join("\n")).unwrap();
    named(&["replay", &set], "rigs.csv: rig of pair 2");
}
