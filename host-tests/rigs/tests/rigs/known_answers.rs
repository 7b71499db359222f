//! Known answers of all formats, from their numbers alone.
#![allow(clippy::float_cmp, reason = "numbers of a file come out as they are")]

use rigs::data::{LensModel, Meta};
use rigs::formats::{Unknowns, import};

use crate::samples::{Sample, samples};
use crate::{moved, written};

pub(super) fn read(sample: &Sample) -> anyhow::Result<Meta> {
    let (_dir, paths) = written(sample.files.iter().map(|(name, text)| (*name, text.as_str())));
    import(&paths, sample.unknowns)
}

pub(super) fn named(name: &str) -> Sample {
    samples().into_iter().find(|sample| sample.name == name).unwrap()
}

pub(super) fn near<const N: usize>(a: [f64; N], b: [f64; N]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12)
}

/// The same sample with one text replaced, which must occur.
pub(super) fn with(name: &str, from: &str, to: &str) -> Sample {
    let mut sample = named(name);
    let there = sample.files.iter().any(|(_, text)| text.contains(from));
    assert!(there, "{name} has no {from}");
    sample.files.iter_mut().for_each(|(_, text)| *text = text.replace(from, to));
    sample
}

#[test]
fn every_format_of_the_one_rig_moves_a_point_to_the_same_place() {
    for sample in samples().iter().filter(|sample| sample.is_the_rig) {
        let meta = read(sample).unwrap_or_else(|why| panic!("{}: {why:#}", sample.name));
        let at = moved(&meta, [0.0, 0.0, 5.0]);
        assert!(near(at, [-0.12, -2.99, 4.02]), "{}: {at:?}", sample.name);
    }
}

#[test]
fn rectifications_and_rectified_sets_give_their_own_rigs() {
    for name in ["ROS", "ROS echo", "ORB-SLAM2", "stella_vslam", "OpenCV rectification"] {
        let at = moved(&read(&named(name)).unwrap(), [1.0, 0.0, 5.0]);
        assert!(near(at, [0.8 - 0.12, -0.6, 5.0]), "{name}: {at:?}");
    }
    let meta = read(&named("Middlebury")).unwrap();
    assert_eq!((meta.t, meta.baseline_m, meta.k_r[0][2]), ([-1.0, 0.0, 0.0], Some(0.16), 320.0));
}

#[test]
fn the_colour_cameras_of_kitti_are_their_own() {
    let grey = read(&named("KITTI")).unwrap();
    assert!(near(grey.t, [-1.0, 0.0, 0.0]) && near([grey.baseline_m.unwrap()], [0.54]));
    let mut sample = named("KITTI");
    sample.unknowns.cameras = Some([2, 3]);
    let colour = read(&sample).unwrap();
    // P3 - P2: -378 px m across, 2.1 px m down.
    assert!(near(moved(&colour, [0.0; 3]), [-0.54, 0.003, 0.0]), "{colour:?}");
}

#[test]
fn lenses_and_cameras_match_the_files() {
    let basalt = read(&named("Basalt")).unwrap();
    assert_eq!(basalt.lens, LensModel::Fisheye);
    assert_eq!((basalt.k_r[0][0], basalt.dist_l), (381.0, vec![0.01, -0.013, 0.02, -0.01]));
    // In COLMAP the first pixel's centre is at half a pixel.
    for name in ["COLMAP", "COLMAP JSON"] {
        let colmap = read(&named(name)).unwrap();
        assert_eq!((colmap.k_l[0][2], colmap.k_r[1][2]), (367.0, 255.0));
    }
    // The first camera has the pose of the reference sensor here.
    let imu = with("COLMAP", "1 2 CAMERA 1 ", "1 3 IMU 7 CAMERA 1 1 1 0 0 0 0 0 0 ");
    let [imu, colmap] = [imu, named("COLMAP")].map(|sample| read(&sample).unwrap());
    assert_eq!((imu.k_l, imu.k_r, imu.r, imu.t), (colmap.k_l, colmap.k_r, colmap.r, colmap.t));
    let luxonis = read(&named("Luxonis")).unwrap();
    assert_eq!((luxonis.lens, luxonis.dist_l[7]), (LensModel::Rational, 0.16));
    let zed = read(&named("ZED")).unwrap();
    assert_eq!((zed.k_l[0][0], zed.k_r[0][2], zed.dist_r[1]), (700.5, 641.25, 0.026));
    let mut sample = named("ZED");
    sample.unknowns.sizes = Some([[672, 376]; 2]);
    assert_eq!(read(&sample).unwrap().k_l[0][0], 350.25);
}

#[test]
fn a_model_may_be_spelled_as_any_tool_spells_it() {
    for model in [
        "Brown Conrady",
        "brown_conrady",
        "distortion.brown_conrady",
        "RS2_DISTORTION_BROWN_CONRADY",
    ] {
        let meta = read(&with("RealSense", "Brown Conrady", model)).unwrap();
        assert_eq!(meta.dist_l[0], 0.01, "{model}");
    }
    for model in ["Kannala Brandt4", "kannala_brandt4", "RS2_DISTORTION_KANNALA_BRANDT4"] {
        let meta = read(&with("RealSense", "Brown Conrady", model)).unwrap();
        assert_eq!((meta.lens, meta.dist_l.len()), (LensModel::Fisheye, 4), "{model}");
    }
    let refused = read(&with("RealSense", "Brown Conrady", "F Theta")).unwrap_err();
    assert!(format!("{refused:#}").contains("F Theta"), "{refused:#}");
}

#[test]
fn fourteen_coefficients_are_fine_but_for_thin_prism_and_tilt() {
    let meta =
        read(&with("Luxonis", "0.16, 0, 0, 0, 0, 0, 0]", "0.16, 0, 0, 0, 0, 0, 0.0]")).unwrap();
    assert_eq!(meta.dist_l.len(), 8);
    for (k, name) in [("0.16, 0.02, 0, 0, 0, 0, 0]", "s1"), ("0.16, 0, 0, 0, 0, 0, 0.01]", "tau_y")]
    {
        let why =
            format!("{:#}", read(&with("Luxonis", "0.16, 0, 0, 0, 0, 0, 0]", k)).unwrap_err());
        assert!(
            why.contains("calib.json: cameraData: [1]: [1]: distortionCoeff") && why.contains(name),
            "{why}"
        );
    }
}

#[test]
fn the_sockets_that_a_file_names_and_those_that_are_asked_for_are_taken() {
    let mut sample = with(
        "Luxonis",
        "\"leftCameraSocket\": 255, \"rightCameraSocket\": -1",
        "\"leftCameraSocket\": 1, \"rightCameraSocket\": 0",
    );
    let meta = read(&sample).unwrap();
    assert!(near(moved(&meta, [0.0; 3]), [-0.07, 0.01, 0.02]), "{meta:?}");
    sample.unknowns.cameras = Some([0, 2]);
    assert!(near(moved(&read(&sample).unwrap(), [0.0; 3]), [-0.05, 0.0, 0.0]));
}

#[test]
fn openvins_may_have_the_way_from_the_imu_instead() {
    // The left camera frame is the IMU frame, so the transform from the IMU to the right camera is R and T.
    let cam = |n: usize, rows: &str| {
        format!(
            "cam{n}:\n  T_cam_imu:\n{rows}  distortion_model: radtan\n  distortion_coeffs: [0.1, 0.0, 0.0, 0.0]\n  camera_model: pinhole\n  \
             intrinsics: [458.0, 457.0, 367.0, 248.0]\n  resolution: [752, 480]\n"
        )
    };
    let here = cam(0, "  - [1, 0, 0, 0]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n");
    let there = cam(
        1,
        "  - [1, 0, 0, -0.12]\n  - [0, 0.8, -0.6, 0.01]\n  - [0, 0.6, 0.8, 0.02]\n  - [0, 0, 0, 1]\n",
    );
    let (_dir, paths) = written([("chain.yaml", format!("{here}{there}").as_str())]);
    let meta = import(&paths, Unknowns::default()).unwrap();
    assert!(near(moved(&meta, [0.0, 0.0, 5.0]), [-0.12, -2.99, 4.02]));
}

#[test]
fn the_configuration_of_vins_finds_its_cameras_beside_it() {
    let sample = named("VINS-Fusion");
    let (dir, paths) = written(sample.files.iter().map(|(name, text)| (*name, text.as_str())));
    let alone = import(&paths[..1], Unknowns::default()).unwrap();
    assert_eq!(alone.dist_r[0], -0.29);
    assert_eq!(import(&[dir.path()], Unknowns::default()).unwrap().t, alone.t);
}

#[test]
fn cameras_of_two_models_and_sizes_are_read_and_written() {
    let sample = with(
        "Kalibr",
        "distortion_coeffs: [-0.28368365, 0.07451284, -0.00010473, -3.555907e-05]\n  distortion_model: radtan",
        "distortion_coeffs: [0.01, 0.02, 0.0, 0.0]\n  distortion_model: equidistant",
    );
    let mut sample = Sample {
        files: vec![(
            sample.files[0].0,
            sample.files[0].1.replacen("[752, 480]", "[1280, 720]", 1),
        )],
        ..sample
    };
    let meta = read(&sample).unwrap();
    assert_eq!(meta.lenses(), [LensModel::RadialTangential, LensModel::Fisheye]);
    assert_eq!(meta.sizes(), [[1280, 720], [752, 480]]);
    let back = rigs::formats::Format::Kalibr.write(&meta).unwrap();
    sample.files = vec![("camchain.yaml", back[0].text.clone())];
    let back = read(&sample).unwrap();
    assert_eq!(
        (back.sizes(), back.lenses(), back.dist_r),
        (meta.sizes(), meta.lenses(), meta.dist_r)
    );
}

#[test]
fn a_right_camera_upside_down_stands_to_the_right_all_the_same() {
    let rolled = |t: f64| {
        let rows = format!(
            "  - [-1.0, 0.0, 0.0, {t}]\n  - [0.0, -1.0, 0.0, 0.0]\n  - [0.0, 0.0, 1.0, 0.0]\n"
        );
        with(
            "Kalibr",
            "  - [1.0, 0.0, 0.0, -0.12]\n  - [0.0, 0.8, -0.6, 0.01]\n  - [0.0, 0.6, 0.8, 0.02]\n",
            &rows,
        )
    };
    assert_eq!(read(&rolled(0.2)).unwrap().t, [1.0, 0.0, 0.0]);
    let why = format!("{:#}", read(&rolled(-0.2)).unwrap_err());
    assert!(
        why.contains("camchain.yaml") && why.contains("T_cn_cnm1") && why.contains("to the left"),
        "{why}"
    );
}

#[test]
fn cameras_above_each_other_have_ty() {
    let vertical = with(
        "ROS echo",
        "320.0, -48, 0.0, 400.0, 240.0, 0.0",
        "320.0, 0.0, 0.0, 400.0, 240.0, -48.0",
    );
    let meta = read(&vertical).unwrap();
    assert!(near(moved(&meta, [0.0; 3]), [0.0, -0.12, 0.0]), "{meta:?}");
}

#[test]
fn an_uncalibrated_camera_is_named_with_file_and_key() {
    let zeros = "[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]";
    let why = |sample: &Sample| format!("{:#}", read(sample).unwrap_err());
    let k = why(&with("ROS echo", "[400.0, 0.0, 320.0, 0.0, 401.0, 240.0, 0.0, 0.0, 1.0]", zeros));
    assert!(k.contains("left.yaml: k: [0, 0") && k.contains("never calibrated"), "{k}");
    let r = why(&with("ROS echo", "[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]", zeros));
    assert!(r.contains("right.yaml: r: [0, 0") && r.contains("never calibrated"), "{r}");
    let both = why(&with("ROS echo", "320.0, 0, 0.0", "320.0, -48.0, 0.0"));
    assert!(
        both.contains("left.yaml: p") && both.contains("one by one") && both.contains("P[0][3]"),
        "{both}"
    );
    let none = why(&with("ROS echo", "-48, 0.0", "0.0, 0.0"));
    assert!(none.contains("one by one"), "{none}");
}

#[test]
fn a_blank_model_without_coefficients_is_a_pinhole() {
    let blank = with(
        "ROS",
        "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]",
        "distortion_model:\ndistortion_coefficients:\n  rows: 1\n  cols: 0\n  data: []",
    );
    assert_eq!(read(&blank).unwrap().dist_r, [0.0; 5]);
}
