//! What `replay` and `synth` share: how the calibrator is run and what is shown of it.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use host_tests::dataset::{Dataset, Rows, matrix};
use host_tests::evaluation::{Evaluation, Step};
use host_tests::{progress, replay};
use nalgebra::Vector3;
use serde::Deserialize;
use stereo_selfcal::{Central, Config, Extrinsics, Scalar};

/// How the calibrator is run.
#[derive(Debug, Args)]
pub(crate) struct RunArgs {
    /// Parameters of the calibrator.
    #[arg(long, value_enum, default_value_t = Preset::Robust)]
    preset: Preset,

    /// Number type that the core computes in; f32 is what ships.
    #[arg(long, value_enum, default_value_t = Number::F32)]
    scalar: Number,

    /// Correspondences a pair that the calibrator has room for; of longer pairs it selects. A recorded
    /// stream comes to the same bits as on the vehicle with the capacity of the vehicle.
    #[arg(long, value_enum, default_value_t = Capacity::N2048, value_name = "N")]
    capacity: Capacity,

    /// Central tendency of the pairs' rotation angles in fusion, paper preset.
    #[arg(long, value_enum, default_value_t = Angle::Mean)]
    angle: Angle,

    /// Where every pair starts: `identity` (R = I, t = (-1, 0, 0)), or a JSON file with "R" (3 rows)
    /// and "t" (3 numbers, any length), such as a meta.json.
    #[arg(long, value_name = "identity|FILE", default_value = "identity")]
    initial: PathBuf,

    /// Print one JSON object and nothing else. Angles in rad, R row-major.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum Preset {
    /// Whitened residuals, redescending loss, fusion by moments, watched: survives mismatches.
    Robust,
    /// As published: Huber weights, mean-direction fusion (eqs 16-22).
    Paper,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(super) enum Number {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

/// Capacities are in the type, so there are some.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Capacity {
    #[value(name = "64")]
    N64,
    #[value(name = "128")]
    N128,
    #[value(name = "256")]
    N256,
    #[value(name = "512")]
    N512,
    #[value(name = "1024")]
    N1024,
    #[value(name = "2048")]
    N2048,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Angle {
    /// Arithmetic mean.
    Mean,
    /// Streaming median.
    Median,
}

impl RunArgs {
    /// Runs the calibrator over a data set and prints what came of it.
    pub(super) fn run(&self, set: &Dataset) -> Result<()> {
        let evaluation = match self.scalar {
            Number::F32 => self.replay::<f32>(set),
            Number::F64 => self.replay::<f64>(set),
        }?;
        let summary = evaluation.summary(set)?;
        let mut out = io::stdout();
        if self.json {
            writeln!(out, "{}", serde_json::to_string_pretty(&summary)?)?;
        } else {
            writeln!(out, "\n{summary}")?;
        }
        if evaluation.fused().is_none() {
            bail!("none of the {} pairs could be fused", set.pairs.len());
        }
        Ok(())
    }

    fn replay<T: Scalar>(&self, set: &Dataset) -> Result<Evaluation> {
        let start = self.start::<T>()?;
        let mut out = io::stdout();
        if !self.json {
            writeln!(out, "{} pairs of {}: {}", set.pairs.len(), set.name, set.meta.source)?;
            writeln!(out, "pair {}", Step::HEADING)?;
        }
        let bar = progress::over(set.pairs.len(), "pairs");
        let mut lines = 0..;
        let mut written = Ok(());
        let each = |step: &Step| {
            if let (false, Some(i), Ok(())) = (self.json, lines.next(), &written) {
                written = bar.suspend(|| writeln!(out, "{i:>4} {step}"));
            }
            bar.inc(1);
        };
        let config = self.config();
        let evaluation = match self.capacity {
            Capacity::N64 => replay::replay_within::<T, 64>(set, config, start, each),
            Capacity::N128 => replay::replay_within::<T, 128>(set, config, start, each),
            Capacity::N256 => replay::replay_within::<T, 256>(set, config, start, each),
            Capacity::N512 => replay::replay_within::<T, 512>(set, config, start, each),
            Capacity::N1024 => replay::replay_within::<T, 1024>(set, config, start, each),
            Capacity::N2048 => replay::replay_within::<T, 2048>(set, config, start, each),
        }?;
        bar.finish_and_clear();
        written?;
        Ok(evaluation)
    }

    fn config(&self) -> Config {
        let angle = match self.angle {
            Angle::Mean => Central::Mean,
            Angle::Median => Central::Median,
        };
        match self.preset {
            Preset::Robust => Config::robust(),
            Preset::Paper => Config::paper().with_angle(angle),
        }
    }

    fn start<T: Scalar>(&self) -> Result<Extrinsics<T>> {
        if self.initial == Path::new("identity") {
            return Ok(Extrinsics::SIDE_BY_SIDE);
        }
        let read = || -> Result<Extrinsics<T>> {
            let initial: Initial = serde_json::from_str(&fs::read_to_string(&self.initial)?)?;
            let t = Vector3::from(initial.t).map(T::lit);
            Ok(Extrinsics::try_new(&matrix(&initial.r).map(T::lit), &t)?)
        };
        read().with_context(|| format!("initial extrinsics from {}", self.initial.display()))
    }
}

/// What a file of initial extrinsics must have; the rest of it is ignored.
#[derive(Deserialize)]
struct Initial {
    #[serde(rename = "R")]
    r: Rows,
    t: [f64; 3],
}
