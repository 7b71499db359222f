//! Two cameras that differ in size and focal length, in their lenses, or in their mounting.

use std::fs;

use image::{GrayImage, imageops};

use crate::images::scene::{K, SIDE_BY_SIDE, SIZE, fits, folders, moving, rig};

/// Turns an image like its camera.
type Turn = fn(&GrayImage) -> GrayImage;

#[test]
fn sizes_and_focal_lengths_may_differ() {
    let dir = tempfile::tempdir().unwrap();
    let half = SIZE.map(|n| n / 2);
    let all: Vec<[GrayImage; 2]> = moving(3)
        .into_iter()
        .map(|[left, right]| {
            [left, imageops::resize(&right, half[0], half[1], imageops::FilterType::Triangle)]
        })
        .collect();
    folders(all.iter().map(|[l, r]| [l, r]), dir.path());
    let scale = [0, 1].map(|i| f64::from(half[i]) / f64::from(SIZE[i]));
    let [fx, fy, cx, cy] = K;
    let small =
        [fx * scale[0], fy * scale[1], (cx + 0.5) * scale[0] - 0.5, (cy + 0.5) * scale[1] - 0.5];
    let rig = rig(&dir.path().join("camchain.yaml"), [(K, SIZE), (small, half)], SIDE_BY_SIDE);
    fits(0.8, dir.path(), &["--rig", &rig]);
    // `images` also writes frames and a page from these images, and `replay` reads the frames.
    let [frames, page] =
        ["frames.scmf", "page"].map(|name| dir.path().join(name).to_str().unwrap().to_owned());
    let place = dir.path().to_str().unwrap();
    let outputs = ["--frames", &frames, "--report", &page, "--keypoints", "500"];
    let said = crate::call::run(&[&["images", place, "--rig", &rig][..], &outputs].concat());
    assert_eq!(said.status, 0, "{}", said.err);
    let json = crate::call::json(&["replay", &frames, "--rig", &rig, "--json"]);
    assert_eq!(json["pairs"], 3);
}

#[test]
fn the_right_camera_may_be_upside_down_or_on_its_side() {
    let [w, h] = SIZE.map(f64::from);
    let [fx, fy, cx, cy] = K;
    let cases: [(Turn, [f64; 4], [u32; 2], &str); 3] = [
        (
            imageops::rotate180,
            [fx, fy, w - 1.0 - cx, h - 1.0 - cy],
            SIZE,
            "  - [-1, 0, 0, 0.12]\n  - [0, -1, 0, 0]\n  - [0, 0, 1, 0]\n",
        ),
        // Clockwise: x goes down, y to the left.
        (
            imageops::rotate90,
            [fy, fx, h - 1.0 - cy, cx],
            [SIZE[1], SIZE[0]],
            "  - [0, -1, 0, 0]\n  - [1, 0, 0, -0.12]\n  - [0, 0, 1, 0]\n",
        ),
        (
            imageops::rotate270,
            [fy, fx, cy, w - 1.0 - cx],
            [SIZE[1], SIZE[0]],
            "  - [0, 1, 0, 0]\n  - [-1, 0, 0, 0.12]\n  - [0, 0, 1, 0]\n",
        ),
    ];
    for (turn, intrinsics, size, rows) in cases {
        let dir = tempfile::tempdir().unwrap();
        let all: Vec<[GrayImage; 2]> =
            moving(3).into_iter().map(|[left, right]| [left, turn(&right)]).collect();
        folders(all.iter().map(|[l, r]| [l, r]), dir.path());
        let rig = rig(&dir.path().join("camchain.yaml"), [(K, SIZE), (intrinsics, size)], rows);
        fits(0.8, dir.path(), &["--rig", &rig]);
    }
}

#[test]
fn cameras_above_each_other_are_calibrated_too() {
    // The scene on its side: the right camera is below the left one.
    let dir = tempfile::tempdir().unwrap();
    let all: Vec<[GrayImage; 2]> =
        moving(3).into_iter().map(|pair| pair.map(|image| imageops::rotate90(&image))).collect();
    folders(all.iter().map(|[l, r]| [l, r]), dir.path());
    let [fx, fy, cx, cy] = K;
    let turned = [fy, fx, f64::from(SIZE[1]) - 1.0 - cy, cx];
    let size = [SIZE[1], SIZE[0]];
    let rows = "  - [1, 0, 0, 0]\n  - [0, 1, 0, -0.12]\n  - [0, 0, 1, 0]\n";
    let rig = rig(&dir.path().join("camchain.yaml"), [(turned, size), (turned, size)], rows);
    fits(0.8, dir.path(), &["--rig", &rig]);
    // The page shows both views turned, with level rows.
    let page = dir.path().join("page");
    let said = crate::call::run(&[
        "images",
        dir.path().to_str().unwrap(),
        "--rig",
        &rig,
        "--keypoints",
        "500",
        "--report",
        page.to_str().unwrap(),
    ]);
    assert_eq!(said.status, 0, "{}", said.err);
    let html = fs::read_to_string(page.join("index.html")).unwrap();
    assert!(
        html.contains("Dense disparities") && !html.contains("No rectified camera sees"),
        "the pictures of a vertical rig"
    );
}
