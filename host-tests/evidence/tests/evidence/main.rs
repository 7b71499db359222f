//! The program `evidence` as a developer calls it, its pictures, and the methods of the literature.

mod campaign;
mod errata;
mod evaluate;
mod pictures;
mod recorded;
mod tables;

use test_support::Program;

/// A call of the program.
fn evidence(arguments: &[&str]) -> Program {
    Program::new(env!("CARGO_BIN_EXE_evidence"), arguments)
}
