//! Calls of the command.

use assert_cmd::Command;
use serde_json::Value;

pub(crate) fn selfcal(args: &[&str]) -> Command {
    let mut command = Command::cargo_bin("selfcal").unwrap();
    command.args(args);
    command
}

pub(crate) fn stdout(args: &[&str]) -> String {
    let output = selfcal(args).assert().success();
    String::from_utf8(output.get_output().stdout.clone()).unwrap()
}

pub(crate) fn json(args: &[&str]) -> Value {
    serde_json::from_str(&stdout(args)).unwrap()
}

/// Standard error of a call that fails with the given status.
pub(crate) fn failure(args: &[&str], status: i32) -> String {
    let output = selfcal(args).assert().code(status);
    String::from_utf8(output.get_output().stderr.clone()).unwrap()
}
