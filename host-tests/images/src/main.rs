//! `selfcal images`, `check` and `matcher`: the commands that read images. `selfcal` hands over to this program.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]
#![allow(clippy::cast_precision_loss, reason = "counts of matches")]

mod cli;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use host_tests::is_broken_pipe;

/// Stereo self-calibration from images.
#[derive(Debug, Parser)]
#[command(name = "selfcal", version, after_help = "Start with: selfcal images chess --report page")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Images(Box<cli::ImagesArgs>),
    Check(Box<cli::CheckArgs>),
    Matcher(cli::MatcherArgs),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Images(args) => cli::images(&args).map(|()| ExitCode::SUCCESS),
        Command::Check(args) => cli::check(&args),
        Command::Matcher(args) => cli::matcher(&args).map(|()| ExitCode::SUCCESS),
    };
    match outcome {
        Ok(code) => code,
        // Whoever read the output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
