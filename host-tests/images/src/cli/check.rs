//! `selfcal check`.

use std::io::{self, Write};
use std::process::ExitCode;

use crate::verdict::Report;
use anyhow::Result;
use clap::Args;

use super::source::SourceArgs;

/// One line and an exit status: whether a rig still fits its calibration, for a production line or a nightly job.
///
/// Takes the images and rigs of `selfcal images`. The worst reason comes first.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal check chess
  selfcal check nightly/ --rig rig/opencv/intrinsics.yml rig/opencv/extrinsics.yml --json

Exit status: 0 good; 10 improvable: rows within 1 px, but the estimate aligns them better; 20 recalibrate: rows 1 px
off or more; 30 unknown: the images do not tell; 1 error.")]
pub struct CheckArgs {
    #[command(flatten)]
    source: SourceArgs,

    /// Print one JSON object instead of the line. Angles in rad.
    #[arg(long)]
    json: bool,
}

/// Runs `selfcal check`.
pub(crate) fn check(args: &CheckArgs) -> Result<ExitCode> {
    let ran = args.source.run(None, None, true)?;
    let report = Report::of(&ran.session, ran.rig.guessed)?;
    let mut out = io::stdout();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&report)?)?;
    } else {
        writeln!(out, "{report}")?;
    }
    Ok(ExitCode::from(report.verdict.status()))
}
