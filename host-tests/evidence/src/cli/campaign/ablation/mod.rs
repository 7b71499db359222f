//! `cargo ablation`: every mechanism of the estimator off, one at a time, over the same pairs.

mod compare;
mod measure;
mod tree;

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};
use clap::Parser;

use tree::{Mechanism, copy, mechanisms};

/// Name of the file of runs with all mechanisms on.
const AS_IT_IS: &str = "as it is";

/// Switch each mechanism of the estimator off, and compare with the estimator as it is over the same pairs: all rows of
/// `campaign single`, `fused`, `real`, `steps`, `garbage`, and the recorded sets from 13 views.
///
/// Works on a copy of the tree in target/ablation, built once: there each mechanism has a switch. Runs that are
/// finished are not run again for the same code. Prints a row of markdown a mechanism.
#[derive(Debug, Parser)]
#[command(version)]
pub struct Ablation {
    /// Runs of each row of more than one pair; a recorded set has 13 views.
    #[arg(long, default_value_t = 48, value_name = "N", value_parser = clap::value_parser!(u64).range(13..))]
    trials: u64,

    /// Runs of each row of single pairs.
    #[arg(long, default_value_t = 400, value_name = "N", value_parser = clap::value_parser!(u64).range(4..))]
    single_trials: u64,

    /// Largest number of pairs of a run; longer runs show little that is new.
    #[arg(long, default_value_t = 60, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pairs: u16,

    /// Only mechanisms whose name begins with one of these [default: all].
    #[arg(long, value_name = "PREFIX", num_args = 1..)]
    only: Vec<String>,

    /// Print every row that changes, too.
    #[arg(long)]
    rows: bool,

    /// Print the table of the runs so far.
    #[arg(long)]
    table: bool,

    /// Measure; the copy of the tree calls it.
    #[arg(long, hide = true, value_name = "DIR")]
    into: Option<std::path::PathBuf>,
}

/// Switches the mechanism of that number off in this thread. The copy of the tree replaces its body.
fn switch(_number: usize) {}

impl Ablation {
    /// Runs the command.
    ///
    /// # Errors
    /// Names the mechanism whose text is not found in the tree. Also if the copy cannot be written, built or run.
    pub fn run(&self) -> Result<()> {
        let all = mechanisms()?;
        let chosen = |mechanism: &&Mechanism| {
            self.only.is_empty()
                || self.only.iter().any(|prefix| mechanism.name.starts_with(prefix))
        };
        let chosen: Vec<&Mechanism> = all.iter().filter(chosen).collect();
        ensure!(!chosen.is_empty(), "no mechanism begins with {}", self.only.join(" or "));
        let seeds = [self.single_trials, self.trials];
        if let Some(into) = &self.into {
            let mut names: Vec<(usize, String)> =
                chosen.iter().map(|mechanism| (mechanism.number, mechanism.name.clone())).collect();
            names.push((usize::MAX, AS_IT_IS.into()));
            return measure::measure(into, &names, seeds, self.pairs.into(), switch);
        }
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let place = root.join("target/ablation");
        let digest = copy(&root, &place.join("tree"), &all)?;
        // Other code, other mechanisms or other lengths are other runs.
        let into = place.join(format!("{digest}-{}", self.pairs));
        if !self.table {
            let status = Command::new("cargo")
                .args([
                    "run",
                    "--release",
                    "--package",
                    "selfcal-evidence",
                    "--bin",
                    "ablation",
                    "--",
                ])
                .args([format!("--trials={}", self.trials), format!("--pairs={}", self.pairs)])
                .args([format!("--single-trials={}", self.single_trials)])
                .args(self.only.iter().map(|prefix| format!("--only={prefix}")))
                .arg("--into")
                .arg(&into)
                .env("CARGO_TARGET_DIR", place.join("build"))
                .current_dir(place.join("tree"))
                .status()
                .context("cannot start cargo")?;
            ensure!(status.success(), "the copy in {} failed", place.display());
        }
        compare::print(&into, &root.join("core/src"), &chosen, self.rows)
    }
}
