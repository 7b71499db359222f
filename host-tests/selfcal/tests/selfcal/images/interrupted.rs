//! Ctrl-C ends the run and keeps the pairs done.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read};
use std::process::{Command, Stdio};

use rigs::data::Dataset;

use crate::call::PATH;
use crate::images::scene::{FOCAL, folders, small};

/// More pairs than can be matched before the signal arrives.
const PAIRS: usize = 60;

#[test]
fn an_interrupted_run_keeps_its_pairs_and_reports_them() {
    let dir = tempfile::tempdir().unwrap();
    let [left, right] = small();
    folders((0..PAIRS).map(|_| [&left, &right]), dir.path());
    let set = dir.path().join("set");
    let mut child = Command::new(PATH)
        .args(["images", dir.path().to_str().unwrap(), "--focal", &FOCAL.to_string()])
        .args(["--keypoints", "500", "--out", set.to_str().unwrap()])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map(Result::unwrap);
    let first = lines.find(|line| line.trim_start().starts_with("0 "));
    assert!(first.is_some(), "no line of the first pair");
    let signal = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signal.success());
    let rest: Vec<String> = lines.collect();
    let mut out = String::new();
    child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{rest:?}");

    let kept = Dataset::load(&set).unwrap().pairs.len();
    assert!(0 < kept && kept < PAIRS, "{kept}");
    assert!(out.contains(&format!("stopped after {kept} pairs")), "{out}");
    assert!(rest.iter().any(|line| line.contains("stopping")), "{rest:?}");
}
