//! Output of `replay`: JSON, trace and text.

use std::fs;

use serde_json::Value;

use crate::call::{failure, json, scene, selfcal, stdout};

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
        "schema",
        "grid_step_px",
        "verdict",
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
fn the_exit_status_follows_the_verdict_if_asked() {
    let (_dir, set) = scene("near", &["--pairs", "12", "--rotation", "3,-2,1"]);
    let run = ["replay", &set, "--json"];
    let status = |more: &[&str]| selfcal(&[&run[..], more].concat()).ended().status;
    assert_eq!(status(&[]), 0);
    assert_eq!(status(&["--status"]), 20); // the rows of the guess are off
    assert_eq!(status(&["--status", "--apply", "each"]), 30); // the yaw of a guess is not confirmed
    assert_eq!(status(&["--status", "--apply", "each", "--depth-limit", "inf"]), 0);
    // Copied rows: no pair is fused, and a cause is named.
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("copied.csv");
    let rows = (0..8).flat_map(|frame| (0..100).map(move |i| (frame, i))).map(|(frame, i)| {
        let [u, v] = [60 + 5 * i, 30 + 13 * i % 400];
        format!("{frame},{u}.25,{v}.5,{}.75,{v}.5\n", u - 20 - i % 9)
    });
    let text: String = std::iter::once("frame,ul,vl,ur,vr\n".to_owned()).chain(rows).collect();
    fs::write(&file, text).unwrap();
    let run = ["replay", file.to_str().unwrap(), "--rig", "opencv_chess_sift", "--json"];
    let status = |more: &[&str]| selfcal(&[&run[..], more].concat()).ended().status;
    assert_eq!([status(&[]), status(&["--status"])], [1, 30]);
}

#[test]
fn an_applied_estimate_is_in_use_and_an_unapplied_one_has_a_reason() {
    let (_dir, set) = scene("near", &["--pairs", "12", "--rotation", "3,-2,1"]);
    let run = ["replay", &set, "--json"];
    let never = json(&run);
    assert_eq!(never["in_use"]["rms_px"], never["rms_px_before"]);
    assert!(never["in_use"]["e_theta"].as_f64().unwrap() > 0.06);
    assert_eq!(never["armed"], false);
    assert_eq!(never["verdict"]["should_apply"], true);
    assert_eq!(never["reasons"][0], "in use not confirmed by the last pairs");
    let each = ["--apply", "each", "--depth-limit", "inf"];
    let applied = json(&[&run[..], &each].concat());
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
    let file_name = file.to_str().unwrap();
    let trace = ["--trace", file_name, "--apply", "each", "--depth-limit", "inf"];
    let rows = || -> Vec<Vec<String>> {
        let text = fs::read_to_string(&file).unwrap();
        text.lines().map(|line| line.split(',').map(String::from).collect()).collect()
    };
    let (_dir, set) = scene("near", &["--pairs", "9", "--rotation", "3,-2,1"]);
    stdout(&[&["replay", &set][..], &trace].concat());
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

/// The events of a replay.
fn events(arguments: &[&str]) -> Vec<Value> {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("events.jsonl");
    let to = ["--apply", "each", "--events", file.to_str().unwrap()];
    stdout(&[&["replay"], arguments, &to[..]].concat());
    let text = fs::read_to_string(&file).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn each_change_is_an_event_and_a_stream_tells_its_time() {
    let of_set = events(&["opencv_chess_sift"]);
    let has = |event: &Value, change: &str| {
        event["changes"].as_array().unwrap().iter().any(|name| name == change)
    };
    let locked = of_set.iter().find(|event| event["state"] == "locked").unwrap();
    assert!(has(locked, "state") && locked["time"].is_null(), "{locked}");
    let applied: Vec<_> = of_set.iter().filter(|event| has(event, "generation")).collect();
    assert_eq!(applied[0]["generation"], 1);
    assert!(
        of_set.iter().all(|event| event["reasons"].is_array() && event["may_arm"].is_boolean())
    );
    assert!(of_set.windows(2).all(|two| two[0]["pair"].as_u64() < two[1]["pair"].as_u64()));

    let dir = tempfile::tempdir().unwrap();
    let stream = dir.path().join("stream");
    let stream = stream.to_str().unwrap();
    stdout(&["record", "opencv_chess_sift", stream]);
    let of_stream = events(&[stream, "--rig", "opencv_chess_sift", "--initial", "guess"]);
    assert!(of_stream.iter().all(|event| event["time"].is_u64()), "{of_stream:?}");
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
    let given = ["replay", "opencv_chess_corners", "--initial", path];
    // The same extrinsics are a calibration of yaw, and a guess.
    let [given, guess] = [&given[..], &given[..2]].map(|args| json(&[args, &["--json"]].concat()));
    assert!(given["yaw_sd"].as_f64().unwrap() < guess["yaw_sd"].as_f64().unwrap());
    fs::write(&file, r#"{"R": [[2,0,0],[0,1,0],[0,0,1]], "t": [-1, 0, 0]}"#).unwrap();
    let error = failure(&["replay", "opencv_chess_corners", "--initial", path], 1);
    assert!(error.contains("nominal.json") && error.contains("not a rotation"), "{error}");
}

#[test]
fn mistakes_are_named() {
    let error = failure(&["replay", "no_such_set"], 1);
    assert!(error.contains("no_such_set") && error.contains("opencv_chess_sift"), "{error}");
    let (_dir, set) = scene("near", &["--pairs", "3", "--matches", "5"]);
    let ended = selfcal(&["replay", &set, "--json"]).ends_with(1);
    assert!(ended.err.contains("none of the 3 pairs could be fused"), "{}", ended.err);
    let found: Value = serde_json::from_str(&ended.out).unwrap();
    assert_eq!(found["rejected_pairs"], serde_json::json!({ "too_few": 3 }));
    assert_eq!(
        (&found["refused_matches"], &found["matches"]),
        (&serde_json::json!({}), &15.into())
    );
}
