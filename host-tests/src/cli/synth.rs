//! `selfcal synth`.

use std::io::{self, Write};
use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Result;
use clap::Args;
use host_tests::depth::Depth;
use host_tests::synth::{Scene, rig};

use super::run::RunArgs;

/// Generate scenes of a known rig and feed them to the calibrator, or write them as a data set.
///
/// Pinhole cameras, points uniform in the image and log-uniform in depth, Gaussian noise on all four
/// coordinates. Half of the mismatches are uniform in the right image, half within 60 px (u) and 20
/// px (v) of the truth. The same seed gives the same scenes.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal synth --pairs 100 --rotation 5,0,0
  selfcal synth --outliers 0.3 --depth 30,800 --band 0.2
  selfcal synth --pairs 20 --seed 7 --out my_scene && selfcal replay my_scene")]
pub(crate) struct SynthArgs {
    /// Stereo pairs to generate.
    #[arg(long, default_value_t = 100)]
    pairs: usize,

    /// Correspondences a pair.
    #[arg(long, default_value_t = 256, value_name = "N")]
    matches: usize,

    /// Standard deviation of each coordinate, px.
    #[arg(long, default_value_t = 0.3, value_name = "PX")]
    noise: f64,

    /// Share of gross mismatches, 0 to 1.
    #[arg(long, default_value_t = 0.0, value_name = "SHARE")]
    outliers: f64,

    /// Nearest and farthest depth, in baselines.
    #[arg(long, value_parser = numbers::<f64, 2>, default_value = "3,80", value_name = "NEAR,FAR")]
    depth: [f64; 2],

    /// Height of the centred band that points come from, in image heights.
    #[arg(long, default_value_t = 1.0, value_name = "SHARE")]
    band: f64,

    /// True R as a rotation vector, degrees.
    #[arg(long, value_parser = numbers::<f64, 3>, default_value = "0,0,0", value_name = "X,Y,Z",
          allow_hyphen_values = true)]
    rotation: [f64; 3],

    /// Turn of the true t about y and z away from (-1, 0, 0), degrees.
    #[arg(long, value_parser = numbers::<f64, 2>, default_value = "0,0", value_name = "Y,Z",
          allow_hyphen_values = true)]
    baseline: [f64; 2],

    /// Focal length, px.
    #[arg(long, default_value_t = 1400.0, value_name = "PX")]
    focal: f64,

    /// Image width and height, px.
    #[arg(long, value_parser = numbers::<u16, 2>, default_value = "1920,1200", value_name = "W,H")]
    size: [u16; 2],

    /// Seed of the generator.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Write a data set into this new folder instead of running the calibrator.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,

    #[command(flatten)]
    run: RunArgs,
}

/// Runs `selfcal synth`.
pub(crate) fn synth(args: &SynthArgs) -> Result<()> {
    let scene = Scene {
        size: args.size,
        focal: args.focal,
        rig: rig(args.rotation, args.baseline)?,
        noise_px: args.noise,
        outliers: args.outliers,
        depth: Depth::LogUniform(args.depth),
        band: args.band,
        matches: args.matches,
        ..Scene::default()
    };
    let set = scene.dataset(args.pairs, args.seed)?;
    match &args.out {
        Some(dir) => {
            set.save(dir)?;
            writeln!(io::stdout(), "{} pairs written to {}", set.pairs.len(), dir.display())?;
            Ok(())
        }
        None => args.run.run(&set),
    }
}

/// `N` numbers with commas between.
fn numbers<T: FromStr, const N: usize>(text: &str) -> Result<[T; N], String> {
    let numbers: Vec<T> = text
        .split(',')
        .map(|number| number.trim().parse().map_err(|_| format!("`{number}` is not a number here")))
        .collect::<Result<_, _>>()?;
    numbers.try_into().map_err(|_| format!("{N} numbers with commas between are needed"))
}
