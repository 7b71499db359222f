//! Output of the command with `--lens compensate`: every output of an estimate has the corrected cameras.

use std::fs;
use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;

use crate::call::{failure, json, scene, stdout};

/// A right camera whose focal length is 0.5 % longer than the data say.
fn wrong(pairs: &str) -> (TempDir, String) {
    scene("scene: near\nlens_errors: f_r=0.5%", &["--pairs", pairs, "--seed", "3"])
}

const COMPENSATE: [&str; 4] = ["--lens", "compensate", "--apply", "each"];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn run<'a>(set: &'a str, options: &[&'a str]) -> Vec<&'a str> {
    [&["replay", set], options].concat()
}

#[test]
fn rows_belong_to_the_corrected_cameras() {
    let (_dir, set) = wrong("40");
    let compensated = json(&run(&set, &[&COMPENSATE[..], &["--json"]].concat()));
    let reported = json(&run(&set, &["--lens", "report", "--apply", "each", "--json"]));
    let focal = number(&compensated["correction"]["focal"]);
    assert!((focal - 0.005).abs() < 0.0005, "{focal}");
    assert_eq!(compensated["lens"]["focal"]["value"], compensated["correction"]["focal"]);
    assert_eq!(reported["correction"], serde_json::json!({ "focal": 0.0, "k1": 0.0 }));
    let [after, before] = [&compensated, &reported].map(|run| number(&run["rms_px_after"]));
    // Noise of 0.3 px in both rows.
    assert!(after < 0.45 && after < 0.9 * before, "{after} {before}");
    let in_use = number(&compensated["in_use"]["rms_px"]);
    assert!((in_use - after).abs() < 1e-3, "{in_use} {after}");
    let [e_t, reported_e_t] = [&compensated, &reported].map(|run| number(&run["e_t"]));
    assert!(e_t < 0.1 * reported_e_t, "{e_t} {reported_e_t}");
}

#[test]
fn the_text_says_when_a_lens_was_corrected_and_by_how_much() {
    let (_dir, set) = wrong("40");
    let corrected = stdout(&run(&set, &COMPENSATE));
    assert!(corrected.contains("   lens corrected\n"), "{corrected}");
    assert!(corrected.contains("\ncameras corrected  right focal length +0.5"), "{corrected}");
    let given = stdout(&run(&set, &["--lens", "report", "--apply", "each"]));
    assert!(!given.contains("corrected"), "{given}");
}

#[test]
fn the_trace_ends_with_the_corrections_where_there_are_any() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("trace.csv");
    let (_set, set) = wrong("40");
    stdout(&run(&set, &[&COMPENSATE[..], &["--trace", file.to_str().unwrap()]].concat()));
    let text = fs::read_to_string(&file).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!(rows[0][35..], ["focal", "k1", "used_focal", "used_k1"]);
    let at = rows.iter().position(|row| row[2] == "lens corrected").unwrap();
    assert_eq!(rows[at][35..], ["", "", "0", "0"], "begins again: no estimate");
    let (_set, short) = wrong(&at.to_string());
    let error = failure(&run(&short, &COMPENSATE), 1);
    assert!(error.contains("restarted with a corrected lens"), "{error}");
    let used: f64 = rows[at + 1][37].parse().unwrap();
    assert!(rows[at + 1][35] != "0" && used.abs() < 1e-12, "not locked again yet: {used}");
    let [proposed, used] = [35, 37].map(|i| rows[40][i].parse::<f64>().unwrap());
    assert!((used - proposed).abs() < 1e-6 && used > 0.004, "{used} {proposed}");
}

/// A copy of a set with another rig.
fn with_rig(set: &Path, rig: &Path, to: &Path) {
    fs::create_dir_all(to.join("pairs")).unwrap();
    fs::copy(rig, to.join("meta.json")).unwrap();
    for pair in fs::read_dir(set.join("pairs")).unwrap() {
        let pair = pair.unwrap();
        fs::copy(pair.path(), to.join("pairs").join(pair.file_name())).unwrap();
    }
}

#[test]
fn exported_rigs_have_the_corrected_cameras() {
    let dir = tempfile::tempdir().unwrap();
    let path = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (_set, set) = wrong("40");
    let lens = ["--lens", "compensate"];
    let page = path("page");
    let found = json(&[&["replay", &set, "--json", "--report", &page], &lens[..]].concat());
    for format in ["opencv", "kalibr", "ros"] {
        let (files, rig, copy) = (path(format), path(&format!("{format}.json")), path("copy"));
        let export = ["export", &set, "--replayed", "--format", format, "--out", &files];
        stdout(&[&export[..], &lens].concat());
        stdout(&["import", &files, "--out", &rig]);
        let read = |file: &str| -> Value {
            serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap()
        };
        let [given, exported] = [&read(&format!("{set}/meta.json")), &read(&rig)];
        assert_eq!(given["K_l"], exported["K_l"], "{format}");
        let ratio = number(&exported["K_r"][0][0]) / number(&given["K_r"][0][0]);
        let correction = &found["correction"];
        assert!((ratio - 1.0 - number(&correction["focal"])).abs() < 1e-9, "{format}: {ratio}");
        assert!((number(&exported["dist_r"][0]) - number(&correction["k1"])).abs() < 1e-9);
        // `R` and `t` are right with their cameras.
        with_rig(Path::new(&set), Path::new(&rig), Path::new(&copy));
        let again = json(&["replay", &copy, "--initial", &rig, "--lens", "given", "--json"]);
        let [after, before] = [&found["rms_px_after"], &again["rms_px_before"]].map(number);
        assert!((after / before - 1.0).abs() < 0.02, "{format}: {after} {before}");
        for file in fs::read_dir(&files).unwrap() {
            let name = file.unwrap().file_name().into_string().unwrap();
            let of_page = fs::read_to_string(format!("{page}/rig/{format}/{name}")).unwrap();
            assert_eq!(fs::read_to_string(format!("{files}/{name}")).unwrap(), of_page);
        }
        fs::remove_dir_all(&copy).unwrap();
    }
    let index = fs::read_to_string(format!("{page}/index.html")).unwrap();
    assert!(index.contains("correction of the right focal length"));
    assert!(index.contains("The right camera is the corrected one"));
}
