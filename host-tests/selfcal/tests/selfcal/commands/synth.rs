//! `selfcal synth`: named scenes and scene files.

use std::fs;
use std::path::Path;

use sim::synth::ScenarioKind;
use strum::VariantArray;

use crate::call::{failure, json, scene, stdout};

/// The last pair, and the rigs of all pairs if they differ.
fn content(set: &str) -> (String, Option<String>) {
    let file = |name: &str| fs::read_to_string(Path::new(set).join(name));
    (file("pairs/0002.csv").unwrap(), file("rigs.csv").ok())
}

#[test]
fn every_scene_is_generated_by_its_name_and_from_its_printed_file() {
    let help = stdout(&["synth", "--help"]);
    for kind in ScenarioKind::VARIANTS {
        let name = kind.to_string();
        assert!(help.contains(&format!("  {name}: ")), "{name} is missing:\n{help}");
        let printed = stdout(&["synth", &name, "--print"]);
        let [(_one, named), (_two, read)] =
            [&name, &printed].map(|place| scene(place, &["--pairs", "3"]));
        let (pair, rigs) = content(&named);
        assert!(pair.lines().count() > 48, "{name}");
        assert_eq!(rigs.is_some(), kind.moves(), "{name}");
        assert_eq!((pair, rigs), content(&read), "{name}");
    }
}

#[test]
fn the_scene_file_of_the_guide_is_read() {
    let guide = include_str!("../../../README.md");
    let yaml = guide.split_once("```yaml\n").unwrap().1.split("```").next().unwrap();
    let (_dir, set) = scene(yaml, &["--pairs", "3"]);
    assert!(Path::new(&set).join("ranges.csv").exists() && content(&set).1.is_some());
}

#[test]
fn options_win_over_the_scene_file() {
    let options = [
        ("--pairs", "5", "pairs: 5"),
        ("--matches", "60", "matches: 60"),
        ("--noise", "0.2", "noise_px: 0.2"),
        ("--outliers", "0.1", "outliers: 0.1"),
        ("--rotation", "-1,2,3", "rotation_deg: [-1, 2, 3]"),
        ("--baseline", "-4,5", "baseline_deg: [-4, 5]"),
    ];
    let given: Vec<&str> =
        options.iter().flat_map(|(option, value, _)| [*option, *value]).collect();
    let printed = stdout(&[&["synth", "drift", "--print"], &given[..]].concat());
    let named = stdout(&["synth", "drift", "--print"]);
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let changed: Vec<String> =
        lines(&printed).into_iter().filter(|line| !lines(&named).contains(line)).collect();
    assert_eq!(changed, options.map(|(.., line)| line));
    let [(_one, first), (_two, other)] =
        ["1", "2"].map(|seed| scene("near", &["--pairs", "3", "--seed", seed]));
    assert_ne!(content(&first), content(&other));
}

#[test]
fn each_pair_of_a_rig_that_moves_is_compared_with_its_own_rig() {
    let (_dir, set) = scene("scene: step\npairs: 12\nturn_deg: 1", &[]);
    let sigma = json(&["replay", &set, "--json"])["sigma_theta"].as_f64().unwrap();
    // The turn is 0.017 rad.
    assert!(sigma < 0.002, "{sigma}");
}

#[test]
fn ranges_and_motion_replay_with_the_call_that_synth_prints() {
    let dir = tempfile::tempdir().unwrap();
    let place = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let yaml = "scene: near
pairs: 41
lens_errors: a_r=0.003
rangefinder: {baseline_m: 0.12, sd: 0.01, nearer: 0}
motion: {travel: 12, turn_deg: 0}
";
    fs::write(place("scene.yaml"), yaml).unwrap();
    let said = stdout(&["synth", &place("scene.yaml"), "--out", &place("set")]);
    let call: Vec<&str> = said.split_once("selfcal ").unwrap().1.split_whitespace().collect();
    let with = json(&[&call[..], &["--json"]].concat());
    for witness in ["ranges", "motion"] {
        assert!(with["witnesses"][witness]["taken"].as_u64() >= Some(3), "{with}");
    }
    // Rows alone do not tell the yaw.
    let without = json(&["replay", &place("set"), "--json"]);
    let [with, without] = [&with, &without].map(|run| run["yaw_sd"].as_f64().unwrap());
    assert!(with < 0.2 * without, "{with} {without}");
}

#[test]
fn matches_with_a_mistake_give_no_calibration() {
    for mistake in ["exchanged", "identical"] {
        let yaml = format!("scene: far\nrotation_deg: [0.5, -0.5, 0.5]\nmistake: {mistake}");
        let (_dir, set) = scene(&yaml, &["--pairs", "20"]);
        let why = failure(&["replay", &set, "--json"], 1);
        assert!(why.contains("none of the 20 pairs could be fused"), "{mistake}: {why}");
    }
}

#[test]
fn a_wrong_call_is_named_with_its_remedy() {
    let (dir, set) = scene("near", &["--pairs", "2"]);
    let error = failure(&["synth", "near", "--out", &set], 1);
    assert!(error.contains("not empty"), "{error}");
    let error = failure(&["synth", "nearr", "--print"], 1);
    assert!(error.contains("nearr is neither") && error.contains("  near: "), "{error}");
    let error = failure(&["synth", "near", "--outliers", "1.5", "--out", "unused"], 1);
    assert!(error.contains("outliers"), "{error}");
    assert!(failure(&["synth", "near"], 2).contains("--out"));
    let error = failure(&["synth", "near", "--rotation", "3", "--print"], 2);
    assert!(error.contains("3 numbers"), "{error}");
    let file = dir.path().join("wrong.yaml");
    fs::write(&file, "scene: near\nband: wide\n").unwrap();
    let error = failure(&["synth", file.to_str().unwrap(), "--print"], 1);
    assert!(error.contains("wrong.yaml") && error.contains("band: invalid type"), "{error}");
}
