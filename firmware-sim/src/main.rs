//! The firmware on a host: the application loop, fed by a simulated matcher.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod sim;

use std::process::ExitCode;

use clap::Parser;
use host_tests::is_broken_pipe;

fn main() -> ExitCode {
    match sim::run(&sim::Cli::parse(), &mut std::io::stdout()) {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever read the output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
