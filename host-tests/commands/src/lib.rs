//! Commands of `selfcal` that read no images, and the common parts of all commands: pages, pictures, rig files.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod cli;
pub mod conventions;
pub mod report;
pub mod run_page;

use std::process::ExitCode;

use anyhow::Result;
use host_tests::is_broken_pipe;

pub use cli::{Command, RigArgs, read_rig, setup};

/// Exit status of a command; prints its error.
#[must_use]
pub fn exit(outcome: Result<ExitCode>) -> ExitCode {
    match outcome {
        Ok(code) => code,
        // The program that reads the output has closed it: no error.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
