//! `evidence campaign steps`.

use std::io::{self, Write};

use anyhow::Result;
use sim::run::monte_carlo::Run;
use sim::stats::quantile;
use sim::synth::ScenarioKind;

use super::CampaignArgs;
use super::stats::{after, alarms, changes, found_after};

/// Turns of the rig, degrees.
pub(super) const STEPS: [f64; 7] = [5.0, 0.5, 0.3, 0.1, 0.05, 0.02, 0.01];

/// Numbers of pairs from a step to the first change of the estimate, of the runs that have one.
pub(super) struct Found {
    pub(super) after: Vec<usize>,
}

impl Found {
    pub(super) fn of(runs: &[Run], step: usize) -> Self {
        Self { after: runs.iter().filter_map(|run| found_after(run, step)).collect() }
    }

    /// 0 without any.
    pub(super) fn quantile(&self, share: f64) -> f64 {
        let after = self.after.iter().map(|at| u32::try_from(*at).map_or(f64::NAN, f64::from));
        quantile(after, share).unwrap_or(0.0)
    }

    fn within(&self, pairs: usize) -> usize {
        self.after.iter().filter(|at| **at <= pairs).count()
    }
}

impl CampaignArgs {
    pub(super) fn steps(&self) -> Result<()> {
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
            "step deg  found median, 99 %, last, never; within 3, 4, 15, 60  alarms   n: e_t, e_theta, worst error/sd"
        )?;
        for degrees in STEPS {
            let mut scenario = self.scenario(ScenarioKind::Step, 0.1, 200);
            scenario.turn_deg = degrees;
            let runs = self.runs::<f32>(&scenario)?;
            let step = scenario.pairs.div_ceil(2);
            let found = Found::of(&runs, step);
            let before: usize = runs.iter().map(|run| changes(run, 0..step)).sum();
            write!(
                out,
                "{degrees:>8}  {:>12.1}, {:>4.0}, {:>4.0}, {:>5}; {} {} {} {}  {before:>6} ",
                found.quantile(0.5),
                found.quantile(0.99),
                found.quantile(1.0),
                runs.len() - found.after.len(),
                found.within(3),
                found.within(4),
                found.within(15),
                found.within(60),
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
}
