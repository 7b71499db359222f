//! Folders of known layouts with the calibrations of their data sets.

mod common;

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

use common::{FOCAL, SIZE, save, small};

fn check(top: &Path) -> Value {
    let arguments = ["check", top.to_str().unwrap(), "--json", "--keypoints", "800"];
    let output = Command::cargo_bin("selfcal-images").unwrap().args(arguments).output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{err}"))
}

fn fits(json: &Value) {
    assert_eq!(json["run"]["pairs"], 1, "{json}");
    assert_eq!(json["rig_guessed"], false);
    assert!(json["run"]["rms_px_before"].as_f64().unwrap() < 0.5, "{json}");
}

#[test]
fn euroc_kitti_and_middlebury_are_read_with_their_calibrations() {
    let [left, right] = small();
    let [width, height] = SIZE;
    let [cx, cy] = SIZE.map(|n| f64::from(n) / 2.0 - 0.5);
    let dir = tempfile::tempdir().unwrap();

    let euroc = dir.path().join("euroc");
    for (cam, image, x) in [("cam0", &left, 0.0), ("cam1", &right, 0.16)] {
        let folder = euroc.join("mav0").join(cam);
        fs::create_dir_all(folder.join("data")).unwrap();
        save(image, &folder.join("data/1403636579763555584.pgm"));
        let text = format!(
            "%YAML:1.0\nsensor_type: camera\nT_BS:\n  cols: 4\n  rows: 4\n  data: [0.0, -1.0, 0.0, 0.2,\n         1.0, 0.0, 0.0, {x},\n         \
             0.0, 0.0, 1.0, 0.0,\n         0.0, 0.0, 0.0, 1.0]\nrate_hz: 20\nresolution: [{width}, {height}]\n\
             camera_model: pinhole\nintrinsics: [{FOCAL}, {FOCAL}, {cx}, {cy}]\ndistortion_model: radial-tangential\n\
             distortion_coefficients: [0.0, 0.0, 0.0, 0.0]\n"
        );
        fs::write(folder.join("sensor.yaml"), text).unwrap();
    }
    fits(&check(&euroc));

    let kitti = dir.path().join("kitti");
    for (folder, image) in [("image_0", &left), ("image_1", &right)] {
        fs::create_dir_all(kitti.join(folder)).unwrap();
        save(image, &kitti.join(folder).join("000000.pgm"));
    }
    let p =
        |shift: f64| format!("{FOCAL:e} 0.0 {cx} {shift} 0.0 {FOCAL:e} {cy} 0.0 0.0 0.0 1.0 0.0");
    fs::write(kitti.join("calib.txt"), format!("P0: {}\nP1: {}\n", p(0.0), p(-FOCAL * 0.5)))
        .unwrap();
    fits(&check(&kitti));

    let middlebury = dir.path().join("middlebury");
    fs::create_dir(&middlebury).unwrap();
    save(&left, &middlebury.join("im0.pgm"));
    save(&right, &middlebury.join("im1.pgm"));
    let k = format!("[{FOCAL} 0 {cx}; 0 {FOCAL} {cy}; 0 0 1]");
    let text = format!(
        "cam0={k}\ncam1={k}\ndoffs=0\nbaseline=160\nwidth={width}\nheight={height}\nndisp=64\n"
    );
    fs::write(middlebury.join("calib.txt"), text).unwrap();
    fits(&check(&middlebury));
}
