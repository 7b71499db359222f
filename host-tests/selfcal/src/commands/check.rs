//! `selfcal check`.

use std::io::{self, Write};
use std::process::ExitCode;

use anyhow::Result;
use clap::Args;
use images::score::{Candidate, Scores};
use images::verdict::Report;

use super::json_of;
use crate::over_images::{Ran, SourceArgs, name};

/// Report in one line and by exit status whether a rig still fits its calibration, for a production line or a nightly
/// job.
///
/// Takes the images and rigs of `selfcal images`. The worst reason comes first. With several --rig, or with --hold-out,
/// all rigs and the estimate are scored on the same matches: row offsets, the share of the image with matches in row,
/// the difference of the depths, and the better one, if significant. The verdict is about the first rig.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal check chess
  selfcal check nightly/ --rig rig/opencv/intrinsics.yml rig/opencv/extrinsics.yml --json
  selfcal check nightly/ --rig factory.yaml --rig calibrated/camchain.yaml --hold-out

Exit status: 0 good; 10 improvable: rows within 1 px, but the estimate aligns them better; 20 recalibrate: rows 1 px
off or more; 30 unknown: the line says why in brackets, and the JSON in `unknown`: too_few_pairs, not_one_moment,
too_few_matches, no_rig_fits, not_confirmed, cause_named, must_not_arm; 130 stopped by Ctrl-C, without a verdict; 1 error.
With --json, an error is an object with `error` too.")]
pub(crate) struct CheckArgs {
    #[command(flatten)]
    source: SourceArgs,

    /// Score on pairs that the estimate has not used: it uses every other pair.
    #[arg(long)]
    hold_out: bool,

    /// Print one JSON object instead of the line. Angles in rad.
    #[arg(long)]
    pub(super) json: bool,
}

/// Runs `selfcal check`.
pub(crate) fn check(args: &CheckArgs) -> Result<ExitCode> {
    let ran = args.source.run(None, None, true)?;
    if ran.session.stopped {
        let why = anyhow::anyhow!("stopped after {} pairs: no verdict", ran.session.pairs);
        if args.json {
            writeln!(io::stdout(), "{:#}", json_of(&why))?;
        }
        eprintln!("{why}");
        return Ok(ExitCode::from(130));
    }
    let report = Report::of(&ran.session, ran.rig.guessed)?;
    let scores = args.scores(&ran)?;
    let mut out = io::stdout();
    if args.json {
        let mut json = serde_json::to_value(&report)?;
        if let Some(scores) = &scores {
            json["scores"] = serde_json::to_value(scores)?;
        }
        writeln!(out, "{}", serde_json::to_string_pretty(&json)?)?;
    } else {
        writeln!(out, "{report}")?;
        if let Some(scores) = &scores {
            writeln!(out, "\n{scores}")?;
        }
    }
    Ok(ExitCode::from(report.verdict.status()))
}

impl CheckArgs {
    /// The scores of all rigs, if there is anything to compare.
    fn scores(&self, ran: &Ran) -> Result<Option<Scores>> {
        let rigs = self.source.rigs();
        if rigs.len() < 2 && !self.hold_out {
            return Ok(None);
        }
        let first =
            rigs.first().map_or_else(|| "the rig of the images".into(), |files| name(files));
        let mut all = vec![Candidate { name: first, rig: ran.session.set.meta.clone() }];
        for files in rigs.iter().skip(1) {
            all.push(Candidate { name: name(files), rig: self.source.other_rig(ran, files)? });
        }
        Scores::of(&ran.session.set, all, self.hold_out).map(Some)
    }
}
