//! `selfcal`: replays recorded or generated correspondences through the calibrator.
#![allow(clippy::doc_markdown, reason = "doc comments of arguments are the help text")]

mod cli;

use std::process::ExitCode;

use clap::{Parser, Subcommand};
use host_tests::is_broken_pipe;

/// Stereo self-calibration on a host: replay a recording, or generate one, and print what the
/// calibrator estimates.
///
/// The calibrator estimates R and t of a stereo rig (p_r = R p_l + t, |t| = 1) from left/right
/// correspondences alone, pair by pair, and fuses the pairs.
#[derive(Debug, Parser)]
#[command(version, after_help = "Start with: selfcal replay opencv_chess_corners")]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Replay(cli::ReplayArgs),
    Record(cli::RecordArgs),
    Export(cli::ExportArgs),
    Import(cli::ImportArgs),
    Synth(Box<cli::SynthArgs>),
    Campaign(cli::CampaignArgs),
    Evaluate(cli::EvaluateArgs),
    Link(cli::LinkArgs),
    Bench(cli::BenchArgs),
    /// From images to the calibrated rig: folders, EuRoC, KITTI, Middlebury, ROS bags
    #[command(disable_help_flag = true)]
    Images(cli::ImagesArgs),
    /// One line and an exit status: whether a rig still fits its calibration
    #[command(disable_help_flag = true)]
    Check(cli::ImagesArgs),
    /// Measure the matcher of `images` against the truth
    #[command(disable_help_flag = true)]
    Matcher(cli::ImagesArgs),
}

fn main() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Replay(args) => cli::replay(&args),
        Command::Record(args) => cli::record(&args),
        Command::Export(args) => cli::export(&args),
        Command::Import(args) => cli::import(&args),
        Command::Synth(args) => cli::synth(&args),
        Command::Campaign(args) => cli::campaign(&args),
        Command::Evaluate(args) => cli::evaluate_all(&args),
        Command::Link(args) => cli::link(&args),
        Command::Bench(args) => cli::bench(&args),
        Command::Images(args) => return cli::hand_over("images", &args),
        Command::Check(args) => return cli::hand_over("check", &args),
        Command::Matcher(args) => return cli::hand_over("matcher", &args),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        // Whoever read the output has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
