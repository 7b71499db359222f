//! `evidence`: the measurements behind EVIDENCE.md, for developers.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

use std::process::ExitCode;

use clap::Parser;

/// Measures the calibrator: campaigns over generated scenes, other methods beside it, the matcher, the link, and the
/// pictures and tables of the documents.
#[derive(Debug, Parser)]
#[command(
    version,
    after_help = "Start with: cargo evidence evaluate --quick --out target/evaluation"
)]
struct Cli {
    #[command(subcommand)]
    command: evidence::Command,
}

fn main() -> ExitCode {
    sim::exit(Cli::parse().command.run().map(|()| ExitCode::SUCCESS))
}
