//! The command line.

use std::path::PathBuf;

use anyhow::Result;
use host_tests::dataset::Dataset;

/// Run the controller's firmware on this computer, with a recorded data set in place of the
/// matcher.
///
/// Each stereo pair of the data set becomes a frame of fixed-point correspondences (1/256 px) on a
/// simulated SPI bus with a data-ready line. The firmware's own loop reads it, solves the pair for R
/// and t (p_r = R p_l + t, |t| = 1) starting at R = I, t = (-1, 0, 0), and fuses it with the pairs
/// before. Arithmetic and code are those of the controller: f32, 512 correspondences a pair,
/// selected from longer frames for their spread over the image and their score.
#[derive(Debug, clap::Parser)]
#[command(
    version,
    after_help = "Columns:
  matches              correspondences taken into the batch
  rows px before>after RMS row offset of the pair's screened matches, at the start and solved
  passes               passes over the batch until the solver stopped
  pair e_t, e_theta    error of this pair alone, baseline direction and rotation
  running              the same of all pairs fused so far
  verdict              fused, refused by the gate, or not solved, and why

Exit status: 0 if there is an estimate at the end, 1 if not.

Examples:
  cargo run --release
  cargo run --release -- opencv_chess_corners
  cargo run --release -- path/to/my_recording --plot my_recording.svg"
)]
pub(crate) struct Args {
    /// Folder of a data set (meta.json, pairs/*.csv), or the name of one that comes with the
    /// project: opencv_chess_corners, opencv_chess_sift, motorcycle_sift, aloe_sift.
    #[arg(value_name = "DATASET", default_value = "opencv_chess_sift")]
    set: PathBuf,

    /// Where the plot goes (SVG); folders are created [default: target/firmware-sim/<DATASET>.svg].
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

impl Args {
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
