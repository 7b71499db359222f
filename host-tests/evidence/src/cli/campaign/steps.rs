//! `selfcal campaign steps`.

use std::io::{self, Write};

use anyhow::Result;
use host_tests::stats::quantile;
use host_tests::synth::ScenarioKind;

use super::CampaignArgs;
use super::stats::{after, alarms, changes, found_after};

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
        for degrees in [5.0, 0.5, 0.3, 0.1, 0.05, 0.02, 0.01] {
            let mut scenario = self.scenario(ScenarioKind::Step, 0.1, 200);
            scenario.turn_deg = degrees;
            let runs = self.runs::<f32>(&scenario)?;
            let step = scenario.pairs.div_ceil(2);
            let found: Vec<usize> = runs.iter().filter_map(|run| found_after(run, step)).collect();
            let quantile = |share: f64| {
                let found = found.iter().map(|at| u32::try_from(*at).map_or(f64::NAN, f64::from));
                quantile(found, share).unwrap_or(0.0)
            };
            let within = |pairs: usize| found.iter().filter(|at| **at <= pairs).count();
            let before: usize = runs.iter().map(|run| changes(run, 0..step)).sum();
            write!(
                out,
                "{degrees:>8}  {:>12.1}, {:>4.0}, {:>4.0}, {:>5}; {} {} {} {}  {before:>6} ",
                quantile(0.5),
                quantile(0.99),
                quantile(1.0),
                runs.len() - found.len(),
                within(3),
                within(4),
                within(15),
                within(60),
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
