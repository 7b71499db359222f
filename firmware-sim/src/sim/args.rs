//! The command line.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use emulator::{Board, seconds};
use rigs::data::Dataset;

/// Run the controller's firmware on this computer, with a recorded data set instead of the matcher.
///
/// Each stereo pair of the data set becomes a frame of fixed-point correspondences (1/256 px) on a simulated SPI bus
/// with a data-ready line. The firmware's loop reads the frame, solves the pair for R and t (p_r = R p_l + t, |t| = 1)
/// from the start R = I, t = (-1, 0, 0), and fuses it with the earlier pairs. Code and arithmetic equal those of
/// the controller: f32, up to 512 correspondences per pair. From longer frames it selects by spread over the image and by
/// score.
#[derive(Debug, Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true,
    after_help = "Columns:
  matches              correspondences in the batch
  rows px before>after RMS row offset of the pair's screened matches, before and after the solution
  passes               passes over the batch until the solver stopped
  pair e_t, e_theta    error of this pair alone, baseline direction and rotation
  running              error of the estimate after this pair
  verdict              fused, kept apart, refused or not solved, with the reason

At the end, an estimate that is locked, that is, confirmed by several pairs, is applied. Any other
estimate is printed with the reason why it is not applied.

Exit status: 0 if there is an estimate at the end, 1 otherwise.

Examples:
  cargo run
  cargo run -- opencv_chess_corners
  cargo run -- path/to/my_recording --plot my_recording.svg
  cargo run -- flight
  cargo run -- pil motorcycle_sift"
)]
pub(super) struct Cli {
    #[command(subcommand)]
    pub(super) command: Option<Command>,

    #[command(flatten)]
    pub(super) replay: ReplayArgs,
}

#[derive(Debug, Subcommand)]
pub(super) enum Command {
    Flight(FlightArgs),
    Pil(PilArgs),
}

#[derive(Debug, Args)]
pub(super) struct ReplayArgs {
    /// Folder of a data set (meta.json, pairs/*.csv), or the name of a data set of the
    /// project: opencv_chess_corners, opencv_chess_sift, motorcycle_sift, aloe_sift, oak_sift.
    #[arg(value_name = "DATASET", default_value = "opencv_chess_sift")]
    set: PathBuf,

    /// File of the plot (SVG); its folder is created [default: target/firmware-sim/<DATASET>.svg].
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

impl ReplayArgs {
    /// Reads the data set.
    pub(super) fn dataset(&self) -> Result<Dataset> {
        Dataset::find(&self.set)
    }

    /// Path of the plot.
    pub(super) fn plot(&self, set: &Dataset) -> PathBuf {
        let default = || PathBuf::from("target/firmware-sim").join(format!("{}.svg", set.name));
        self.plot.clone().unwrap_or_else(default)
    }
}

/// Simulate a flight with a generated rig that vibrates, drifts thermally and is knocked at half time.
///
/// Each pair: 256 matches, 30 % of them outliers, 0.3 px of noise on the others; points 3 to 80 baselines away on the
/// ground, ten times as far at the highest point. The right camera vibrates by 0.005 degrees RMS about each axis from
/// pair to pair and drifts by 0.05 degrees during the flight. The firmware applies its estimate as soon as it is
/// locked. Errors are against the generated rig without its vibration, which a calibration cannot follow.
#[derive(Debug, Args)]
#[command(
    after_help = "Prints a line for every pair that changes state or reasons or is not plainly fused, and for every 50th:
  state        acquiring, locked, suspect (the last pairs disagree), lost
  rows px      RMS row offset in use beyond that of the pair's own pose
  depth px     expected RMS error of the disparities in use
  cover        share of the matches of the pair's own pose that fit the calibration in use
  sigma deg    reported standard deviations of R and t
  weakest      direction of the largest standard deviation, and its value in degrees
  arm          result of the arming check
  apply        whether applying the estimate is worthwhile
  what         result of the pair

Exit status: 0 if the flight ends locked, 1 otherwise."
)]
pub(super) struct FlightArgs {
    /// Number of stereo pairs; the knock is at half of them.
    #[arg(long, default_value_t = 400, value_name = "N",
          value_parser = clap::value_parser!(u16).range(2..))]
    pub(super) pairs: u16,

    /// Rotation of the right camera by the knock, about a random axis, degrees.
    #[arg(long, default_value_t = 0.3, value_name = "D", allow_hyphen_values = true,
          value_parser = knock)]
    pub(super) knock: f64,

    /// Length of the baseline, m, for the rangefinder.
    #[arg(long, default_value_t = 0.12, value_name = "M", allow_hyphen_values = true,
          value_parser = length)]
    pub(super) baseline: f32,

    /// Read a laser rangefinder every tenth pair: 1 % of noise, at a point that the matcher sees; one reading in ten
    /// is of something nearer. It tells the yaw of the mount, on which depth rests, from an error of the lens.
    #[arg(long)]
    pub(super) rangefinder: bool,

    /// Let the vehicle move by 4 baselines before every tenth pair. The matcher tracks points over the move and sends their
    /// tracks, which tell the yaw of the mount from an error of the lens too.
    #[arg(long)]
    pub(super) motion: bool,

    /// Simulate hardware faults: 5 % of the frames damaged, 3 % lost, 2 % sent twice, noise after 2 %;
    /// data-ready stuck for some pairs in every hundred; power lost every fifty pairs, in half of the
    /// cases during a save. The firmware restores its estimate from flash.
    #[arg(long)]
    pub(super) faults: bool,

    /// Seed of the generator. The same seed gives the same flight.
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,

    /// File of the plot (SVG); its folder is created.
    #[arg(long, value_name = "FILE", default_value = "target/firmware-sim/flight.svg")]
    pub(super) plot: PathBuf,
}

/// Run the same pairs on this computer and on an emulated controller, and compare the results bit for
/// bit.
///
/// Builds an image with the frames of the data set, and runs it in QEMU. The firmware's decoder and loop process the
/// frames. After each pair the controller prints a checksum over all that the loop returns, R and t, deviations, passes,
/// result and verdict, and over the record that restores its state. This computer runs the same code. Arithmetic is f32
/// on both.
#[derive(Debug, Args)]
#[command(
    after_help = "Needs qemu-system-arm, and a compiler for thumbv7em-none-eabihf that .cargo/for-target finds.

Exit status: 0 if every pair is bit-identical, 1 otherwise.

Examples:
  cargo run -- pil
  cargo run -- pil path/to/my_recording --board m7"
)]
pub(super) struct PilArgs {
    /// Folder of a data set, or the name of a data set of the project.
    #[arg(value_name = "DATASET", default_value = "opencv_chess_sift")]
    set: PathBuf,

    /// Board that QEMU emulates.
    #[arg(long, default_value = "m4f", value_parser = Board::parser())]
    pub(super) board: &'static Board,

    /// Image to run, with the frames of the data set; builds none.
    #[arg(long, value_name = "FILE")]
    pub(super) image: Option<PathBuf>,

    /// Timeout of the run on the controller, s.
    #[arg(long, value_name = "S", default_value = "300", value_parser = seconds)]
    pub(super) timeout: Duration,
}

impl PilArgs {
    /// Reads the data set.
    pub(super) fn dataset(&self) -> Result<Dataset> {
        Dataset::find(&self.set)
    }
}

fn knock(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|d: &f64| d.abs() <= 10.0);
    degrees.ok_or_else(|| "a turn from -10 to 10 degrees is needed".into())
}

fn length(text: &str) -> Result<f32, String> {
    let metres = text.parse().ok().filter(|m: &f32| *m > 0.0 && m.is_finite());
    metres.ok_or_else(|| "a length above 0 m is needed".into())
}
