//! `selfcal campaign`.

use std::io::{self, Write};

use anyhow::Result;
use clap::{Args, ValueEnum};
use host_tests::run::monte_carlo::{Run, long_run, nees_band, rms, runs};
use host_tests::run::progress;
use host_tests::synth::{Grid, Scenario, ScenarioKind, five_degrees_off, rig};
use stereo_selfcal::metrics::Deviation;
use stereo_selfcal::{Config, Fused, Scalar, State};

/// Run the robust preset over many generated scenes, against the best that their data allow.
///
/// Every row is one scene; its runs have seeds of their own, 5 degrees off about all axes and t 5
/// degrees off by default. The meaning of the columns is printed above them. Errors in rad.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  selfcal campaign single
  selfcal campaign fused --trials 1000 --pairs 20
  selfcal campaign steps --seed 7")]
pub(crate) struct CampaignArgs {
    /// The measurement.
    #[arg(value_enum)]
    what: What,

    /// Runs of each scene.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    trials: u32,

    /// Pairs of each run; default 1 (single), 100 (fused, garbage, grids), 200 (steps), 1000 (numbers), a million (long).
    #[arg(long)]
    pairs: Option<usize>,

    /// Seed of the first run.
    #[arg(long, default_value_t = 1_000_000)]
    seed: u64,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum What {
    /// One pair, against the Cramer-Rao bound of its true matches.
    Single,
    /// Pairs fused, against the joint fit of the true matches of all pairs.
    Fused,
    /// A rig that turns once, or a little with every pair, or not at all.
    Steps,
    /// Nothing but outliers.
    Garbage,
    /// Coordinates rounded to a grid, or to that of a pyramid's levels.
    Grids,
    /// f32 against f64.
    Numbers,
    /// One run of a million pairs, f32.
    Long,
}

/// Runs `selfcal campaign`.
pub(crate) fn campaign(args: &CampaignArgs) -> Result<()> {
    match args.what {
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
        scenario
    }

    fn runs<T: Scalar>(&self, scenario: &Scenario) -> Result<Vec<Run>> {
        let trials = self.trials;
        let bar = progress::over(usize::try_from(trials)?, "runs");
        let config = Config::default().with_automatic_apply(true);
        let seeds = self.seed..self.seed + u64::from(trials);
        let runs = runs::<T>(scenario, config, seeds, || bar.inc(1))?;
        bar.finish_and_clear();
        Ok(runs)
    }

    fn single(&self) -> Result<()> {
        let mut out = io::stdout();
        writeln!(
            out,
            "sigma: RMS error of one pair over the bound, of those within 4 times the bound"
        )?;
        writeln!(out, "matches  wrong  sigma_t  sigma_theta  within 4 bounds  passes mean, most")?;
        let cases = [(256, 0.0), (256, 0.3), (256, 0.5), (256, 0.6), (64, 0.3), (64, 0.5)];
        for (matches, outliers) in cases {
            let mut scenario = self.scenario(ScenarioKind::Near, outliers, 1);
            scenario.scene.matches = matches;
            let runs = self.runs::<f32>(&scenario)?;
            let good = |run: &&Run| {
                run.last().is_some_and(|m| {
                    m.error.translation < 4.0 * run.bound.translation
                        && m.error.rotation < 4.0 * run.bound.rotation
                })
            };
            let good: Vec<&Run> = runs.iter().filter(good).collect();
            let e = rms(good.iter().filter_map(|run| run.last()).map(|m| m.error));
            let b = rms(good.iter().map(|run| run.bound));
            let [mean, most] = passes(&runs, |_| true);
            writeln!(
                out,
                "{matches:>7}  {outliers:>5}  {:>7.3}  {:>11.3}  {:>15.4}  {mean:>6.2}, {most}",
                e.translation / b.translation,
                e.rotation / b.rotation,
                share(good.len(), runs.len()),
            )?;
        }
        Ok(())
    }

    fn fused(&self) -> Result<()> {
        let mut out = io::stdout();
        let [low, high] = nees_band(usize::try_from(self.trials)?);
        writeln!(
            out,
            "e: RMS error over that of the joint fit. nees: mean squared error over the reported"
        )?;
        writeln!(
            out,
            "covariance, 5 if consistent, {low:.2} to {high:.2} with 99 %. false: pairs locked and off by"
        )?;
        writeln!(out, "more than 5 reported sd, and runs so at lock. passes: locked, and before")?;
        writeln!(
            out,
            "scene            wrong matches    e_t  e_theta   nees  locked  by pair  \
             false pairs, locks  watch  passes mean, most"
        )?;
        for (kind, outliers, matches) in fused_cases() {
            let mut scenario = self.scenario(kind, outliers, 100);
            if let Some(matches) = matches {
                scenario.scene.matches = matches;
            }
            let matches = scenario.scene.matches;
            let runs = self.runs::<f32>(&scenario)?;
            let e = rms(runs.iter().filter_map(Run::last).map(|m| m.error));
            let o = rms(runs.iter().filter_map(|run| run.joint_fit));
            let locks: Vec<usize> = runs.iter().filter_map(Run::locked_at).collect();
            let false_lock = |run: &&Run| {
                let at = run.locked_at().and_then(|at| run.pairs[at]);
                at.is_some_and(|m| m.error_in_sd > 5.0)
            };
            let false_pairs: usize = runs.iter().map(|run| run.locked_and_overconfident()[1]).sum();
            let nees: f64 = runs.iter().filter_map(Run::last).map(|m| m.nees).sum();
            let locked = passes(&runs, |state| state == State::Locked);
            let before = passes(&runs, |state| state != State::Locked);
            writeln!(
                out,
                "{:<16} {outliers:>5} {matches:>7}  {:>5.2}  {:>7.2}  {:>5.2}  {:>6}  {:>7}  {:>11}, {:>5}  \
                 {:>5}  {:.2}, {}; {:.2}, {}",
                kind.to_string(),
                e.translation / o.translation,
                e.rotation / o.rotation,
                nees / f64::from(self.trials),
                locks.len(),
                locks.iter().max().map_or(0, |at| at + 1),
                false_pairs,
                runs.iter().filter(false_lock).count(),
                alarms(&runs, 0),
                locked[0],
                locked[1],
                before[0],
                before[1],
            )?;
        }
        Ok(())
    }

    fn steps(&self) -> Result<()> {
        let mut out = io::stdout();
        writeln!(
            out,
            "found: pairs to the first change of estimate; alarms: changes before the step; e_t,"
        )?;
        writeln!(
            out,
            "e_theta in use, RMS, and worst error over reported sd, n pairs from the step on"
        )?;
        writeln!(
            out,
            "step deg  found median, last, never  alarms   n: e_t, e_theta, worst error/sd"
        )?;
        for degrees in [5.0, 0.5, 0.3, 0.1, 0.05, 0.02, 0.01] {
            let mut scenario = self.scenario(ScenarioKind::Step, 0.1, 200);
            scenario.turn_deg = degrees;
            let runs = self.runs::<f32>(&scenario)?;
            let step = scenario.pairs.div_ceil(2);
            let mut found: Vec<usize> =
                runs.iter().filter_map(|run| found_after(run, step)).collect();
            found.sort_unstable();
            let before: usize = runs.iter().map(|run| changes(run, 0..step)).sum();
            write!(
                out,
                "{degrees:>8}  {:>12}, {:>4}, {:>5}  {before:>6} ",
                found.get(found.len() / 2).unwrap_or(&0),
                found.last().unwrap_or(&0),
                runs.len() - found.len(),
            )?;
            for n in [0, 1, 3, 6, 15, 100] {
                if let Some((e, worst)) = after(&runs, step + n) {
                    write!(out, "  {n}: {:.1e}, {:.1e}, {worst:.1}", e.translation, e.rotation)?;
                }
            }
            writeln!(out)?;
        }
        let mut drift = self.scenario(ScenarioKind::Drift, 0.1, 100);
        drift.turn_deg = 0.01;
        let runs = self.runs::<f32>(&drift)?;
        write!(out, "drift of 0.01 degrees a pair")?;
        for n in [9, 24, 49, 74, 99] {
            if let Some((e, worst)) = after(&runs, n + 1) {
                write!(out, "  {}: {:.1e}, {:.1e}, {worst:.1}", n + 1, e.translation, e.rotation)?;
            }
        }
        let calm = self.runs::<f32>(&self.scenario(ScenarioKind::Near, 0.1, 300))?;
        let pairs: usize = calm.iter().map(|run| run.pairs.len()).sum();
        writeln!(
            out,
            "\nno step: {} changes of estimate after lock in {pairs} pairs",
            alarms(&calm, 0)
        )?;
        Ok(())
    }

    fn garbage(&self) -> Result<()> {
        let mut out = io::stdout();
        for matches in [256, 64] {
            let mut scenario = self.scenario(ScenarioKind::Near, 1.0, 100);
            scenario.scene.matches = matches;
            let runs = self.runs::<f32>(&scenario)?;
            let locked = runs.iter().filter(|run| run.locked_at().is_some()).count();
            writeln!(out, "{matches} matches, all wrong: {locked} of {} runs locked", runs.len())?;
        }
        Ok(())
    }

    fn grids(&self) -> Result<()> {
        let mut out = io::stdout();
        writeln!(
            out,
            "e: RMS error over the bound for the variance of noise and rounding together"
        )?;
        writeln!(out, "noise  grid        rig off by         e_t  e_theta  locked")?;
        let rigs = [
            ("0.02 degrees", rig([0.02, 0.01, 0.0], [0.02, 0.02])?),
            ("0.1 degrees", rig([0.1, 0.1, 0.1], [0.1, 0.1])?),
            ("5 degrees", five_degrees_off()),
        ];
        for noise in [0.1, 0.3] {
            for (name, grid, effective) in grids(noise) {
                for (off, rig) in &rigs {
                    let mut scenario = self.scenario(ScenarioKind::Near, 0.1, 100);
                    (scenario.scene.noise_px, scenario.scene.grid) = (noise, grid);
                    scenario.scene.rig = *rig;
                    let runs = self.runs::<f32>(&scenario)?;
                    let e = rms(runs.iter().filter_map(Run::last).map(|m| m.error));
                    let single = rms(runs.iter().map(|run| run.bound));
                    let pairs = f64::from(u32::try_from(scenario.pairs)?).sqrt();
                    let scale = effective / noise / pairs;
                    let locked = runs.iter().filter(|run| run.locked_at().is_some()).count();
                    writeln!(
                        out,
                        "{noise:>5}  {name:<10}  {off:<14}  {:>6.2}  {:>7.2}  {locked:>6}",
                        e.translation / (single.translation * scale),
                        e.rotation / (single.rotation * scale),
                    )?;
                }
            }
        }
        Ok(())
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
                let squares: f64 = all().map(|d| d * d).sum();
                let [rms, most] =
                    [(squares / f64::from(self.trials)).sqrt(), all().fold(0.0, f64::max)];
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

/// Scenario, share of outliers, and matches a pair where they are not the scenario's.
fn fused_cases() -> Vec<(ScenarioKind, f64, Option<usize>)> {
    let mut cases = Vec::new();
    for (kind, outliers) in [
        (ScenarioKind::Near, vec![0.0, 0.1, 0.3, 0.5]),
        (ScenarioKind::Far, vec![0.1, 0.3]),
        (ScenarioKind::VeryFar, vec![0.1, 0.3]),
        (ScenarioKind::Heterogeneous, vec![0.1, 0.5]),
        (ScenarioKind::NarrowBand, vec![0.3]),
        (ScenarioKind::Planar, vec![0.3, 0.5]),
        (ScenarioKind::FrontoParallel, vec![0.3, 0.5]),
    ] {
        cases.extend(outliers.into_iter().map(|o| (kind, o, None)));
    }
    for matches in [54, 64] {
        cases.extend([0.1, 0.3, 0.5].map(|o| (ScenarioKind::Near, o, Some(matches))));
    }
    cases
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

/// Mean and most passes of the pairs that found the calibrator in such a state.
fn passes(runs: &[Run], state: impl Fn(State) -> bool) -> [f64; 2] {
    let mut all = Vec::new();
    for run in runs {
        let mut before = State::Acquiring;
        for after_pair in run.pairs.iter().flatten() {
            // A pair that is rejected takes more, and makes the state suspect.
            if state(before) && state(after_pair.state) {
                all.extend(after_pair.passes.map(f64::from));
            }
            before = after_pair.state;
        }
    }
    let count = f64::from(u32::try_from(all.len()).unwrap_or(u32::MAX));
    [all.iter().sum::<f64>() / count, all.iter().copied().fold(0.0, f64::max)]
}

/// Changes of the estimate by change detection or a challenger.
fn changes(run: &Run, pairs: std::ops::Range<usize>) -> usize {
    let changed = |fused: Option<Fused>| matches!(fused, Some(Fused::Renewed | Fused::TookOver));
    run.pairs[pairs].iter().flatten().filter(|m| changed(m.fused)).count()
}

fn alarms(runs: &[Run], from: usize) -> usize {
    runs.iter().map(|run| changes(run, from..run.pairs.len())).sum()
}

/// Pairs from a step to the first change of the estimate.
fn found_after(run: &Run, step: usize) -> Option<usize> {
    (step..run.pairs.len()).find(|&at| changes(run, at..at + 1) > 0).map(|at| at - step + 1)
}

/// RMS error in use after so many pairs, and the worst error of an estimate over its reported sd.
fn after(runs: &[Run], pairs: usize) -> Option<(Deviation<f64>, f64)> {
    let at: Vec<_> = runs.iter().filter_map(|run| *run.pairs.get(pairs.checked_sub(1)?)?).collect();
    let worst = at.iter().map(|m| m.error_in_sd).fold(0.0, f64::max);
    (!at.is_empty()).then(|| (rms(at.iter().map(|m| m.in_use)), worst))
}
