//! `selfcal` without the commands that read images or measure, for the tests.

use std::process::ExitCode;

use clap::Parser;

/// Stereo self-calibration on a host.
#[derive(Debug, Parser)]
#[command(name = "selfcal", version)]
struct Cli {
    #[command(subcommand)]
    command: selfcal_commands::Command,
}

fn main() -> ExitCode {
    selfcal_commands::exit(Cli::parse().command.run().map(|()| ExitCode::SUCCESS))
}
