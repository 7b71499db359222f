//! `selfcal`: from images, bags or recorded matches to the calibrated rig.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

/// Stereo self-calibration on a host: images, a recording or a generated scene in, the calibrated rig out.
///
/// The calibrator estimates R and t of a stereo rig (p_r = R p_l + t, |t| = 1) from left/right
/// correspondences alone, pair by pair, and fuses the pairs.
#[derive(Debug, Parser)]
#[command(version)]
#[cfg_attr(
    feature = "full",
    command(after_help = "Start with: selfcal images chess --knock 1 --report page")
)]
#[cfg_attr(
    not(feature = "full"),
    command(
        after_help = "Without the commands over images and those that make EVIDENCE.md: they need the feature `full`."
    )
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    #[cfg(feature = "full")]
    #[command(flatten)]
    Images(selfcal_images::Command),
    #[command(flatten)]
    Recorded(selfcal_commands::Command),
    #[cfg(feature = "full")]
    #[command(flatten)]
    Evidence(selfcal_evidence::Command),
}

impl Command {
    fn run(&self) -> Result<ExitCode> {
        match self {
            #[cfg(feature = "full")]
            Self::Images(command) => command.run(),
            Self::Recorded(command) => command.run().map(|()| ExitCode::SUCCESS),
            #[cfg(feature = "full")]
            Self::Evidence(command) => command.run().map(|()| ExitCode::SUCCESS),
        }
    }
}

fn main() -> ExitCode {
    selfcal_commands::exit(Cli::parse().command.run())
}
