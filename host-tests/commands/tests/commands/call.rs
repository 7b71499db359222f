//! Calls of the program.

use serde_json::Value;
use test_support::Program;

/// The program.
pub(crate) const PATH: &str = env!("CARGO_BIN_EXE_selfcal-light");

pub(crate) fn selfcal(args: &[&str]) -> Program {
    Program::new(PATH, args)
}

pub(crate) fn stdout(args: &[&str]) -> String {
    selfcal(args).stdout()
}

pub(crate) fn json(args: &[&str]) -> Value {
    serde_json::from_str(&stdout(args)).unwrap()
}

/// Standard error of a call that fails with the given status.
pub(crate) fn failure(args: &[&str], status: i32) -> String {
    selfcal(args).failure(status)
}
