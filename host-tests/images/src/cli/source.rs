//! Where images, rig and matcher come from: what both commands ask for.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::live::Live;
use crate::matcher::MatcherConfig;
use crate::pipeline::{Selection, first_size};
use crate::rig::{FoundRig, RigRequest};
use crate::session::{self, Request, Session};
use crate::source::Source;
use anyhow::{Context, Result, ensure};
use clap::Args;

/// Set by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

/// Images and their rig.
#[derive(Debug, Args)]
pub(crate) struct SourceArgs {
    /// A folder, an MCAP file (*.mcap), a ROS 1 bag (*.bag), or the left and the right folder, file or quoted
    /// pattern. Or images that come with the project: chess, motorcycle, aloe.
    #[arg(required = true, num_args = 1..=2, value_name = "SOURCE")]
    source: Vec<PathBuf>,

    /// The calibration of the rig; where it is left out, the one beside the images is taken. See `selfcal import
    /// --help` for the formats: OpenCV, Kalibr, ROS, EuRoC, KITTI, Middlebury, RealSense, Luxonis, or a meta.json.
    #[arg(long, value_name = "FILE", num_args = 1..=2)]
    rig: Vec<PathBuf>,

    /// No calibration: a guess from this focal length, px. Where it is left out, too, that of the EXIF data.
    #[arg(long, value_name = "PX", conflicts_with = "rig")]
    focal: Option<f64>,

    /// Topics of the left and the right images of a bag.
    #[arg(long, value_parser = topics, value_name = "LEFT,RIGHT")]
    topics: Option<[String; 2]>,

    /// By how much the time stamps of a pair may differ, s.
    #[arg(long, default_value_t = 0.005, value_name = "S")]
    tolerance: f64,

    /// Take every so many pairs.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = at_least_one)]
    every: usize,

    /// Take at most so many pairs.
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pairs: Option<usize>,

    /// How far the cameras may have turned since the rig was calibrated, degrees: half the band that is searched
    /// around the expected rows.
    #[arg(long, default_value_t = MatcherConfig::default().prior_deg, value_name = "D")]
    prior: f64,

    /// Corners sought in each image.
    #[arg(long, default_value_t = MatcherConfig::default().keypoints, value_name = "N", value_parser = at_least_one)]
    keypoints: usize,
}

fn at_least_one(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| format!("`{text}` is not a number from 1"))
}

fn topics(text: &str) -> Result<[String; 2], String> {
    let (left, right) = text.split_once(',').ok_or("two topics with a comma between are needed")?;
    Ok([left, right].map(|topic| topic.trim().to_owned()))
}

/// A run that is over.
pub(crate) struct Ran {
    pub(crate) rig: FoundRig,
    pub(crate) session: Session,
}

impl SourceArgs {
    /// Runs the calibrator over the images.
    ///
    /// * `frames`, `out`: where frames and the data set go, pair by pair.
    pub(crate) fn run(
        &self,
        frames: Option<&Path>,
        out: Option<&Path>,
        quiet: bool,
    ) -> Result<Ran> {
        ensure!((0.1..=20.0).contains(&self.prior), "the prior must be from 0.1 to 20 degrees");
        // A second Ctrl-C ends the command at once.
        let _ = ctrlc::set_handler(|| {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
            eprintln!("stopping after the pairs that have begun; again to end at once");
        });
        let source = Source::open(&self.source, self.topics.clone(), self.tolerance)?;
        let (size, frame) = first_size(&source)?;
        let request = RigRequest { files: self.rig.clone(), focal_px: self.focal };
        let rig = request.find(&source.rig, size, &frame).context("the rig")?;
        for note in &rig.notes {
            eprintln!("note: {note}");
        }
        let selection = Selection { every: self.every, most: self.pairs.unwrap_or(usize::MAX) };
        let count = source.count.map(|n| n.div_ceil(self.every).min(selection.most));
        let matcher = MatcherConfig {
            prior_deg: self.prior,
            keypoints: self.keypoints,
            ..MatcherConfig::default()
        };
        let mut live = Live::new(count, quiet);
        let request = Request { source: &source, rig: &rig, matcher, selection, frames, out };
        let session = session::run(&request, &STOP, &mut live);
        live.finish();
        Ok(Ran { session: session?, rig })
    }
}
