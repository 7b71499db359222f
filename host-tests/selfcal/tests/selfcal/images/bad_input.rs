//! Bad input: each kind gives an error with its reason, or a counted skip.

use std::fs;
use std::path::{Path, PathBuf};

use image::imageops::{self, FilterType};
use image::{GrayImage, Luma};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rigs::data::Dataset;
use rigs::formats::{Unknowns, import};
use serde_json::Value;
use sim::wire::FrameReader;

use test_support::Ended;

use crate::call::{self, run};
use crate::images::scene::{FOCAL, SIZE, chess, folders, moving, save, small, turning};

/// `check` with the focal length of the small scene.
fn check(top: &Path) -> (Value, String, i32) {
    let (json, said) = call::check(top, &["--focal", &FOCAL.to_string()]);
    (json, said.err, said.status)
}

#[test]
fn left_and_right_exchanged_is_an_error_that_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let all = moving(4);
    folders(all.iter().map(|[l, r]| [r, l]), dir.path());
    let (_, err, status) = check(dir.path());
    assert!(status == 1 && err.contains("left and right are exchanged in all"), "{err}");
}

#[test]
fn pairs_exchanged_here_and_there_are_skipped_and_counted() {
    let dir = tempfile::tempdir().unwrap();
    let all = moving(4);
    folders(
        all.iter().enumerate().map(|(i, [l, r])| if i == 2 { [r, l] } else { [l, r] }),
        dir.path(),
    );
    let (json, err, _) = check(dir.path());
    assert_eq!(json["skipped"], "1 with left and right exchanged", "{err}");
    assert_eq!(json["run"]["pairs"], 3);
    assert!(err.contains("002.pgm and 002.pgm: left and right are exchanged"), "{err}");
}

/// The reasons of `check` for left and right images of these moments.
fn reasons(left: &[[GrayImage; 2]], right: &[[GrayImage; 2]]) -> (String, i32) {
    let dir = tempfile::tempdir().unwrap();
    folders(left.iter().zip(right).map(|([l, _], [_, r])| [l, r]), dir.path());
    let (json, _, status) = check(dir.path());
    (json["reasons"].to_string(), status)
}

#[test]
fn left_and_right_of_different_moments_are_told_and_those_of_one_are_not() {
    let all = moving(7);
    let (one, _) = reasons(&all[..6], &all[..6]);
    assert!(!one.contains("moments"), "{one}");
    for (left, right, moved) in
        [(&all[..6], &all[1..], "1 pair earlier"), (&all[2..], &all[..5], "2 pairs later")]
    {
        let (reasons, status) = reasons(left, right);
        assert!(reasons.contains("different moments") && reasons.contains(moved), "{reasons}");
        assert_eq!(status, 30);
    }
}

#[test]
fn left_and_right_of_different_moments_are_told_though_their_rows_differ_by_less_than_a_pixel() {
    let all = turning(5, 0.02);
    let (reasons, status) = reasons(&all[..4], &all[1..]);
    assert!(reasons.contains("1 pair earlier"), "{reasons}");
    assert_eq!(status, 30);
}

#[test]
fn a_cause_is_named_although_no_pair_can_be_fused() {
    // Each pair is two parts of one image of noise, 12 columns apart.
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut pair = || {
        let noise = GrayImage::from_fn(SIZE[0] / 4, SIZE[1] / 4, |_, _| Luma([rng.random()]));
        let image = imageops::resize(&noise, SIZE[0] + 12, SIZE[1], FilterType::CatmullRom);
        [0, 12].map(|x| imageops::crop_imm(&image, x, 0, SIZE[0], SIZE[1]).to_image())
    };
    let pairs: Vec<_> = (0..6).map(|_| pair()).collect();
    let dir = tempfile::tempdir().unwrap();
    folders(pairs.iter().map(|[l, r]| [l, r]), dir.path());
    let (json, _, status) = check(dir.path());
    assert_eq!((&json["unknown"], status), (&Value::from("cause_named"), 30), "{json}");
    let reason = json["reasons"][0].as_str().unwrap();
    assert!(reason.contains("no pair could be fused; likely cause: the same image"), "{reason}");
}

#[test]
fn black_misfit_and_broken_images_are_skipped_with_their_names() {
    let dir = tempfile::tempdir().unwrap();
    let [left, right] = small();
    folders((0..5).map(|_| [&left, &right]), dir.path());
    let place = |name: &str| dir.path().join(name);
    save(&GrayImage::new(SIZE[0], SIZE[1]), &place("left/001.pgm"));
    save(&GrayImage::new(64, 64), &place("right/002.pgm"));
    fs::write(place("left/003.pgm"), b"P5 427 370 255\nshort").unwrap();
    fs::remove_file(place("right/004.pgm")).unwrap();
    let (json, err, _) = check(dir.path());
    assert_eq!(
        json["skipped"],
        "1 without a partner, 1 that cannot be read, 1 of another size, 1 that show nothing"
    );
    assert_eq!(json["run"]["pairs"], 1);
    for named in [
        "004.pgm: left image without",
        "003.pgm",
        "the right image has 64 x 64",
        "all one grey value",
    ] {
        assert!(err.contains(named), "{named}: {err}");
    }
}

#[test]
fn a_rig_of_another_shape_no_rig_and_no_images_are_errors_that_help() {
    let dir = tempfile::tempdir().unwrap();
    let [left, right] = small();
    folders([[&left, &right]], dir.path());
    let (_, said) = call::check(dir.path(), &["--rig", "opencv_chess_sift"]);
    assert!(said.status == 1 && said.err.contains("the shapes differ"), "{}", said.err);
    let Ended { err, status, .. } = run(&["check", dir.path().to_str().unwrap()]);
    assert!(status == 1 && err.contains("--rig FILE") && err.contains("--focal"), "{err}");
    let empty = tempfile::tempdir().unwrap();
    let err = run(&["check", empty.path().to_str().unwrap()]).err;
    assert!(err.contains("no left and right images"), "{err}");
    let err = run(&["check", "chesss"]).err;
    assert!(err.contains("shipped images (chess, motorcycle, aloe)"), "{err}");
}

#[test]
fn a_guess_from_a_focal_length_has_a_clear_warning() {
    let dir = tempfile::tempdir().unwrap();
    let [left, right] = small();
    folders([[&left, &right]], dir.path());
    let (json, err, _) = check(dir.path());
    assert_eq!(json["rig_guessed"], true);
    assert!(err.contains("THE RIG IS A GUESS") && err.contains("cannot be trusted"), "{err}");
    assert!(json["reasons"].to_string().contains("a guess"), "{json}");
}

#[test]
fn four_pairs_of_the_chessboard_calibrate_and_every_output_is_written_and_reads_back() {
    let dir = tempfile::tempdir().unwrap();
    let place = |name: &str| -> PathBuf { dir.path().join(name) };
    for side in ["left", "right"] {
        fs::create_dir(place(side)).unwrap();
        for path in &chess(side)[..4] {
            fs::copy(path, place(side).join(path.file_name().unwrap())).unwrap();
        }
    }
    let text = |name: &str| place(name).to_str().unwrap().to_owned();
    let [left, right, page, rig, set, frames] =
        ["left", "right", "page", "rig", "set", "frames.scmf"].map(text);
    let given = ["images", &left, &right, "--rig", "opencv_chess_sift"];
    let outputs = ["--report", &page, "--rig-out", &rig, "--out", &set, "--frames", &frames];
    let Ended { out, err, status } = run(&[&given[..], &outputs].concat());
    assert_eq!(status, 0, "{err}");
    assert!(out.contains("4 of 4") && out.contains("fused rotation from the start"), "{out}");
    let html = fs::read_to_string(place("page/index.html")).unwrap();
    for part in ["R from the start", "Before and after", "data:image/jpeg", "Dense disparities"] {
        assert!(html.contains(part), "{part}");
    }
    let files = ["rig/opencv/intrinsics.yml", "rig/opencv/extrinsics.yml"].map(place);
    import(&files, Unknowns::default()).unwrap();
    let saved = Dataset::load(&place("set")).unwrap();
    assert_eq!(saved.pairs.len(), 4);
    let sent = fs::read(place("frames.scmf")).unwrap();
    let decoded: Vec<_> = FrameReader::new(&sent[..]).map(Result::unwrap).collect();
    assert_eq!(decoded.len(), 4);
    assert_eq!(decoded[0].matches.len(), saved.pairs[0].len());
    let Ended { err, status, .. } = run(&[&given[..], &["--frames", &frames]].concat());
    assert!(status == 1 && err.contains("nothing is overwritten"), "{err}");
}
