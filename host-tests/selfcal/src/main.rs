//! `selfcal`: from images, bags or recorded matches to the calibrated rig.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod args;
mod commands;
#[cfg(feature = "images")]
mod over_images;
mod stream;

use std::process::ExitCode;

use clap::Parser;

use commands::Command;

/// Stereo self-calibration on a host: images, a recording or a generated scene in, the calibrated rig out.
///
/// The calibrator estimates R and t of a stereo rig (p_r = R p_l + t, |t| = 1) from left/right
/// correspondences alone, pair by pair, and fuses the pairs.
#[derive(Debug, Parser)]
#[command(version)]
#[cfg_attr(
    feature = "images",
    command(after_help = "Start with: selfcal images chess --knock 1 --report page")
)]
#[cfg_attr(
    not(feature = "images"),
    command(
        after_help = "Built without the commands over images: they need the feature `images`."
    )
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

fn main() -> ExitCode {
    let command = Cli::parse().command;
    sim::exit(command.run().inspect_err(|error| command.say_error(error)))
}
