//! `evidence campaign`.

mod fused;
mod real;
mod real_cases;
mod single;
mod stats;
mod steps;
mod tables;

use std::io::{self, Write};
use std::ops::Range;
use std::path::PathBuf;

use anyhow::{Result, ensure};
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use sim::run::monte_carlo::{Run, long_run, runs};
use sim::run::{LensTracking, progress};
use sim::stats::{rms, rms_deviation};
use sim::synth::{Grid, Scenario, ScenarioKind, five_degrees_off, rig};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Config, Extrinsics, Scalar};
use strum::VariantArray;

pub(crate) use tables::{TablesArgs, tables};

/// Run the robust preset over many generated scenes, against the best that their data allow.
///
/// Every row is one scene; its runs have seeds of their own, 5 degrees off about all axes and t 5
/// degrees off by default. The meaning of the columns is printed above them. Errors in rad; in real in mrad.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence campaign single --only n256 noise
  evidence campaign fused --trials 1000 --pairs 20
  evidence campaign steps --seed 7 --vibration 0.02
  evidence campaign real --only altitude lens/f_r --csv real.csv
  evidence campaign real --only lens --lens compensate")]
pub struct CampaignArgs {
    /// The measurement.
    #[arg(value_enum)]
    what: What,

    /// Runs of each scene [default: 200, real 24].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    trials: Option<u32>,

    /// Pairs of each run; default 1 (single), 100 (fused, garbage, grids), 200 (steps), 1000 (numbers), a million
    /// (long); for real the number of the case.
    #[arg(long)]
    pairs: Option<usize>,

    /// Seed of the first run.
    #[arg(long, default_value_t = 1_000_000)]
    seed: u64,

    /// Trust in the lens models, real. With compensate the errors of R and t refer to the corrected cameras.
    #[arg(long, value_parser = lens_tracking(), default_value_t = LensTracking::Report)]
    lens: LensTracking,

    /// Vibration of the rig, degrees RMS about each axis, new with every pair; steps.
    #[arg(long, default_value_t = 0.0, value_name = "D")]
    vibration: f64,

    /// Cases of single and real whose group/name starts with this; default all.
    #[arg(long, value_name = "PREFIX", num_args = 1..)]
    only: Vec<String>,

    /// Write all figures of real into this file, one row for each case; angles in rad.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// One pair, against the Cramer-Rao bound of its true matches.
    Single,
    /// Pairs fused, against the joint fit of the true matches of all pairs.
    Fused,
    /// A rig that turns once, or a little with every pair, or does not turn.
    Steps,
    /// Outliers only.
    Garbage,
    /// Coordinates rounded to a grid, or to the grids of a pyramid's levels.
    Grids,
    /// Scenes of real rigs, applied after every pair: altitude, and other situations of a vehicle.
    Real,
    /// f32 against f64.
    Numbers,
    /// One run of a million pairs, f32.
    Long,
}

fn lens_tracking() -> impl TypedValueParser<Value = LensTracking> {
    let names = LensTracking::VARIANTS.iter().map(ToString::to_string);
    PossibleValuesParser::new(names).try_map(|name| name.parse())
}

/// Runs `evidence campaign`.
pub(crate) fn campaign(args: &CampaignArgs) -> Result<()> {
    let has_names = matches!(args.what, What::Real | What::Single);
    ensure!(has_names || args.only.is_empty(), "--only is an option of single and real");
    ensure!(args.what == What::Real || args.csv.is_none(), "--csv is an option of real");
    let shaken = args.vibration != 0.0;
    ensure!(!shaken || args.what == What::Steps, "--vibration is an option of steps");
    match args.what {
        What::Real => args.real(),
        What::Single => args.single(),
        What::Fused => args.fused(),
        What::Steps => args.steps(),
        What::Garbage => args.garbage(),
        What::Grids => args.grids(),
        What::Numbers => args.numbers(),
        What::Long => args.long(),
    }
}

impl CampaignArgs {
    fn scenario(&self, kind: ScenarioKind, outliers: f64, pairs: usize) -> Scenario {
        let mut scenario = Scenario::new(kind, self.pairs.unwrap_or(pairs));
        scenario.scene.outliers = outliers;
        scenario.scene.rig = five_degrees_off();
        scenario.disturbance.vibration_deg = self.vibration;
        scenario
    }

    /// Whether a case is selected.
    fn takes(&self, name: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|prefix| name.starts_with(prefix))
    }

    fn trials(&self) -> u32 {
        self.trials.unwrap_or(if self.what == What::Real { 24 } else { 200 })
    }

    /// Seeds of the runs of a scene.
    fn seeds(&self) -> Range<u64> {
        self.seed..self.seed + u64::from(self.trials())
    }

    fn runs<T: Scalar>(&self, scenario: &Scenario) -> Result<Vec<Run>> {
        let bar = progress::over(usize::try_from(self.trials())?, "runs");
        let config = Config::default();
        let seeds = self.seeds();
        let runs = runs::<T>(scenario, config, seeds, || bar.inc(1))?;
        bar.finish_and_clear();
        Ok(runs)
    }

    fn garbage(&self) -> Result<()> {
        let mut out = io::stdout();
        for matches in GARBAGE {
            let [locked, runs] = self.garbage_locks(matches)?;
            writeln!(out, "{matches} matches, all wrong: {locked} of {runs} runs locked")?;
        }
        Ok(())
    }

    /// Runs that lock on so many wrong matches a pair, and all runs.
    fn garbage_locks(&self, matches: usize) -> Result<[usize; 2]> {
        let mut scenario = self.scenario(ScenarioKind::Near, 1.0, 100);
        scenario.scene.matches = matches;
        let runs = self.runs::<f32>(&scenario)?;
        Ok([locked(&runs), runs.len()])
    }

    fn grids(&self) -> Result<()> {
        let mut out = io::stdout();
        writeln!(
            out,
            "e: RMS error over the bound for the variance of noise and rounding together"
        )?;
        writeln!(out, "noise  grid        rig off by         e_t  e_theta  locked")?;
        let rigs = rigs_on_grids()?;
        for noise in [0.1, 0.3] {
            for (name, grid, effective) in grids(noise) {
                for (off, rig) in &rigs {
                    let (e, locked) = self.on_grid((noise, grid, effective), rig)?;
                    writeln!(
                        out,
                        "{noise:>5}  {name:<10}  {off:<14}  {:>6.2}  {:>7.2}  {locked:>6}",
                        e[0], e[1],
                    )?;
                }
            }
        }
        Ok(())
    }

    /// Error of `t` and `R` over the bound, and the number of runs that have locked.
    ///
    /// * `effective`: standard deviation of noise and rounding together, px.
    fn on_grid(
        &self,
        (noise, grid, effective): (f64, Grid, f64),
        rig: &Extrinsics<f64>,
    ) -> Result<([f64; 2], usize)> {
        let mut scenario = self.scenario(ScenarioKind::Near, 0.1, 100);
        (scenario.scene.noise_px, scenario.scene.grid) = (noise, grid);
        scenario.scene.rig = *rig;
        let runs = self.runs::<f32>(&scenario)?;
        let e = rms_deviation(runs.iter().filter_map(Run::last).map(|m| m.error));
        let single = rms_deviation(runs.iter().map(|run| run.bound));
        let pairs = f64::from(u32::try_from(scenario.pairs)?).sqrt();
        let scale = effective / noise / pairs;
        let e = [e.translation / single.translation, e.rotation / single.rotation];
        Ok((e.map(|e| e / scale), locked(&runs)))
    }

    fn numbers(&self) -> Result<()> {
        let mut out = io::stdout();
        writeln!(out, "f32 against f64: RMS and largest difference over the bound of all pairs")?;
        for kind in [
            ScenarioKind::Near,
            ScenarioKind::Far,
            ScenarioKind::VeryFar,
            ScenarioKind::Heterogeneous,
        ] {
            let scenario = self.scenario(kind, 0.3, 1000);
            let [single, double] = [self.runs::<f32>(&scenario)?, self.runs::<f64>(&scenario)?];
            let pairs = f64::from(u32::try_from(scenario.pairs)?).sqrt();
            let differences = single.iter().zip(&double).filter_map(|(a, b)| {
                let apart = Deviation::between(&a.last()?.found, &b.last()?.found);
                Some([apart.translation / b.bound.translation, apart.rotation / b.bound.rotation])
            });
            let differences: Vec<[f64; 2]> = differences.collect();
            let of = |part: usize| {
                let all = || differences.iter().map(|d| d[part] * pairs);
                let [rms, most] = [rms(all()).unwrap_or(f64::NAN), all().fold(0.0, f64::max)];
                format!("{rms:.4}, {most:.4}")
            };
            writeln!(out, "{:<16} t {}  R {}", kind.to_string(), of(0), of(1))?;
        }
        Ok(())
    }

    fn long(&self) -> Result<()> {
        let mut out = io::stdout();
        let scenario = self.scenario(ScenarioKind::Near, 0.3, 1_000_000);
        let bar = progress::over(scenario.pairs, "pairs");
        let kept = long_run::<f32>(&scenario, Config::default(), self.seed, || bar.inc(1))?;
        bar.finish_and_clear();
        writeln!(out, "pairs     error of t, R       worst over reported sd        state")?;
        for (pairs, m) in kept {
            let Deviation { translation, rotation } = m.error;
            let worst = m.error_in_sd;
            writeln!(
                out,
                "{pairs:>8}  {translation:.2e} {rotation:.2e}   {worst:.2}  {}",
                m.state
            )?;
        }
        Ok(())
    }
}

/// Numbers of wrong matches a pair.
const GARBAGE: [usize; 4] = [256, 64, 30, 20];

/// Number of runs that have locked.
fn locked(runs: &[Run]) -> usize {
    runs.iter().filter(|run| run.locked_at().is_some()).count()
}

/// Rigs whose matches are rounded, and how far each is off.
fn rigs_on_grids() -> Result<[(&'static str, Extrinsics<f64>); 3]> {
    Ok([
        ("0.02 degrees", rig([0.02, 0.01, 0.0], [0.02, 0.02])?),
        ("0.1 degrees", rig([0.1, 0.1, 0.1], [0.1, 0.1])?),
        ("5 degrees", five_degrees_off()),
    ])
}

/// Name, grid, and standard deviation of noise and rounding together, px.
fn grids(noise: f64) -> Vec<(String, Grid, f64)> {
    let with = |q: f64| noise * noise + q * q / 12.0;
    let mut all: Vec<_> =
        [1.0, 0.5, 0.25].map(|q| (format!("{q} px"), Grid::Pixels(q), with(q).sqrt())).to_vec();
    let inverse = (0..8).map(|level| 1.0 / with(1.2_f64.powi(level))).sum::<f64>() / 8.0;
    all.push(("pyramid".into(), Grid::Pyramid, inverse.sqrt().recip()));
    all
}

fn share(part: usize, whole: usize) -> f64 {
    let number = |n: usize| f64::from(u32::try_from(n).unwrap_or(u32::MAX));
    number(part) / number(whole.max(1))
}
