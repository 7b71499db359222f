//! `selfcal replay`.

use anyhow::Result;
use clap::Args;

use super::run::RunArgs;
use super::source::Source;

/// Feed a recorded data set, or a recorded stream of frames, to the calibrator, pair by pair, and
/// compare with its reference, if it has one.
///
/// A data set is a folder with meta.json (K_l, K_r, dist_l, dist_r, width, height, R, t) and
/// pairs/NNNN.csv (ul,vl,ur,vr,score and optionally step; pixels before undistortion). Where the rig
/// moves, rigs.csv (r11,r12,...,r33,t1,t2,t3) has that of each pair, which the pair and the estimate
/// after it are then compared with, and meta.json that of the last. Without R and t in meta.json there are no
/// errors: rows, states, reported deviations and the estimate remain.
///
/// A stream is a file of the bytes that a matcher sent (stereo_selfcal::link), as `selfcal record` writes
/// it or a vehicle has logged it; damaged frames are skipped and counted. The
/// calibrator gets the same numbers as that of the vehicle, bit for bit, if it has the same capacity for
/// them (--capacity). The cameras, and the
/// extrinsics to compare with, are those of --rig.
///
/// Every pair gets a line: matches taken, RMS row offset of the screened matches at the start and at
/// the solution, passes, error of the pair solved alone and of the running estimate, and the verdict.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal replay opencv_chess_corners
  selfcal replay motorcycle_sift --view top --degrees 5
  selfcal replay path/to/my_recording --initial factory.json --scalar f64 --json
  selfcal replay opencv_chess_sift --report target/page
  selfcal replay flight.scmf --rig path/to/meta.json --capacity 256")]
pub(crate) struct ReplayArgs {
    #[command(flatten)]
    source: Source,

    #[command(flatten)]
    run: RunArgs,
}

/// Runs `selfcal replay`.
pub(crate) fn replay(args: &ReplayArgs) -> Result<()> {
    args.run.run(&args.source.read()?)
}
