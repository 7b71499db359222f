//! Calls of the program.

use std::path::Path;

use serde_json::Value;
use tempfile::TempDir;
use test_support::{Ended, Program};

/// The program.
pub(crate) const PATH: &str = env!("CARGO_BIN_EXE_selfcal");

pub(crate) fn selfcal(arguments: &[&str]) -> Program {
    Program::new(PATH, arguments)
}

/// A call, whether it succeeds or not.
pub(crate) fn run(arguments: &[&str]) -> Ended {
    selfcal(arguments).ended()
}

pub(crate) fn stdout(arguments: &[&str]) -> String {
    selfcal(arguments).stdout()
}

pub(crate) fn json(arguments: &[&str]) -> Value {
    serde_json::from_str(&stdout(arguments)).unwrap()
}

/// Standard error of a call that fails with the given status.
pub(crate) fn failure(arguments: &[&str], status: i32) -> String {
    selfcal(arguments).failure(status)
}

/// `check`: its JSON or null, and its output.
pub(crate) fn check(place: &Path, more: &[&str]) -> (Value, Ended) {
    let arguments = [&["check", place.to_str().unwrap(), "--json", "--keypoints", "500"], more];
    let said = run(&arguments.concat());
    (serde_json::from_str(&said.out).unwrap_or(Value::Null), said)
}

/// A data set that `synth` generates, and its folder, which is deleted with the first value.
///
/// * `scene`: a named scene, or the content of a scene file.
pub(crate) fn scene(scene: &str, options: &[&str]) -> (TempDir, String) {
    let dir = tempfile::tempdir().unwrap();
    let place = |name: &str| dir.path().join(name).to_str().unwrap().to_owned();
    let (file, set) = (place("scene.yaml"), place("set"));
    let is_file = scene.contains(':');
    if is_file {
        std::fs::write(&file, scene).unwrap();
    }
    let arguments = ["synth", if is_file { &file } else { scene }, "--out", &set];
    stdout(&[&arguments, options].concat());
    (dir, set)
}
