//! The common part of `replay` and `synth`: a run and its output.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use indicatif::ProgressBar;
use page::run::Replayed;
use rigs::data::Dataset;
use rigs::data::depths::TrueDepth;
use rigs::data::ranges::{self, Ranges};
use rigs::data::tracked::Track;
use sim::run::progress;
use sim::run::{Apply, DepthErrors, Feed, KeptPairs, RunLog, Step, trace};

use super::choice;
use super::input::Streamed;
use super::setup::Setup;

/// A run and its output.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    #[command(flatten)]
    setup: Setup,

    /// When the estimate is applied.
    #[arg(long, value_parser = choice::<Apply>(), default_value_t = Apply::Never)]
    apply: Apply,

    /// Points at known distances: a CSV file with the columns pair,u,v,range_m,sd_m,along and optionally ur,vr. pair:
    /// from 0; u, v: pixel of the left image; along: ray or axis; ur, vr: the same point in the right image; without
    /// them a match within 3 px of u, v tells it. The points tell yaw from the lens, and need baseline_m.
    #[arg(long, value_name = "FILE")]
    ranges: Option<PathBuf>,

    /// Use the tracked matches of quads/NNNN.csv (ul1,vl1,ur1,vr1,ul2,vl2,ur2,vr2): matches of pair NNNN and the same
    /// matches in a later pair, after a motion of the rig. They tell yaw from the lens.
    #[arg(long)]
    motion: bool,

    /// Print only one JSON object. Angles in rad, R row-major. correction is added to the right camera (focal:
    /// relative, k1): R and t belong to the corrected cameras.
    #[arg(long)]
    json: bool,

    /// Write one row for each pair into this file: pair, state, verdict, armed, doubt, matches, fit, rms_px_in_use,
    /// rms_px_proposed, sd_rotation, sd_translation, the estimate (r11..r33,t1,t2,t3) and the extrinsics in use after
    /// the pair (u11..u33,v1,v2,v3). The health behind armed, fit and both RMS is read before the estimate is applied.
    /// If a lens was corrected, the corrections of the right camera follow: of the estimate (focal,k1) and in use
    /// (used_focal,used_k1). Angles in rad. A file of an earlier run is replaced.
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
    pub(crate) fn run(&self, set: &Dataset) -> Result<()> {
        self.run_with(set, None, (Ranges::new(), Vec::new()))
    }

    /// Whether tracked matches are used.
    pub(crate) fn uses_motion(&self) -> bool {
        self.motion
    }

    /// As [`Self::run`], with the true depths of matches, and with ranges and tracked matches in addition to those of
    /// the options.
    pub(crate) fn run_with(
        &self,
        set: &Dataset,
        depths: Option<&[Vec<TrueDepth>]>,
        (mut ranges, tracks): (Ranges, Vec<Vec<Track>>),
    ) -> Result<()> {
        for (pair, more) in self.ranges()? {
            ranges.entry(pair).or_default().extend(more);
        }
        let bar = progress::over(set.pairs.len(), "pairs");
        let feed = Feed::of(set)?;
        let pairs = Box::new(feed.pairs.inspect(|_| bar.inc(1)));
        let title = format!("{} pairs of {}: {}", set.pairs.len(), set.name, set.meta.source);
        let feed = Feed { pairs, ranges, tracks, ..feed };
        let log = self.replay(&title, feed, &bar)?;
        self.print(set, depths, &log)
    }

    /// As [`Self::run`], over pairs that arrive one by one. All pairs are held in memory only for a page.
    pub(crate) fn run_streamed(&self, stream: Streamed) -> Result<()> {
        if self.report.is_some() {
            return self.run(&stream.collect()?);
        }
        let Streamed { name, meta, pairs, bar } = stream;
        let mut kept = KeptPairs::default();
        let pairs = pairs.inspect(|pair| pair.iter().for_each(|pair| kept.offer(pair)));
        let feed = Feed {
            rig: &meta,
            truths: Vec::new(),
            pairs: Box::new(pairs),
            ranges: self.ranges()?,
            tracks: Vec::new(),
            brief: self.trace.is_none(),
        };
        let log = self.replay(&format!("pairs of {name}: {}", meta.source), feed, &bar)?;
        let set = Dataset { name, meta, pairs: kept.into_pairs(), rigs: Vec::new() };
        self.print(&set, None, &log)
    }

    fn ranges(&self) -> Result<Ranges> {
        self.ranges.as_deref().map(ranges::read).transpose().map(Option::unwrap_or_default)
    }

    fn print(&self, set: &Dataset, depths: Option<&[Vec<TrueDepth>]>, log: &RunLog) -> Result<()> {
        if let Some(file) = &self.trace {
            trace::write(file, log.steps())?;
        }
        let mut summary = log.summary(set)?;
        if let Some(depths) = depths {
            summary.depth = DepthErrors::of(set, depths, log)?;
        }
        let mut out = io::stdout();
        let page =
            self.report.as_ref().map(|dir| write_page(set, log, summary.depth, dir)).transpose()?;
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

    fn replay(&self, title: &str, feed: Feed<'_>, bar: &ProgressBar) -> Result<RunLog> {
        let mut out = io::stdout();
        if !self.json {
            writeln!(out, "{title}")?;
            writeln!(out, "pair {}", Step::HEADING)?;
        }
        let mut lines = 0..;
        let mut written = Ok(());
        let each = |step: &Step| {
            if let (false, Some(i), Ok(())) = (self.json, lines.next(), &written) {
                written = bar.suspend(|| writeln!(out, "{i:>4} {step}"));
            }
        };
        let log = self.setup.replay(feed, self.apply, each);
        bar.finish_and_clear();
        written?;
        log
    }
}

fn write_page(
    set: &Dataset,
    log: &RunLog,
    depth: Option<DepthErrors>,
    dir: &Path,
) -> Result<PathBuf> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let command = format!("selfcal {}", arguments.join(" "));
    Replayed { set, log, depth, command: &command }.write(dir)
}
