//! `evidence evaluate`.

use std::io::{self, Write};
use std::path::PathBuf;

use super::tables::folder;
use crate::effort::Effort;
use crate::rivals::Range;
use crate::{Evaluated, Request, evaluate};
use anyhow::Result;
use clap::Args;
use sim::run::progress;

/// Compare the presets with the methods of the literature, and write the evidence as one page.
///
/// Recorded data sets from the paper's views, generated scenes over outliers, pairs, depth and noise, and a rig that is
/// knocked once; every method gets the same rays and the same start, and each rival runs with several settings, of
/// which the best counts. The page (index.html) contains its pictures and loads nothing; all its numbers are in the
/// files of csv/ beside it.
///
/// The same program writes the same page, whatever the number of threads.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence evaluate
  evidence evaluate --data path/to/my_recordings --out target/mine
  evidence evaluate --methods robust,paper,ling-shen --trials 200
  evidence evaluate --full --documents")]
pub struct EvaluateArgs {
    /// Folder of the page; made if missing. Files of an earlier evaluation in it are replaced.
    #[arg(long, value_name = "DIR", default_value = "target/evaluation")]
    out: PathBuf,

    /// Further data sets: a data set (a folder with meta.json and pairs/*.csv), or a folder of data sets. May be given
    /// more than once.
    #[arg(long, value_name = "DIR")]
    data: Vec<PathBuf>,

    /// Methods to compare, by name; all by default.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    methods: Vec<String>,

    /// Few trials: minutes. This is the default.
    #[arg(long, conflicts_with = "full")]
    quick: bool,

    /// Many trials, and every point of the curves: most of an hour on two cores.
    #[arg(long)]
    full: bool,

    /// Scenes of each point of a curve, instead of those of --quick or --full.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=100_000))]
    trials: Option<u64>,

    /// Settings of each method on the recordings: RANSAC or not, noise given or estimated, gate, annealing, rejection,
    /// steady or agile filters, in all combinations; or a few of them.
    #[arg(long, value_enum, default_value_t = Range::All)]
    settings: Range,

    /// Also write the tables and curves of EVIDENCE.md: cells, published, over-bound, knock.
    #[arg(long)]
    documents: bool,
}

/// Runs `evidence evaluate`.
pub(crate) fn evaluate_all(args: &EvaluateArgs) -> Result<()> {
    let bar = progress::over(0, "cells");
    let Evaluated { page, counts, cells } = evaluate(&args.request(), &args.out, &bar)?;
    bar.finish_and_clear();
    let mut out = io::stdout();
    let [all, failed] = [counts.measurements, counts.failed.len()];
    writeln!(out, "measurements {all}, {failed} failed")?;
    let [wins, ties, losses] = cells;
    writeln!(
        out,
        "recordings   {wins} wins, {ties} ties, {losses} losses against the best rival of each"
    )?;
    writeln!(out, "page         {}", page.display())?;
    Ok(())
}

impl EvaluateArgs {
    fn request(&self) -> Request {
        let effort = if self.full { Effort::FULL } else { Effort::QUICK };
        Request {
            data: self.data.clone(),
            methods: self.methods.clone(),
            effort: self.trials.map_or(effort, |trials| effort.with_trials(trials)),
            settings: self.settings,
            documents: self.documents.then(folder),
            command: self.command(),
        }
    }

    /// The command that reproduces the page. Folders are replaced by `DIR`.
    fn command(&self) -> String {
        let mut command = "cargo evidence evaluate".to_owned();
        if !self.data.is_empty() {
            command += " --data DIR";
        }
        if !self.methods.is_empty() {
            command = format!("{command} --methods {}", self.methods.join(","));
        }
        if self.full {
            command += " --full";
        }
        if let Some(trials) = self.trials {
            command = format!("{command} --trials {trials}");
        }
        if self.settings == Range::Few {
            command += " --settings few";
        }
        command
    }
}
