//! The common part of `replay` and `synth`: a run and its output.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use clap::Args;
use host_tests::data::Dataset;
use host_tests::evidence::run_page::Replayed;
use host_tests::run::{RunLog, Step, progress};

use super::setup::Setup;

/// A run and its output.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    setup: Setup,

    /// Print one JSON object and nothing else. Angles in rad, R row-major.
    #[arg(long)]
    json: bool,

    /// Write a page of the run into this folder: index.html with states, row offsets, errors, coverage
    /// and the estimates on their spheres, its numbers in csv/, and the calibrated rig for OpenCV, Kalibr
    /// and ROS in rig/. Files of an earlier page are replaced.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

impl RunArgs {
    /// Runs the calibrator over a data set and prints the result.
    pub(super) fn run(&self, set: &Dataset) -> Result<()> {
        let log = self.replay(set)?;
        let summary = log.summary(set)?;
        let mut out = io::stdout();
        let page = self.report.as_ref().map(|dir| write_page(set, &log, dir)).transpose()?;
        if self.json {
            writeln!(out, "{}", serde_json::to_string_pretty(&summary)?)?;
        } else {
            writeln!(out, "\n{summary}")?;
            if let Some(path) = page {
                writeln!(out, "page               {}", path.display())?;
            }
        }
        if log.fused().is_none() {
            bail!("none of the {} pairs could be fused", set.pairs.len());
        }
        Ok(())
    }

    fn replay(&self, set: &Dataset) -> Result<RunLog> {
        let mut out = io::stdout();
        if !self.json {
            writeln!(out, "{} pairs of {}: {}", set.pairs.len(), set.name, set.meta.source)?;
            writeln!(out, "pair {}", Step::HEADING)?;
        }
        let bar = progress::over(set.pairs.len(), "pairs");
        let mut lines = 0..;
        let mut written = Ok(());
        let each = |step: &Step| {
            if let (false, Some(i), Ok(())) = (self.json, lines.next(), &written) {
                written = bar.suspend(|| writeln!(out, "{i:>4} {step}"));
            }
            bar.inc(1);
        };
        let log = self.setup.replay(set, each)?;
        bar.finish_and_clear();
        written?;
        Ok(log)
    }
}

fn write_page(set: &Dataset, log: &RunLog, dir: &Path) -> Result<PathBuf> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let command = format!("selfcal {}", arguments.join(" "));
    Replayed { set, log, command: &command }.write(dir)
}
