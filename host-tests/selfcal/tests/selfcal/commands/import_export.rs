//! The commands `selfcal import` and `selfcal export`.

use crate::call::{failure, json, scene, selfcal, stdout};

#[test]
fn a_calibrated_rig_goes_out_and_starts_the_next_run_where_this_one_ended() {
    let dir = tempfile::tempdir().unwrap();
    for format in ["opencv", "ros"] {
        let out = dir.path().join(format);
        let out = out.to_str().unwrap();
        let args =
            ["export", "opencv_chess_corners", "--replayed", "--format", format, "--out", out];
        let said = selfcal(&args).ends_with(0).err;
        assert!(said.contains("written as 1"), "{said}");
        let replay = ["replay", "opencv_chess_corners", "--initial", out, "--json"];
        let json = json(&replay);
        let [before, after] =
            ["rms_px_before", "rms_px_after"].map(|key| json[key].as_f64().unwrap());
        // With the usual start it is 2.36 px before.
        assert!(before < 0.2 && (before - after).abs() < 0.01, "{before} {after}");
        assert!(failure(&args, 1).contains("nothing is overwritten"));
    }
}

#[test]
fn an_exported_rig_imports_as_the_rig_of_a_stream() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (chain, meta, stream) = (path("chain"), path("meta.json"), path("flight.scmf"));
    let set = "motorcycle_sift";
    stdout(&["export", set, "--format", "kalibr", "--out", &chain]);
    stdout(&["import", &chain, "--out", &meta]);
    stdout(&["record", set, &stream]);
    let replayed = |rig: &str| stdout(&["replay", &stream, "--rig", rig, "--json"]);
    assert_eq!(replayed(&meta), replayed(set));
    assert_eq!(replayed(&format!("{chain}/camchain.yaml")), replayed(set));
    let again = failure(&["import", &chain, "--out", &meta], 1);
    assert!(again.contains("nothing is overwritten"));
}

/// A number of OpenCV's files: a matrix as a line, or a scalar.
fn opencv_numbers(text: &str, name: &str) -> Vec<f64> {
    let (_, from) = text.split_once(&format!("\n{name}: ")).unwrap_or_else(|| panic!("{name}"));
    let list = match from.strip_prefix("!!opencv-matrix") {
        Some(matrix) => matrix.split_once('[').unwrap().1.split_once(']').unwrap().0,
        None => from.lines().next().unwrap(),
    };
    list.split(',').map(|number| number.trim().parse().unwrap()).collect()
}

#[test]
fn rows_of_a_warp_are_gone_after_rectification_with_the_exported_lens_yaw() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let warp = "scene: near\nrotation_deg: [0.4, -0.3, 0.5]\nlens_errors: a_r=0.008";
    let (_set, set) = scene(warp, &["--pairs", "30"]);
    // The start counts as a calibration of yaw, so the remaining row offsets are attributed to the lens.
    let start = format!("{set}/meta.json");
    for format in ["opencv", "ros", "kalibr"] {
        let out = path(format);
        let initial = ["--initial", start.as_str(), "--format", format, "--out", &out];
        stdout(&[&["export", &set, "--replayed"], &initial[..]].concat());
    }
    let text = |name: &str| std::fs::read_to_string(path(name)).unwrap();
    let extrinsics = text("opencv/extrinsics.yml");
    let numbers = |name: &str| opencv_numbers(&extrinsics, name);
    let [r1, r2] = ["R1", "R2"].map(|name| nalgebra::Matrix3::from_row_slice(&numbers(name)));
    let a = numbers("lens_yaw")[0];
    for name in ["ros/left.yaml", "kalibr/camchain.yaml"] {
        assert!(text(name).contains(&format!("# lens_yaw: {a}\n")), "{name}: {a}");
    }
    let set = rigs::data::Dataset::find(std::path::Path::new(&set)).unwrap();
    let [[f, _, cx], [_, _, cy], _] = set.meta.k_l;
    let mut squares = [0.0; 2];
    // Sums that measure the part of the row offsets proportional to `x y`.
    let mut with_xy = [0.0; 2];
    for m in set.pairs.iter().flatten() {
        let ray = |u: f64, v: f64| nalgebra::Vector3::new((u - cx) / f, (v - cy) / f, 1.0);
        let [l, r] = [r1 * ray(m.ul, m.vl), r2 * ray(m.ur, m.vr)];
        let [x, y] = [l.x / l.z, l.y / l.z];
        let before = r.y / r.z - y;
        // Without and with a look-up table of the left image. It reads the source row `y - a x y` for the row `y`, so
        // that a point of the row `y` appears at `y + a x y`.
        for (i, row) in [before, before - a * x * y].into_iter().enumerate() {
            squares[i] += row * row;
            with_xy[i] += row * x * y;
        }
    }
    let count = f64::from(u32::try_from(set.pairs.iter().flatten().count()).unwrap());
    let [before, after] = squares.map(|sum| (sum / count).sqrt() * f);
    // Noise of 0.3 px in both images.
    assert!(before > 0.7 && (0.40..0.45).contains(&after), "{before} {after}");
    assert!(with_xy[1].abs() < 0.02 * with_xy[0].abs(), "{with_xy:?}");
}

#[test]
fn replay_reads_what_import_reads_and_starts_from_its_calibration_and_says_so() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (stream, files) = (path("flight.scmf"), path("files"));
    stdout(&["record", "opencv_chess_sift", &stream]);
    stdout(&["export", "opencv_chess_sift", "--format", "opencv", "--out", &files]);
    let rig = [format!("{files}/intrinsics.yml"), format!("{files}/extrinsics.yml")];
    let replay = ["replay", &stream, "--rig", &rig[0], &rig[1], "--json"];
    let said = selfcal(&replay).ends_with(0).err;
    assert!(said.contains("start: R and t of the rig, a calibration"), "{said}");
    let before = |arguments: &[&str]| json(arguments)["rms_px_before"].as_f64().unwrap();
    let (from_rig, identity) =
        (before(&replay), before(&[&replay[..], &["--initial", "guess"]].concat()));
    assert!(from_rig < 1.0 && identity > 2.0 * from_rig, "{from_rig} {identity}");
    // Lists in JSON, without the size of the images.
    let k = "[[534.1, 0, 342.0], [0, 534.1, 234.8], [0, 0, 1]]";
    let lists = path("rig.json");
    let text = format!(
        "{{\"K1\": {k}, \"D1\": [-0.28, 0, 0, 0], \"K2\": {k}, \"D2\": [-0.28, 0, 0, 0], \"R\": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], \"T\": [-3.3, 0, 0]}}"
    );
    std::fs::write(&lists, text).unwrap();
    let args = ["replay", &stream, "--rig", &lists, "--json"];
    assert!(failure(&args, 1).contains("--size W,H"));
    assert_eq!(
        json(&[&args[..], &["--size", "640,480", "--unit", "0.0254"]].concat())["pairs"],
        13
    );
    let said = selfcal(&["replay", "opencv_chess_corners"]).ends_with(0).err;
    assert!(said.contains("start: a guess") && said.contains("are the reference"), "{said}");
}

#[test]
fn the_help_of_import_lists_every_format() {
    let help = stdout(&["import", "--help"]);
    for name in [
        "EuRoC",
        "KITTI",
        "Luxonis",
        "ORB-SLAM3",
        "VINS-Fusion",
        "Basalt",
        "MC-Calib",
        "ZED",
        "COLMAP",
        "OpenVINS",
        "ROS echo",
    ] {
        assert!(help.contains(name), "{name}: {help}");
    }
}

#[test]
fn help_teaches_the_signs() {
    for command in ["import", "export"] {
        let help = stdout(&[command, "--help"]);
        // Line breaks depend on the width of the terminal.
        let help = help.split_whitespace().collect::<Vec<_>>().join(" ");
        for word in ["x_2 = R x_1 + T", "T_cn_cnm1", "P[0][3] = -fx b", "Examples"] {
            assert!(help.contains(word), "{word} is missing:\n{help}");
        }
    }
}
