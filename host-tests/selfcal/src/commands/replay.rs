//! `selfcal replay`.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use anyhow::{Result, ensure};
use clap::Args;
use indicatif::ProgressBar;
use page::run::Replayed;
use rigs::data::depths::{self, TrueDepth};
use rigs::data::ranges::{self, Ranges};
use rigs::data::{Dataset, tracked};
use sim::run::progress;
use sim::run::{Apply, DepthErrors, Feed, KeptPairs, Recommendation, RunLog, Step, trace};

use super::called;
use super::event_file::EventFile;
use crate::args::parse::choice;
use crate::args::recording::{Recording, RecordingArgs};
use crate::args::setup::Setup;
use crate::stream::{Clock, Streamed};

/// Feed a recorded data set, or a recorded stream of frames, to the calibrator, pair by pair, and compare the estimate
/// with the reference, if there is one.
///
/// A data set is a folder with meta.json (K_l, K_r, dist_l, dist_r, width, height, R, t) and pairs/NNNN.csv
/// (ul,vl,ur,vr,score and optionally step; pixels before undistortion). If the rig moves, rigs.csv
/// (r11,r12,...,r33,t1,t2,t3) has the rig of each pair, and meta.json that of the last; each pair and the estimate
/// after it are compared with the rig of that pair. Without R and t in meta.json the output has no errors, only rows,
/// states, reported deviations and the estimate.
///
/// One CSV file may have the matches of all pairs: one row for each match, and a first line that names the columns
/// frame,ul,vl,ur,vr and optionally score (1 without it) and step (0), in any order. frame is a whole number; the rows
/// of a frame follow each other. Give the file itself, or put it as pairs.csv in place of pairs/ into the folder of a
/// data set.
///
/// truth/NNNN.csv (match,depth_m; match: row of the pair's file from 0, depth along the left axis) has true depths of
/// a pair's matches: the median error of depth before and after is reported, px of disparity. It needs baseline_m in
/// meta.json.
///
/// R and t of a data set are the reference, and the run starts from a guess. R and t of a rig file, or of --initial, are
/// the start and a calibration, whose yaw is kept until the mount turns. meta.json may say how well the yaw of the start
/// is known (factory_yaw_sd_deg; null: a guess). The first line says what the run starts from.
///
/// A stream is a file of the bytes that a matcher sent (stereo_selfcal::link), as `selfcal record` writes it or a
/// vehicle has logged it; damaged frames are skipped and counted. The calibrator gets the same numbers as on the
/// vehicle, bit for bit, if it has the same capacity (--capacity).
///
/// `-` is standard input, for a CSV file or a stream; each pair is solved on arrival. The cameras and the reference
/// extrinsics come from --rig, or for a file from the meta.json beside it. Memory does not grow with the length, except
/// with --trace (1 kB a pair) and --report (all matches); in long runs the row offsets at the end cover every 2nd, 4th,
/// .. pair.
///
/// Every pair gets a line: matches taken, RMS row offset of the screened matches at the start and at
/// the solution, passes, error of the pair solved alone and of the running estimate, and the verdict.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal replay opencv_chess_corners
  selfcal replay motorcycle_sift --view top --degrees 5
  selfcal replay path/to/my_recording --initial factory.json --scalar f64 --json
  selfcal replay opencv_chess_sift --report target/page
  selfcal replay flight.scmf --rig path/to/meta.json --capacity 256
  selfcal replay matches.csv --rig camchain.yaml
  my_matcher | selfcal replay - --rig camchain.yaml

A file of all pairs, here of frames 0 and 1:
  frame,ul,vl,ur,vr,score
  0,812.4,300.1,770.9,301.7,0.92
  0,65.0,410.3,31.2,412.0,0.85
  1,813.0,299.8,771.3,301.5,0.90")]
pub(crate) struct ReplayArgs {
    #[command(flatten)]
    source: RecordingArgs,

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

    /// Exit with the status of `selfcal check`: 0 good, 10 improvable, 20 recalibrate, 30 unknown; otherwise 0.
    #[arg(long)]
    status: bool,

    /// Print only one JSON object. Angles in rad, R row-major. correction is added to the right camera (focal:
    /// relative, k1): R and t belong to the corrected cameras.
    #[arg(long)]
    json: bool,

    /// Write one row for each pair into this file: pair, state, verdict, armed, doubt, matches, fit, rms_px_in_use,
    /// rms_px_proposed, sd_rotation, sd_translation, the estimate (r11..r33,t1,t2,t3) and the extrinsics in use after
    /// the pair (u11..u33,v1,v2,v3). armed, fit and both RMS are of the verdict before the estimate is applied.
    /// If a lens was corrected, the corrections of the right camera follow: of the estimate (focal,k1) and in use
    /// (used_focal,used_k1). Angles in rad. A file of an earlier run is replaced.
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,

    /// Write one line of JSON for each change into this file: of the state, of the answers may_arm and should_apply, of
    /// the reasons, of the cause, or of the calibration in use (generation). A line has the number of the pair from 0,
    /// the changes and the verdict after it; time, us, comes from the frame of a stream, and is null otherwise. A file of an
    /// earlier run is replaced.
    #[arg(long, value_name = "FILE")]
    events: Option<PathBuf>,

    /// Write a page of the run into this folder: index.html with states, row offsets, errors, coverage
    /// and the estimates on their spheres, its numbers in csv/, and the calibrated rig for OpenCV, Kalibr
    /// and ROS in rig/. Files of an earlier page are replaced.
    #[arg(long, value_name = "DIR")]
    report: Option<PathBuf>,
}

/// Runs `selfcal replay`.
pub(crate) fn replay(args: &ReplayArgs) -> Result<ExitCode> {
    match args.source.open()? {
        Recording::Held(set) => {
            let turned = args.source.is_turned();
            ensure!(!(turned && args.motion), "--motion: the tracks belong to the unturned views");
            let (place, pairs) = (args.source.place(), set.pairs.len());
            let depths = if turned { None } else { depths::read(place, pairs)? };
            args.run(&set, depths.as_deref(), Some(place))
        }
        Recording::Streamed(stream) => args.run_streamed(stream),
    }
}

impl ReplayArgs {
    /// Runs the calibrator over a data set and prints the result.
    ///
    /// * `tracks`: folder of the tracked matches.
    fn run(
        &self,
        set: &Dataset,
        depths: Option<&[Vec<TrueDepth>]>,
        tracks: Option<&Path>,
    ) -> Result<ExitCode> {
        let (name, count) = (&set.name, set.pairs.len());
        let tracks = match tracks.filter(|_| self.motion) {
            Some(place) => tracked::read(place, count)?,
            None => Vec::new(),
        };
        let bar = progress::over(count, "pairs");
        let feed = Feed::of(set)?;
        let pairs = Box::new(feed.pairs.inspect(|_| bar.inc(1)));
        let feed = Feed { pairs, ranges: self.ranges()?, tracks, ..feed };
        let log = self.calibrate(
            &format!("{count} pairs of {name}: {}", set.meta.source),
            feed,
            (&bar, &Clock::default()),
        )?;
        self.print(set, depths, &log)
    }

    /// As [`Self::run`], over pairs that arrive one by one. All pairs are held in memory only for a page.
    fn run_streamed(&self, stream: Streamed) -> Result<ExitCode> {
        if self.report.is_some() {
            return self.run(&stream.collect()?, None, None);
        }
        let Streamed { name, meta, pairs, bar, clock } = stream;
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
        let log =
            self.calibrate(&format!("pairs of {name}: {}", meta.source), feed, (&bar, &clock))?;
        let set = Dataset { name, meta, pairs: kept.into_pairs(), rigs: Vec::new() };
        self.print(&set, None, &log)
    }

    fn ranges(&self) -> Result<Ranges> {
        self.ranges.as_deref().map(ranges::read).transpose().map(Option::unwrap_or_default)
    }

    /// Prints the result; returns the exit status.
    fn print(
        &self,
        set: &Dataset,
        depths: Option<&[Vec<TrueDepth>]>,
        log: &RunLog,
    ) -> Result<ExitCode> {
        if let Some(file) = &self.trace {
            trace::write(file, log.steps())?;
        }
        let mut summary = log.summary(set)?;
        if let Some(depths) = depths {
            summary.depth = DepthErrors::of(set, depths, log)?;
        }
        let mut out = io::stdout();
        let page = Replayed { set, log, depth: summary.depth, command: &called() };
        let page = self.report.as_ref().map(|dir| page.write(dir)).transpose()?;
        if self.json {
            writeln!(out, "{}", serde_json::to_string_pretty(&summary)?)?;
        } else {
            writeln!(out, "\n{summary}")?;
            if let Some(path) = page {
                writeln!(out, "page               {}", path.display())?;
            }
        }
        if self.status {
            return Ok(Recommendation::of(summary.verdict.as_ref()).status().into());
        }
        log.try_fused()?;
        Ok(ExitCode::SUCCESS)
    }

    fn calibrate(
        &self,
        title: &str,
        feed: Feed<'_>,
        (bar, clock): (&ProgressBar, &Clock),
    ) -> Result<RunLog> {
        let mut out = io::stdout();
        let mut events = self.events.as_deref().map(EventFile::create).transpose()?;
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
            if let (Some(events), Some(event), Ok(())) = (&mut events, &step.event, &written) {
                written = events.write(event, clock.get());
            }
        };
        let log = self.setup.replay(feed, self.apply, each);
        bar.finish_and_clear();
        written?;
        events.map_or(Ok(()), EventFile::end)?;
        log
    }
}
