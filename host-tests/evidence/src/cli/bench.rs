//! `selfcal bench`.

use std::io::{self, Write};
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::Args;
use host_tests::data::PairFile;
use host_tests::run::progress;
use host_tests::run::single_pairs::{self, SinglePairStats};
use stereo_selfcal::{Config, Scalar};

use selfcal_commands::setup::{Number, Preset};

/// Solve each pair of a file alone; print the time and the error.
///
/// The file is little endian: u32 pairs, u32 correspondences a pair n; then for each pair n times
/// x_l y_l x_r y_r, R row by row, t, all f64. Rays are at unit depth, undistorted; p_r = R p_l + t.
/// `selfcal synth --rays FILE` writes one.
///
/// Every pair is solved alone, from R = I, t = (-1, 0, 0), by a fresh calibrator. The clock covers solve_pair, all
/// passes and the evaluation; pushing the matches into the batch is timed separately. One untimed round over the file
/// comes first.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal synth --pairs 1000 --outliers 0.3 --rotation 5,5,5 --baseline 3,4 --rays near.pairs
  selfcal bench near.pairs
  selfcal bench near.pairs --preset paper --scalar f64 --json")]
pub struct BenchArgs {
    /// File of pairs.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Parameters of the calibrator.
    #[arg(long, value_enum, default_value_t = Preset::Robust)]
    preset: Preset,

    /// Number type of the core; firmware uses f32.
    #[arg(long, value_enum, default_value_t = Number::F32)]
    scalar: Number,

    /// Focal length of the calibrator's camera, px: the file has rays only.
    #[arg(long, default_value_t = 1400.0, value_name = "PX")]
    focal: f64,

    /// Timed rounds over the file.
    #[arg(long, default_value_t = 3, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,

    /// Print only one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs `selfcal bench`.
pub(crate) fn bench(args: &BenchArgs) -> Result<()> {
    let file = PairFile::load(&args.file)?;
    let outcome = match args.scalar {
        Number::F32 => args.run::<f32>(&file),
        Number::F64 => args.run::<f64>(&file),
    }?;
    let mut out = io::stdout();
    if args.json {
        writeln!(out, "{}", serde_json::to_string_pretty(&outcome)?)?;
    } else {
        writeln!(out, "{outcome}")?;
    }
    Ok(())
}

impl BenchArgs {
    fn run<T: Scalar>(&self, file: &PairFile) -> Result<SinglePairStats> {
        match file.matches() {
            0..=256 => self.run_within::<T, 256>(file),
            257..=2048 => self.run_within::<T, 2048>(file),
            n => bail!("pairs of {n} correspondences: there is room for 2048"),
        }
    }

    fn run_within<T: Scalar, const N: usize>(&self, file: &PairFile) -> Result<SinglePairStats> {
        let config = match self.preset {
            Preset::Robust => Config::robust(),
            Preset::Paper => Config::paper(),
        };
        let rounds = usize::try_from(self.rounds)? + 1;
        let bar = progress::over(file.pairs.len() * rounds, "pairs");
        let outcome =
            single_pairs::run::<T, N>(file, config, self.focal, self.rounds, || bar.inc(1))?;
        bar.finish_and_clear();
        Ok(outcome)
    }
}
