//! `selfcal replay`.

use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::Args;
use host_tests::dataset::Dataset;
use host_tests::view::View;

use super::run::RunArgs;

/// Feed a recorded data set to the calibrator, pair by pair, and compare with its reference.
///
/// A data set is a folder with meta.json (K_l, K_r, dist_l, dist_r, width, height, R, t) and
/// pairs/NNNN.csv (ul,vl,ur,vr,score and optionally step; pixels before undistortion). Where the rig
/// moves, rigs.csv (r11,r12,...,r33,t1,t2,t3) has that of each pair, which the pair and the estimate
/// after it are then compared with, and meta.json that of the last.
///
/// Every pair gets a line: matches taken, RMS row offset of the screened matches at the start and at
/// the solution, passes, error of the pair alone and of the running estimate, and what became of it.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal replay opencv_chess_corners
  selfcal replay motorcycle_sift --view top --degrees 5
  selfcal replay path/to/my_recording --initial factory.json --scalar f64 --json")]
pub(crate) struct ReplayArgs {
    /// Folder of a data set, or the name of one that comes with the project: opencv_chess_corners,
    /// opencv_chess_sift, motorcycle_sift, aloe_sift.
    #[arg(value_name = "DIR")]
    set: PathBuf,

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

/// Runs `selfcal replay`.
pub(crate) fn replay(args: &ReplayArgs) -> Result<()> {
    let set = Dataset::find(&args.set)?;
    ensure!(args.degrees.abs() <= 45.0, "a view can be turned by at most 45 degrees");
    let set = match args.view {
        Some(view) => view.turn(&set, args.degrees)?,
        None => set,
    };
    args.run.run(&set)
}
