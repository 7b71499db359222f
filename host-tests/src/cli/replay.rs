//! `selfcal replay`.

use std::fs;
use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use clap::Args;
use host_tests::dataset::{Dataset, Meta};
use host_tests::view::View;
use host_tests::wire::Recording;

use super::run::RunArgs;

/// Feed a recorded data set, or a recorded stream of frames, to the calibrator, pair by pair, and
/// compare with its reference.
///
/// A data set is a folder with meta.json (K_l, K_r, dist_l, dist_r, width, height, R, t) and
/// pairs/NNNN.csv (ul,vl,ur,vr,score and optionally step; pixels before undistortion). Where the rig
/// moves, rigs.csv (r11,r12,...,r33,t1,t2,t3) has that of each pair, which the pair and the estimate
/// after it are then compared with, and meta.json that of the last.
///
/// A stream is a file of the bytes that a matcher sent (stereo_selfcal::link), as `selfcal record` writes
/// it or a vehicle has logged it; what was damaged on the way is passed over, and counted. The
/// calibrator takes in the same numbers as that of the vehicle, bit for bit, if it has the same room for
/// them (--capacity). The cameras, and the
/// extrinsics to compare with, are those of --rig.
///
/// Every pair gets a line: matches taken, RMS row offset of the screened matches at the start and at
/// the solution, passes, error of the pair alone and of the running estimate, and what became of it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal replay opencv_chess_corners
  selfcal replay motorcycle_sift --view top --degrees 5
  selfcal replay path/to/my_recording --initial factory.json --scalar f64 --json
  selfcal replay flight.scmf --rig path/to/meta.json --capacity 256")]
pub(crate) struct ReplayArgs {
    /// Folder of a data set, or the name of one that comes with the project: opencv_chess_corners,
    /// opencv_chess_sift, motorcycle_sift, aloe_sift. Or the file of a stream.
    #[arg(value_name = "DIR|FILE")]
    set: PathBuf,

    /// Rig of a stream: a meta.json, or a data set that has one.
    #[arg(long, value_name = "FILE|DIR")]
    rig: Option<PathBuf>,

    /// Turn the left view, as if its camera looked up (top), down, left or right: R becomes
    /// R Rot^T, points that leave the image are dropped. A rectified set is evidence only if turned.
    #[arg(long, value_enum)]
    view: Option<View>,

    /// By how much the view is turned.
    #[arg(long, default_value_t = 5.0, requires = "view", value_name = "D")]
    degrees: f64,

    #[command(flatten)]
    run: RunArgs,
}

impl ReplayArgs {
    fn set(&self) -> Result<Dataset> {
        if !self.set.is_file() {
            ensure!(self.rig.is_none(), "--rig is for a stream: a data set has a rig of its own");
            return Dataset::find(&self.set);
        }
        let name = self.set.display();
        let rig = self.rig.as_ref();
        let rig =
            rig.with_context(|| format!("{name} is a stream: --rig says of which cameras"))?;
        let bytes = fs::read(&self.set).with_context(|| format!("cannot read {name}"))?;
        let recording = Recording::decode(&bytes);
        eprintln!("{name}: {recording}");
        recording.dataset(&name.to_string(), Meta::find(rig)?)
    }
}

/// Runs `selfcal replay`.
pub(crate) fn replay(args: &ReplayArgs) -> Result<()> {
    let set = args.set()?;
    ensure!(args.degrees.abs() <= 45.0, "a view can be turned by at most 45 degrees");
    let set = match args.view {
        Some(view) => view.turn(&set, args.degrees)?,
        None => set,
    };
    args.run.run(&set)
}
