//! `selfcal export`.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use rigs::data::{Dataset, Meta};
use rigs::formats::{Document, Format};
use sim::run::{Apply, Feed};
use stereo_selfcal::State;

use crate::args::parse::choice;
use crate::args::recording::RecordingArgs;
use crate::args::setup::Setup;

/// Write a rig as files of OpenCV, Kalibr or ROS: the rig of a data set, or, with --replayed, the rig with the
/// estimated extrinsics.
///
/// Our convention: p_r = R p_l + t, |t| = 1, with the baseline in metres beside it; a side-by-side rig has t = (-1, 0,
/// 0). In OpenCV's files x_2 = R x_1 + T, so T = b t. In Kalibr's files T_cn_cnm1 of cam1 is [R b t; 0 1], with cam0
/// left. In ROS files the rectification matrices carry R and t, and the right camera has `P[0][3] = -fx b`. All lengths
/// are in metres; an unknown baseline is written as 1, with a comment.
///
/// With --replayed, row offsets that no extrinsics remove are written as lens_yaw, rad: the rectified right row is
/// below the left one by lens_yaw x y of the left ray (OpenCV: a number; Kalibr and ROS: a comment). A rectifier with a
/// look-up table can remove it.
///
/// Numbers are written with the digits that read back to the same bits.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal export opencv_chess_sift --format opencv --out calibrated --replayed
  selfcal export motorcycle_sift --format kalibr --out chain
  selfcal export flight.scmf --rig meta.json --replayed --format ros --out camera_info
  selfcal export path/to/meta.json --format ros --out camera_info")]
pub(crate) struct ExportArgs {
    #[command(flatten)]
    source: RecordingArgs,

    /// Format of another tool.
    #[arg(long, value_parser = choice::<Format>())]
    format: Format,

    /// Folder for the files; none of the files may exist.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,

    /// Replay the recording, and write the R and t that the calibrator then proposes; with --lens compensate, also
    /// their cameras.
    #[arg(long)]
    replayed: bool,

    /// Field of view of the rectified images across, degrees, to show a part of a fisheye [default: all that both
    /// cameras see; if that is too wide for a plane, the widest part].
    #[arg(long, value_name = "D")]
    field: Option<f64>,

    #[command(flatten)]
    setup: Setup,
}

/// Runs `selfcal export`.
pub(crate) fn export(args: &ExportArgs) -> Result<()> {
    let meta = args.meta()?;
    if meta.baseline_m.is_none() {
        eprintln!("the length of the baseline is unknown: it is written as 1");
    }
    let paths = Document::save_all(&args.format.write_part(&meta, args.field)?, &args.out)?;
    let mut out = io::stdout();
    for path in paths {
        writeln!(out, "{}", path.display())?;
    }
    Ok(())
}

impl ExportArgs {
    fn meta(&self) -> Result<Meta> {
        let place = self.source.place();
        if place.extension().is_some_and(|e| e == "json") {
            ensure!(!self.replayed, "{} is a rig: there is nothing to replay", place.display());
            return Dataset::find_meta(place);
        }
        let set = self.source.read()?;
        if self.replayed { self.calibrated(&set) } else { Ok(set.meta) }
    }

    fn calibrated(&self, set: &Dataset) -> Result<Meta> {
        let log = self.setup.replay(Feed::of(set)?, Apply::Never, |_| ())?;
        let estimate = log.try_fused().with_context(|| set.name.clone())?;
        eprintln!("{} pairs of {}: {estimate}", set.pairs.len(), set.name);
        if estimate.state != State::Locked || estimate.is_doubtful() {
            eprintln!("the calibrator does not confirm this estimate");
        }
        Ok(estimate.rig(&set.meta))
    }
}
