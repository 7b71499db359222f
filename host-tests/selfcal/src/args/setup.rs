//! Settings of the calibrator, common to every subcommand that runs it.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, ValueEnum};
use nalgebra::Vector3;
use rigs::data::{Meta, Rows, WrongSign, matrix};
use rigs::formats;
use serde::Deserialize;
use sim::run::{Apply, Capacity, Feed, LensTracking, Method, RunLog, Start, Step, replay_pairs};
use stereo_selfcal::paper::{Central, Settings};
use stereo_selfcal::{Extrinsics, Scalar};

use super::parse::choice;

/// Settings of the calibrator.
#[derive(Debug, Args)]
pub(crate) struct Setup {
    /// Method. The published one has no verdict and applies nothing, and takes neither ranges nor tracks.
    #[arg(long, value_enum, default_value_t = Preset::Robust)]
    preset: Preset,

    /// Number type of the core; firmware uses f32.
    #[arg(long, value_enum, default_value_t = Number::F32)]
    scalar: Number,

    /// Capacity of the calibrator in correspondences a pair; it selects from longer pairs. The firmware examples have
    /// 256: a recorded stream gives the same bits as on a vehicle with the same capacity, in f32.
    #[arg(long, value_parser = choice::<Capacity>(), default_value_t = Capacity::N2048, value_name = "N")]
    capacity: Capacity,

    /// Trust in the lens models of the data; robust only.
    #[arg(long, value_parser = choice::<LensTracking>(), default_value_t = LensTracking::Report)]
    lens: LensTracking,

    /// Central tendency of the pairs' rotation angles in fusion; paper only.
    #[arg(long, value_enum, default_value_t = Angle::Mean)]
    angle: Angle,

    /// Start of the first pairs, and with `--preset paper` of every pair. `guess`: R = I, t = (-1, 0, 0), whose yaw is
    /// not known. Anything else is a calibration, whose yaw is kept until the mount turns: `rig`: R and t of the
    /// recording's rig; a JSON file with "R" (3 rows) and "t" (3 numbers, any length), such as a meta.json; OpenCV's
    /// extrinsics.yml; files or folder of any format that `selfcal import` reads. Only R and t are read; R and t of
    /// --lens compensate do not fit, because they belong to corrected cameras [default: rig, if it was read from a rig
    /// file; otherwise guess, because R and t of a data set are the reference].
    #[arg(long, value_name = "guess|rig|FILE|DIR")]
    initial: Option<PathBuf>,

    /// Largest row offset in use at which the rig may arm, px; robust only.
    #[arg(long, default_value_t = 1.0, value_name = "PX")]
    rows_limit: f32,

    /// Largest expected error of disparity at which the rig may arm, px; `inf` for a rig that uses rows and no depth;
    /// robust only.
    #[arg(long, default_value_t = 2.0, value_name = "PX")]
    depth_limit: f32,
}

/// Method.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Preset {
    /// Whitened residuals, redescending loss, fusion by moments, change detection: survives outliers.
    Robust,
    /// As published: Huber weights, mean-direction fusion (eqs 16-22).
    Paper,
}

/// Number type of the core.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Number {
    /// Single precision.
    F32,
    /// Double precision.
    F64,
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
    pub(crate) fn replay(
        &self,
        feed: Feed<'_>,
        apply: Apply,
        each: impl FnMut(&Step),
    ) -> Result<RunLog> {
        let (method, rig, capacity) = (self.method()?, feed.rig.clone(), self.capacity);
        let usual = Path::new(if rig.is_calibrated() { "rig" } else { "guess" });
        let initial = self.initial.as_deref().unwrap_or(usual);
        eprintln!("{}", said(initial, &rig));
        match self.scalar {
            Number::F32 => {
                replay_pairs(feed, method, start::<f32>(initial, &rig)?, capacity, apply, each)
            }
            Number::F64 => {
                replay_pairs(feed, method, start::<f64>(initial, &rig)?, capacity, apply, each)
            }
        }
    }

    fn method(&self) -> Result<Method> {
        let angle = match self.angle {
            Angle::Mean => Central::Mean,
            Angle::Median => Central::Median,
        };
        Ok(match self.preset {
            Preset::Robust => {
                let config = self.lens.config().with_depth_limit_px(self.depth_limit)?;
                config.with_rows_limit_px(self.rows_limit)?.into()
            }
            Preset::Paper => Settings::DEFAULT.with_angle(angle).into(),
        })
    }
}

/// The rule of the start, in words.
fn said(initial: &Path, rig: &Meta) -> String {
    let reference = if rig.has_reference() && !rig.is_calibrated() {
        "; R and t of the data set are the reference"
    } else {
        ""
    };
    match initial.to_str() {
        Some("guess") => format!("start: a guess, R = I, t = (-1, 0, 0){reference}"),
        Some("rig") => "start: R and t of the rig, a calibration".into(),
        _ => format!("start: R and t of {}, a calibration{reference}", initial.display()),
    }
}

fn start<T: Scalar>(initial: &Path, rig: &Meta) -> Result<Start<T>> {
    if initial == Path::new("guess") {
        return Ok(Start::Guess);
    }
    if initial == Path::new("rig") {
        return Ok(Start::Calibration(rig.extrinsics()?));
    }
    let read = || -> Result<Extrinsics<T>> {
        let (r, t) = if let Some(initial) = plain(initial) {
            WrongSign::check(&initial.r, initial.t)?;
            (matrix(&initial.r), Vector3::from(initial.t))
        } else {
            let extrinsics = formats::import_extrinsics(initial)?;
            (*extrinsics.rotation().matrix(), extrinsics.translation().into_inner())
        };
        Ok(Extrinsics::try_new(&r.map(T::lit), &t.map(T::lit))?)
    };
    read()
        .map(Start::Calibration)
        .with_context(|| format!("initial extrinsics from {}", initial.display()))
}

/// `R` and `t` of a JSON file; `None` for a folder or any other file.
fn plain(place: &Path) -> Option<Initial> {
    serde_json::from_str(&fs::read_to_string(place).ok()?).ok()
}

/// Required content of a file of initial extrinsics; the rest is ignored.
#[derive(Deserialize)]
struct Initial {
    #[serde(rename = "R")]
    r: Rows,
    t: [f64; 3],
}
