//! The command line.

use std::path::PathBuf;
use std::time::Duration;

use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use host_tests::data::Dataset;

use super::emulator::Machine;

/// Run the controller's firmware on this computer, with a recorded data set in place of the
/// matcher.
///
/// Each stereo pair of the data set becomes a frame of fixed-point correspondences (1/256 px) on a
/// simulated SPI bus with a data-ready line. The firmware's own loop reads it, solves the pair for R
/// and t (p_r = R p_l + t, |t| = 1) starting at R = I, t = (-1, 0, 0), and fuses it with the pairs
/// before. Arithmetic and code are those of the controller: f32, 512 correspondences a pair,
/// selected from longer frames for their spread over the image and their score.
#[derive(Debug, Parser)]
#[command(
    version,
    args_conflicts_with_subcommands = true,
    disable_help_subcommand = true,
    after_help = "Columns:
  matches              correspondences taken into the batch
  rows px before>after RMS row offset of the pair's screened matches, at the start and solved
  passes               passes over the batch until the solver stopped
  pair e_t, e_theta    error of this pair alone, baseline direction and rotation
  running              the same of all pairs fused so far
  verdict              fused, kept apart, refused, or not solved, and why

The estimate is put into use at the end if it is locked, that is, if some pairs agree on it.
Otherwise it is shown with the reason why not, as for a set of a single pair.

Exit status: 0 if there is an estimate at the end, 1 if not.

Examples:
  cargo run --release
  cargo run --release -- opencv_chess_corners
  cargo run --release -- path/to/my_recording --plot my_recording.svg
  cargo run --release -- flight
  cargo run --release -- pil motorcycle_sift"
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
    #[cfg(feature = "logs")]
    Emulate(EmulateArgs),
}

#[derive(Debug, Args)]
pub(super) struct ReplayArgs {
    /// Folder of a data set (meta.json, pairs/*.csv), or the name of one that comes with the
    /// project: opencv_chess_corners, opencv_chess_sift, motorcycle_sift, aloe_sift.
    #[arg(value_name = "DATASET", default_value = "opencv_chess_sift")]
    set: PathBuf,

    /// Where the plot goes (SVG); folders are created [default: target/firmware-sim/<DATASET>.svg].
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

/// Fly a generated rig that vibrates, warps with heat and is knocked in mid flight, with the firmware
/// calibrating it all the while.
///
/// Each pair: 256 matches, 30 % of them wrong, 0.3 px of noise on the others; points 3 to 80 baselines
/// away on the ground, ten times that at the highest point. The right camera turns by 0.005 degrees
/// RMS about each axis from pair to pair and by 0.05 degrees in the course of the flight. What the
/// firmware estimates is put into use as soon as it is locked. Errors are against the generated rig
/// without its vibration, which no calibration can follow.
#[derive(Debug, Args)]
#[command(after_help = "A line for every pair that changes something, and for every 50th:
  state        acquiring, locked, suspect (the last pairs disagree), lost
  band         of the RMS row offset in use: good, improvable, recalibrate
  rows px      RMS row offset of the matches that fit the estimate, as in use and as proposed
  fit          matches within 3 px of their row, as in use and as proposed
  sigma deg    reported standard deviations of R and t
  weakest      its least certain direction, and the standard deviation in degrees
  cover        share of the left image that has a match that fits
  depth error  expected at 1, 2, 5 and 10 m with what is in use, m
  arm          what an arming check is told
  what         what became of the pair

Exit status: 0 if the flight ends locked, 1 if not.")]
pub(super) struct FlightArgs {
    /// Stereo pairs of the flight; the knock is in the middle.
    #[arg(long, default_value_t = 400, value_name = "N",
          value_parser = clap::value_parser!(u16).range(2..))]
    pub(super) pairs: u16,

    /// Turn of the right camera in mid flight, about a random axis, degrees.
    #[arg(long, default_value_t = 0.3, value_name = "D", allow_hyphen_values = true,
          value_parser = knock)]
    pub(super) knock: f64,

    /// Length of the baseline, m: what depth errors are predicted for.
    #[arg(long, default_value_t = 0.12, value_name = "M", allow_hyphen_values = true,
          value_parser = length)]
    pub(super) baseline: f32,

    /// Let the hardware fail: 5 % of the frames damaged, 3 % lost, 2 % sent twice, noise after 2 %;
    /// data-ready stuck for some pairs in every hundred, and power lost every fifty pairs, as like as
    /// not while the controller saves. What was learnt is taken up from flash again.
    #[arg(long)]
    pub(super) faults: bool,

    /// Seed of the generator: the same flight for the same seed.
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u64,

    /// Where the plot goes (SVG); folders are created.
    #[arg(long, value_name = "FILE", default_value = "target/firmware-sim/flight.svg")]
    pub(super) plot: PathBuf,
}

/// Run the same pairs here and on an emulated controller, and compare what comes of each, bit for bit.
///
/// The image is built for the controller and started in QEMU. Cameras and frames go into its UART, and
/// through the firmware's own decoder and loop; after each pair it sends what it made of it: R and t of
/// the pair and of the estimate, deviations, passes, state, verdict, health. This computer does the same
/// with the same code. Arithmetic is f32 on both.
#[derive(Debug, Args)]
#[command(
    after_help = "Columns: `bits` says whether all that the controller sent is the same, the others \
are those of the replay (`--help` of the program), of both.

Needs qemu-system-arm, and a compiler for thumbv7em-none-eabihf as .cargo/for-target finds it.

Exit status: 0 if every pair is the same in all bits, 1 if not, or if the controller does not answer.

Examples:
  cargo run --release -- pil opencv_chess_sift
  cargo run --release -- pil path/to/my_recording --machine mps2-an500
  cargo run --release --features logs -- pil aloe_sift    # with the controller's own log"
)]
pub(super) struct PilArgs {
    /// Folder of a data set, or the name of one that comes with the project.
    #[arg(value_name = "DATASET", default_value = "opencv_chess_sift")]
    set: PathBuf,

    /// Board that QEMU emulates.
    #[arg(long, value_enum, default_value_t)]
    pub(super) machine: Machine,

    /// Image to run in place of the one that would be built.
    #[arg(long, value_name = "FILE")]
    pub(super) image: Option<PathBuf>,

    /// Longest wait for an answer, s.
    #[arg(long, value_name = "S", default_value = "60", value_parser = seconds)]
    pub(super) timeout: Duration,
}

impl PilArgs {
    /// Reads the data set.
    pub(super) fn dataset(&self) -> Result<Dataset> {
        Dataset::find(&self.set)
    }
}

/// Run a controller image in QEMU and print its log. Cargo calls this for `run`.
#[cfg(feature = "logs")]
#[derive(Debug, Args)]
#[command(after_help = "Exit status: that of the firmware, or 1 if it does not end in time.")]
pub(super) struct EmulateArgs {
    /// Image, as built.
    pub(super) image: PathBuf,

    /// Board that QEMU emulates.
    #[arg(long, value_enum, default_value_t)]
    pub(super) machine: Machine,

    /// Longest run, s.
    #[arg(long, value_name = "S", default_value = "300", value_parser = seconds)]
    pub(super) timeout: Duration,
}

fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse().ok().filter(|s| (1..=86_400).contains(s));
    seconds.map(Duration::from_secs).ok_or_else(|| "1 to 86400 whole seconds are needed".into())
}

fn knock(text: &str) -> Result<f64, String> {
    let degrees = text.parse().ok().filter(|d: &f64| d.abs() <= 10.0);
    degrees.ok_or_else(|| "a turn from -10 to 10 degrees is needed".into())
}

fn length(text: &str) -> Result<f32, String> {
    let metres = text.parse().ok().filter(|m: &f32| *m > 0.0 && m.is_finite());
    metres.ok_or_else(|| "a length above 0 m is needed".into())
}
