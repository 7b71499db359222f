//! How the calibrator is run: what every subcommand that runs it asks for.

use std::fs;
use std::path::{Path, PathBuf};

use crate::conventions;
use anyhow::{Context, Result, bail};
use clap::{Args, ValueEnum};
use host_tests::data::{Rows, WrongSign, matrix};
use host_tests::run::{Apply, Feed, RunLog, Step, replay_pairs};
use nalgebra::Vector3;
use serde::Deserialize;
use stereo_selfcal::{Central, Config, Extrinsics, Scalar};

/// How the calibrator is run.
#[derive(Debug, Args)]
pub(crate) struct Setup {
    /// Parameters of the calibrator.
    #[arg(long, value_enum, default_value_t = Preset::Robust)]
    preset: Preset,

    /// Number type that the core computes in; f32 is what ships.
    #[arg(long, value_enum, default_value_t = Number::F32)]
    scalar: Number,

    /// Correspondences a pair that the calibrator has room for; it selects from longer pairs. 256 is that of the
    /// firmware examples: a recorded stream comes to the same bits as on a vehicle with this capacity. In f32.
    #[arg(long, value_enum, default_value_t = Capacity::N2048, value_name = "N")]
    capacity: Capacity,

    /// How far the lens models of the data are trusted, robust preset.
    #[arg(long, value_enum, default_value_t = LensTracking::Report)]
    lens: LensTracking,

    /// Central tendency of the pairs' rotation angles in fusion, paper preset.
    #[arg(long, value_enum, default_value_t = Angle::Mean)]
    angle: Angle,

    /// Where every pair starts: `identity` (R = I, t = (-1, 0, 0)); a JSON file with "R" (3 rows) and
    /// "t" (3 numbers, any length), such as a meta.json; OpenCV's extrinsics.yml, Kalibr's
    /// camchain.yaml, or a folder with left.yaml and right.yaml of ROS. Nothing but R and t is read: those
    /// that --lens compensate has found belong to corrected cameras, not to those of the data.
    #[arg(long, value_name = "identity|FILE|DIR", default_value = "identity")]
    initial: PathBuf,
}

/// Treatment of the lens models.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum LensTracking {
    /// As exact: no deviation covers an error of the lens.
    Given,
    /// As uncertain: its errors are estimated, reported, and widen the deviations; R and t stay those of the
    /// given lens.
    Report,
    /// As uncertain, and corrected: differences of focal length and of k1 are compensated where that halves the
    /// deviation of t; R and t belong to the corrected cameras.
    Compensate,
}

impl LensTracking {
    /// The robust preset with this treatment.
    #[must_use]
    pub fn config(self) -> Config {
        match self {
            Self::Given => Config::robust().without_lens_prior(),
            Self::Report => Config::robust(),
            Self::Compensate => {
                Config::robust().with_lens_tracking(stereo_selfcal::LensTracking::Compensate)
            }
        }
    }
}

/// Parameters of the calibrator.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Preset {
    /// Whitened residuals, redescending loss, fusion by moments, change detection: survives outliers.
    Robust,
    /// As published: Huber weights, mean-direction fusion (eqs 16-22).
    Paper,
}

/// Number type that the core computes in.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Number {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
}

/// The capacity is part of the type, and each one is compiled: two are enough.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Capacity {
    #[value(name = "256")]
    N256,
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

impl Setup {
    /// Runs the calibrator over pairs.
    pub(super) fn replay(
        &self,
        feed: Feed<'_>,
        apply: Apply,
        each: impl FnMut(&Step),
    ) -> Result<RunLog> {
        let config = self.config();
        match (self.scalar, self.capacity) {
            (Number::F32, Capacity::N256) => {
                replay_pairs::<f32, 256>(feed, config, self.start()?, apply, each)
            }
            (Number::F32, Capacity::N2048) => {
                replay_pairs::<f32, 2048>(feed, config, self.start()?, apply, each)
            }
            (Number::F64, Capacity::N2048) => {
                replay_pairs::<f64, 2048>(feed, config, self.start()?, apply, each)
            }
            (Number::F64, Capacity::N256) => {
                bail!("--capacity 256 is for --scalar f32, the number type of a vehicle")
            }
        }
    }

    fn config(&self) -> Config {
        let angle = match self.angle {
            Angle::Mean => Central::Mean,
            Angle::Median => Central::Median,
        };
        match self.preset {
            Preset::Robust => self.lens.config(),
            Preset::Paper => Config::paper().with_angle(angle),
        }
    }

    fn start<T: Scalar>(&self) -> Result<Extrinsics<T>> {
        if self.initial == Path::new("identity") {
            return Ok(Extrinsics::SIDE_BY_SIDE);
        }
        let read = || -> Result<Extrinsics<T>> {
            let (r, t) = if let Some(text) = json(&self.initial)? {
                let initial: Initial = serde_json::from_str(&text)?;
                WrongSign::check(initial.t)?;
                (matrix(&initial.r), Vector3::from(initial.t))
            } else {
                let extrinsics = conventions::import_extrinsics(&self.initial)?;
                (*extrinsics.rotation().matrix(), extrinsics.translation().into_inner())
            };
            Ok(Extrinsics::try_new(&r.map(T::lit), &t.map(T::lit))?)
        };
        read().with_context(|| format!("initial extrinsics from {}", self.initial.display()))
    }
}

/// The text of a JSON file; `None` of a folder or any other file.
fn json(place: &Path) -> Result<Option<String>> {
    if place.is_dir() {
        return Ok(None);
    }
    let text = fs::read_to_string(place)?;
    Ok(text.trim_start().starts_with('{').then_some(text))
}

/// What a file of initial extrinsics must have; the rest of it is ignored.
#[derive(Deserialize)]
struct Initial {
    #[serde(rename = "R")]
    r: Rows,
    t: [f64; 3],
}
