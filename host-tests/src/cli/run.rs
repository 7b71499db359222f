//! The common part of `replay` and `synth`: a run and its output.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use host_tests::data::Dataset;
use host_tests::evidence::run_page::Replayed;
use host_tests::run::{Apply, RunLog, Step, progress, trace};

use super::setup::Setup;

/// A run and its output.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    setup: Setup,

    /// When the estimate is put into use.
    #[arg(long, value_enum, default_value_t = Apply::Never)]
    apply: Apply,

    /// Print one JSON object and nothing else. Angles in rad, R row-major. correction is added to the
    /// right camera (focal: relative, k1): R and t belong to the cameras with it.
    #[arg(long)]
    json: bool,

    /// Write a row a pair into this file: pair, state, verdict, armed, doubt, matches, fit, rms_px_in_use,
    /// rms_px_proposed, sd_rotation, sd_translation, the estimate (r11..r33,t1,t2,t3) and what is in use
    /// after the pair (u11..u33,v1,v2,v3). The health behind armed, fit and both RMS is read before the
    /// estimate is applied. Where a lens was corrected, the corrections of the right camera follow: those that
    /// the estimate belongs to (focal,k1), and what is in use (used_focal,used_k1). Angles in rad. A file of an
    /// earlier run is replaced.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,

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
        if let Some(file) = &self.trace {
            trace::write(file, log.steps())?;
        }
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
        log.try_fused()?;
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
        let log = self.setup.replay(set, self.apply, each)?;
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
