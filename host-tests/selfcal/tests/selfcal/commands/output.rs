//! Output of the commands: JSON, trace, text and scenes.

use std::fs;

use crate::call::{failure, json, stdout};

const SCENES: [&str; 17] = [
    "near",
    "far",
    "very-far",
    "altitude",
    "climb",
    "descent",
    "near-few",
    "sky",
    "heterogeneous",
    "narrow-band",
    "planar",
    "fronto-parallel",
    "parked",
    "parked-landmarks",
    "creeping",
    "step",
    "drift",
];

#[test]
fn json_has_the_stable_fields_and_no_others() {
    let object = json(&["replay", "opencv_chess_corners", "--json"]);
    let mut fields: Vec<&str> = object.as_object().unwrap().keys().map(String::as_str).collect();
    let mut expected = [
        "pairs",
        "accepted",
        "rejected_pairs",
        "matches",
        "refused_matches",
        "state",
        "e_t",
        "e_theta",
        "sigma_t",
        "sigma_theta",
        "sigma_pairs",
        "tracked_t",
        "tracked_theta",
        "R",
        "t",
        "vibration_rotation",
        "vibration_translation",
        "sd_rotation",
        "sd_translation",
        "rms_px_before",
        "rms_px_after",
        "rms_pairs",
        "in_use",
        "armed",
        "reasons",
        "locked_at",
        "baseline_observed",
        "sd_rotation_lens",
        "sd_translation_lens",
        "lens",
        "correction",
        "depth",
        "depth_expected",
        "lens_yaw",
        "lens_yaw_sd",
        "yaw_sd",
        "witnesses",
        "behind_infinity",
    ];
    fields.sort_unstable();
    expected.sort_unstable();
    assert_eq!(fields, expected);
    assert_eq!([&object["pairs"], &object["rms_pairs"], &object["matches"]], [13, 13, 702]);
    assert_eq!(object["refused_matches"], serde_json::json!({}));
    assert_eq!(object["rejected_pairs"], serde_json::json!({}));
    assert_eq!(object["correction"], serde_json::json!({ "focal": 0.0, "k1": 0.0 }));
    assert_eq!(object["R"].as_array().unwrap().len(), 9);
    assert_eq!(object["t"].as_array().unwrap().len(), 3);
    assert!(object["rms_px_after"].as_f64().unwrap() < object["rms_px_before"].as_f64().unwrap());
}

#[test]
fn an_applied_estimate_is_in_use_and_an_unapplied_one_has_a_reason() {
    let scene = ["synth", "--pairs", "12", "--rotation", "3,-2,1", "--json"];
    let never = json(&scene);
    assert_eq!(never["in_use"]["rms_px"], never["rms_px_before"]);
    assert!(never["in_use"]["e_theta"].as_f64().unwrap() > 0.06);
    assert_eq!(never["armed"], false);
    let reasons = ["in use off by 1 px or more", "yaw not confirmed"];
    assert_eq!(never["reasons"], serde_json::json!(reasons));
    let applied = json(&[&scene[..], &["--apply", "each"]].concat());
    for (in_use, estimate) in [("e_t", "e_t"), ("e_theta", "e_theta"), ("rms_px", "rms_px_after")] {
        assert_eq!(applied["in_use"][in_use], applied[estimate], "{in_use}");
    }
    assert_eq!(applied["armed"], true);
    assert_eq!(applied["reasons"], serde_json::json!(["yaw not confirmed"]));
    let at = applied["locked_at"].as_u64().unwrap();
    assert!((1..8).contains(&at) && never["locked_at"] == at, "{at}");
}

#[test]
fn the_trace_has_a_row_a_pair() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("trace.csv");
    let trace = ["--trace", file.to_str().unwrap(), "--apply", "each"];
    let rows = || -> Vec<Vec<String>> {
        let text = fs::read_to_string(&file).unwrap();
        text.lines().map(|line| line.split(',').map(String::from).collect()).collect()
    };
    stdout(&[&["synth", "--pairs", "9", "--rotation", "3,-2,1"][..], &trace].concat());
    let synth = rows();
    let header = "pair,state,verdict,armed,doubt,matches,fit,rms_px_in_use,rms_px_proposed,\
                  sd_rotation,sd_translation,r11,r12,r13,r21,r22,r23,r31,r32,r33,t1,t2,t3,\
                  u11,u12,u13,u21,u22,u23,u31,u32,u33,v1,v2,v3";
    assert_eq!(synth[0].join(","), header);
    assert_eq!(synth.len(), 10);
    assert_eq!(synth[1][..5], ["0", "acquiring", "fused", "false", ""]);
    assert_eq!(synth[1][23..], ["1", "0", "0", "0", "1", "0", "0", "0", "1", "-1", "0", "0"]);
    assert_eq!(synth[9][..4], ["8", "locked", "fused", "true"]);
    assert_eq!(synth[9][11..23], synth[9][23..]);
    stdout(&[&["replay", "opencv_chess_corners"][..], &trace].concat());
    assert_eq!((rows().len(), &rows()[0]), (14, &synth[0]));
}

#[test]
fn text_has_a_line_a_pair_and_the_final_table() {
    let text = stdout(&["replay", "opencv_chess_corners"]);
    assert_eq!(text.lines().filter(|line| line.ends_with("fused")).count(), 13);
    for name in ["e_t", "e_theta", "sigma_t", "sigma_theta", "RMS row offset", "rad", "deg"] {
        assert!(text.contains(name), "{name} is missing:\n{text}");
    }
}

#[test]
fn a_turned_rectified_set_is_found_again_in_both_scalars() {
    for scalar in ["f32", "f64"] {
        for view in ["top", "bottom", "left", "right"] {
            let args = ["replay", "motorcycle_sift", "--view", view, "--scalar", scalar, "--json"];
            let e_theta = json(&args)["e_theta"].as_f64().unwrap();
            // 5 degrees are 0.087 rad.
            assert!(e_theta < 0.003, "{view} {scalar}: {e_theta}");
        }
    }
}

#[test]
fn an_initial_file_is_used_and_a_bad_one_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("nominal.json");
    let path = file.to_str().unwrap();
    fs::write(&file, r#"{"R": [[1,0,0],[0,1,0],[0,0,1]], "t": [-0.12, 0.0, 0.0]}"#).unwrap();
    let given = json(&["replay", "opencv_chess_corners", "--initial", path, "--json"]);
    assert_eq!(given, json(&["replay", "opencv_chess_corners", "--json"]));
    fs::write(&file, r#"{"R": [[2,0,0],[0,1,0],[0,0,1]], "t": [-1, 0, 0]}"#).unwrap();
    let error = failure(&["replay", "opencv_chess_corners", "--initial", path], 1);
    assert!(error.contains("nominal.json") && error.contains("not a rotation"), "{error}");
}

#[test]
fn a_scene_of_synth_replays_from_files_as_from_a_pipe() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("scene");
    let out = out.to_str().unwrap();
    let scene = ["--pairs", "5", "--rotation", "3,-2,1", "--outliers", "0.1", "--scalar", "f64"];
    let piped = json(&[&["synth", "--json"][..], &scene[..]].concat());
    stdout(&[&["synth", "--out", out][..], &scene[..]].concat());
    let replayed = json(&["replay", out, "--scalar", "f64", "--json"]);
    assert_eq!(piped, replayed);
    let error = failure(&["synth", "--out", out], 1);
    assert!(error.contains("not empty"), "{error}");
}

#[test]
fn every_scene_is_generated_by_its_name() {
    let help = stdout(&["synth", "--help"]);
    let dir = tempfile::tempdir().unwrap();
    for scene in SCENES {
        assert!(help.contains(&format!("- {scene}:")), "{scene} is missing:\n{help}");
        for grid in ["continuous", "0.5", "pyramid"] {
            let out = dir.path().join(format!("{scene} {grid}"));
            stdout(&["synth", scene, "--pairs=3", "--grid", grid, "--out", out.to_str().unwrap()]);
            let pair = fs::read_to_string(out.join("pairs/0002.csv")).unwrap();
            assert!(pair.lines().count() > 48, "{scene} {grid}");
            assert_eq!(out.join("rigs.csv").exists(), ["step", "drift"].contains(&scene));
        }
    }
    assert_eq!(json(&["synth", "near", "--json"]), json(&["synth", "--json"]));
}

#[test]
fn options_given_beside_a_scene_win() {
    let far = ["synth", "--pairs", "5", "--depth", "30,800", "--json"];
    assert_eq!(json(&far), json(&["synth", "far", "--pairs", "5", "--json"]));
    let narrow = ["synth", "narrow-band", "--pairs", "5", "--json"];
    let band = ["synth", "--pairs", "5", "--band", "0.15", "--json"];
    assert_eq!(json(&narrow), json(&band));
    let still = ["synth", "drift", "--drift-deg", "0", "--pairs", "5", "--json"];
    assert_eq!(json(&still), json(&["synth", "--pairs", "5", "--json"]));
    assert_ne!(json(&["synth", "drift", "--pairs", "5", "--json"]), json(&still));
    let wrong = ["synth", "--pairs", "5", "--lens-error", "f_r=1%", "--json"];
    assert_ne!(json(&wrong), json(&["synth", "--pairs", "5", "--json"]));
    assert!(failure(&["synth", "--lens-error", "z_r=1"], 2).contains("is not one of"));
    let calm = ["synth", "creeping", "--creep-px", "0", "--pairs", "5", "--json"];
    assert_ne!(json(&["synth", "creeping", "--pairs", "5", "--json"]), json(&calm));
    for option in ["--creep-px", "--landmark-noise"] {
        assert!(failure(&["synth", "parked", option, "1"], 1).contains(option));
    }
    let error = failure(&["synth", "planar", "--step-deg", "1"], 1);
    assert!(error.contains("--step-deg"), "{error}");
}

#[test]
fn a_step_that_is_written_replays_as_what_is_piped() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("scene");
    let out = out.to_str().unwrap();
    let scene = ["--pairs", "6", "--step-deg", "1"];
    let piped = stdout(&[&["synth", "step"][..], &scene[..]].concat());
    stdout(&[&["synth", "step", "--out", out][..], &scene[..]].concat());
    let replayed = stdout(&["replay", out]);
    let lines = |text: &str| text.lines().skip(1).map(String::from).collect::<Vec<_>>();
    assert_eq!(lines(&piped), lines(&replayed));
}

#[test]
fn ranges_and_motion_that_are_written_replay_as_what_is_piped() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("scene");
    let ranges = out.join("ranges.csv");
    let [out, ranges] = [&out, &ranges].map(|path| path.to_str().unwrap());
    let scene =
        ["--pairs", "41", "--lens-error", "a_r=0.003", "--rangefinder", "0.01", "--travel", "12,0"];
    let json = |args: &[&str]| json(&[args, &["--json"]].concat());
    let piped = json(&[&["synth", "near"][..], &scene[..]].concat());
    stdout(&[&["synth", "near", "--out", out][..], &scene[..]].concat());
    let replayed = json(&["replay", out, "--ranges", ranges, "--motion"]);
    for key in ["witnesses", "R", "t", "yaw_sd", "reasons"] {
        assert!(!piped[key].is_null(), "{key}: {piped}");
        assert_eq!(piped[key], replayed[key], "{key}");
    }
    assert!(piped["witnesses"]["ranges"]["taken"].as_u64() >= Some(3), "{piped}");
    assert!(piped["witnesses"]["motion"]["taken"].as_u64() >= Some(3), "{piped}");
    // Rows alone do not tell the yaw.
    let alone = json(&["synth", "near", "--pairs", "41", "--lens-error", "a_r=0.003"]);
    let [with, without] = [&piped, &alone].map(|run| run["yaw_sd"].as_f64().unwrap());
    assert!(with < 0.2 * without, "{with} {without}");
}

#[test]
fn matches_with_a_mistake_give_no_calibration() {
    for mistake in ["exchanged", "identical"] {
        let args = [
            "synth",
            "far",
            "--pairs",
            "20",
            "--rotation",
            "0.5,-0.5,0.5",
            "--mistake",
            mistake,
            "--json",
        ];
        let why = failure(&args, 1);
        assert!(why.contains("none of the 20 pairs could be fused"), "{mistake}: {why}");
    }
}

#[test]
fn mistakes_are_named() {
    let error = failure(&["replay", "no_such_set"], 1);
    assert!(error.contains("no_such_set") && error.contains("opencv_chess_sift"), "{error}");
    let error = failure(&["synth", "--outliers", "1.5"], 1);
    assert!(error.contains("outliers"), "{error}");
    let error = failure(&["synth", "--depth", "3"], 2);
    assert!(error.contains("2 numbers"), "{error}");
    let error = failure(&["synth", "--pairs", "3", "--matches", "5"], 1);
    assert!(error.contains("none of the 3 pairs could be fused"), "{error}");
}
