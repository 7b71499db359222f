//! `selfcal replay`.

use anyhow::{Result, ensure};
use clap::Args;
use rigs::data::ranges::Ranges;
use rigs::data::{depths, tracked};

use crate::args::recording::{Recording, Source};
use crate::args::run::RunArgs;

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
/// The start counts as a calibration of yaw if it is given (--initial), or if the recorded images have no distortion;
/// meta.json may override this (factory_yaw_sd_deg, null: a guess).
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
    source: Source,

    #[command(flatten)]
    run: RunArgs,
}

/// Runs `selfcal replay`.
pub(crate) fn replay(args: &ReplayArgs) -> Result<()> {
    match args.source.open()? {
        Recording::Held(set) => {
            let (place, pairs) = (args.source.place(), set.pairs.len());
            let is_turned = args.source.is_turned();
            let depths = if is_turned { None } else { depths::read(place, pairs)? };
            ensure!(
                !(is_turned && args.run.uses_motion()),
                "--motion: the tracks belong to the unturned views"
            );
            let tracks =
                if args.run.uses_motion() { tracked::read(place, pairs)? } else { Vec::new() };
            args.run.run_with(&set, depths.as_deref(), (Ranges::new(), tracks))
        }
        Recording::Streamed(stream) => args.run.run_streamed(stream),
    }
}
