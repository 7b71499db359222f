//! `selfcal replay --report`: the page of one recording.

use std::fs;
use std::path::Path;

use crate::call::{scene, stdout as selfcal};

fn csv(dir: &Path, name: &str) -> Vec<Vec<String>> {
    let path = dir.join("csv").join(name);
    let mut file = csv::Reader::from_path(path).unwrap();
    file.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect()
}

#[test]
fn a_page_of_a_data_set_has_every_part_and_the_numbers_of_the_run() {
    let dir = tempfile::tempdir().unwrap();
    let page = dir.path().join("page");
    let json =
        selfcal(&["replay", "opencv_chess_corners", "--json", "--report", page.to_str().unwrap()]);
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    let html = fs::read_to_string(page.join("index.html")).unwrap();
    for part in ["Outcome", "Pair by pair", "Coverage", "spheres", "rig/opencv/extrinsics.yml"] {
        assert!(html.contains(part), "{part} is missing");
    }
    let outcome = csv(&page, "outcome.csv");
    let value = |name: &str| {
        let row = outcome.iter().find(|row| row[0] == name).unwrap_or_else(|| panic!("{name}"));
        row[1].parse::<f64>().unwrap()
    };
    for (name, field, factor) in [
        ("R against the reference, e_theta", "e_theta", 1e3),
        ("standard deviation of t, reported", "sd_translation", 1e3),
        ("row offset of fitting matches after, RMS", "rms_px_after", 1.0),
    ] {
        let expected = json[field].as_f64().unwrap() * factor;
        assert!((value(name) - expected).abs() < 1e-9 * expected.abs(), "{name}");
    }
    let [_, y, _] = &csv(&page, "extrinsics.csv")[..] else { panic!("not three rows") };
    assert_eq!(y[4], json["t"][1].as_f64().unwrap().to_string());
    assert_eq!(y[2], json["R"][4].as_f64().unwrap().to_string());
    assert_eq!([csv(&page, "pairs.csv").len(), csv(&page, "states.csv").len()], [13, 13]);
    // Before and estimate, expected in px: no depths are known, and no length of the baseline.
    assert!(csv(&page, "depth.csv").iter().map(Vec::len).eq([2, 2]));
    let counted: u32 =
        csv(&page, "coverage.csv").iter().map(|row| row[3].parse::<u32>().unwrap()).sum();
    assert_eq!(counted, 2 * 13 * 54);
    // Thirteen pairs, the fused one, the reference.
    assert_eq!(csv(&page, "spheres.csv").len(), 15);
    assert!(html.contains("Kalibr&#39;s radtan") || html.contains("Kalibr's radtan"), "k3 unsaid");
    assert!(!page.join("rig/kalibr").exists());
}

#[test]
fn the_rig_of_the_page_starts_the_next_run() {
    let dir = tempfile::tempdir().unwrap();
    let page = dir.path().to_str().unwrap();
    selfcal(&["replay", "motorcycle_sift", "--view", "top", "--report", page]);
    for format in ["opencv", "ros", "kalibr"] {
        let rig = format!("{page}/rig/{format}");
        let args =
            ["replay", "motorcycle_sift", "--view", "top", "--initial", rig.as_str(), "--json"];
        let json: serde_json::Value = serde_json::from_str(&selfcal(&args)).unwrap();
        assert!(json["rms_px_before"].as_f64().unwrap() < 0.6, "{format}");
    }
}

#[test]
fn a_stream_and_a_generated_run_have_pages_too() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (stream, page, again) = (path("flight.scmf"), path("page"), path("again"));
    selfcal(&["record", "opencv_chess_sift", &stream]);
    selfcal(&["replay", &stream, "--rig", "opencv_chess_sift", "--report", &page]);
    assert_eq!(csv(Path::new(&page), "pairs.csv").len(), 13);
    let (_dir, set) = scene("step", &["--pairs", "12"]);
    let shown = selfcal(&["replay", &set, "--report", &again]);
    assert!(shown.contains("again/index.html"), "{shown}");
    let states = csv(Path::new(&again), "states.csv");
    assert!(states.iter().any(|row| row[1].starts_with("locked")), "{states:?}");
}
