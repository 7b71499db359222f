//! The program as a user calls it.

use std::path::Path;

use assert_cmd::Command;
use serde_json::Value;

/// What a command said: standard output, standard error, exit status.
pub(crate) struct Said {
    pub(crate) out: String,
    pub(crate) err: String,
    pub(crate) status: i32,
}

pub(crate) fn run(arguments: &[&str]) -> Said {
    let output = Command::cargo_bin("selfcal-images").unwrap().args(arguments).output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let status = output.status.code().unwrap();
    Said { out: text(output.stdout), err: text(output.stderr), status }
}

/// `check`: its JSON, null if there is none, and what it said.
pub(crate) fn check(place: &Path, more: &[&str]) -> (Value, Said) {
    let arguments = [&["check", place.to_str().unwrap(), "--json", "--keypoints", "500"], more];
    let said = run(&arguments.concat());
    (serde_json::from_str(&said.out).unwrap_or(Value::Null), said)
}
