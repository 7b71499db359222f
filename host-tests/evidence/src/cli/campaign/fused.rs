//! `selfcal campaign fused`.

use std::io::{self, Write};

use anyhow::Result;
use host_tests::run::monte_carlo::{Run, nees_band};
use host_tests::stats::rms_deviation;
use host_tests::synth::{Scenario, ScenarioKind, five_degrees_off};
use stereo_selfcal::State;

use super::CampaignArgs;
use super::stats::{alarms, passes};

impl CampaignArgs {
    pub(super) fn fused(&self) -> Result<()> {
        let mut out = io::stdout();
        let [low, high] = nees_band(usize::try_from(self.trials())?);
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
            let e = rms_deviation(runs.iter().filter_map(Run::last).map(|m| m.error));
            let o = rms_deviation(runs.iter().filter_map(|run| run.joint_fit));
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
                nees / f64::from(self.trials()),
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
}

/// All cases, name and scenario, 100 pairs each.
pub(super) fn scenarios() -> Vec<(String, Scenario)> {
    let scenario = |(kind, outliers, matches): (ScenarioKind, f64, Option<usize>)| {
        let mut scenario = Scenario::new(kind, 100);
        (scenario.scene.outliers, scenario.scene.rig) = (outliers, five_degrees_off());
        scenario.scene.matches = matches.unwrap_or(scenario.scene.matches);
        (format!("{kind}-{outliers}-{}", scenario.scene.matches), scenario)
    };
    fused_cases().into_iter().map(scenario).collect()
}

/// Scenario, share of outliers, and matches a pair if they differ from the scenario's.
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
