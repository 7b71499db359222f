//! `evidence campaign fused`.

use std::io::{self, Write};

use anyhow::Result;
use sim::run::monte_carlo::{Run, nees_band};
use sim::stats::{mean, rms_deviation};
use sim::synth::ScenarioKind;
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
            let Figures { e, nees, locked, by_pair, beyond, passes } = Figures::of(&runs);
            writeln!(
                out,
                "{:<16} {outliers:>5} {matches:>7}  {:>5.2}  {:>7.2}  {nees:>5.2}  {locked:>6}  {by_pair:>7}  {:>11}, {:>5}  \
                 {:>5}  {:.2}, {}; {:.2}, {}",
                kind.to_string(),
                e[0],
                e[1],
                beyond[1],
                beyond[2],
                alarms(&runs, 0),
                passes[0][0],
                passes[0][1],
                passes[1][0],
                passes[1][1],
            )?;
        }
        Ok(())
    }
}

/// Figures of the runs of a scene.
pub(super) struct Figures {
    /// RMS error of `t` and `R` over that of the joint fit.
    pub(super) e: [f64; 2],
    /// Mean squared error over the reported covariance, 5 if consistent.
    pub(super) nees: f64,
    /// Runs that lock, and the pair by which all of these have locked.
    pub(super) locked: usize,
    pub(super) by_pair: usize,
    /// Numbers of locked pairs, of locked pairs off by more than 5 reported deviations, and of runs off by as much when
    /// they lock.
    pub(super) beyond: [usize; 3],
    /// Mean and largest number of passes of a pair, while locked and while not locked.
    pub(super) passes: [[f64; 2]; 2],
}

impl Figures {
    pub(super) fn of(runs: &[Run]) -> Self {
        let e = rms_deviation(runs.iter().filter_map(Run::last).map(|m| m.error));
        let o = rms_deviation(runs.iter().filter_map(|run| run.joint_fit));
        let locks: Vec<usize> = runs.iter().filter_map(Run::locked_at).collect();
        let false_lock = |run: &&Run| {
            let at = run.locked_at().and_then(|at| run.pairs[at]);
            at.is_some_and(|m| m.error_in_sd > 5.0)
        };
        let pairs = |part: usize| runs.iter().map(|run| run.locked_and_overconfident()[part]).sum();
        let nees: Vec<f64> = runs.iter().filter_map(Run::last).map(|m| m.nees).collect();
        Self {
            e: [e.translation / o.translation, e.rotation / o.rotation],
            nees: mean(nees).unwrap_or(f64::NAN),
            locked: locks.len(),
            by_pair: locks.iter().max().map_or(0, |at| at + 1),
            beyond: [pairs(0), pairs(1), runs.iter().filter(false_lock).count()],
            passes: [
                passes(runs, |state| state == State::Locked),
                passes(runs, |state| state != State::Locked),
            ],
        }
    }
}

/// Name, scenario, shares of outliers, and matches a pair if they differ from the scenario's.
pub(super) type Scenes = (&'static str, ScenarioKind, &'static [f64], Option<usize>);

pub(super) const SCENES: [Scenes; 9] = [
    ("near (3 to 80 baselines)", ScenarioKind::Near, &[0.0, 0.1, 0.3, 0.5], None),
    ("far (30 to 800)", ScenarioKind::Far, &[0.1, 0.3], None),
    ("very far (300 to 3000)", ScenarioKind::VeryFar, &[0.1, 0.3], None),
    (
        "heterogeneous (48 to 512 matches, depth and band new in each pair)",
        ScenarioKind::Heterogeneous,
        &[0.1, 0.5],
        None,
    ),
    ("narrow band", ScenarioKind::NarrowBand, &[0.3], None),
    ("planar", ScenarioKind::Planar, &[0.3, 0.5], None),
    ("fronto-parallel", ScenarioKind::FrontoParallel, &[0.3, 0.5], None),
    ("near, 54 matches a pair", ScenarioKind::Near, &[0.1, 0.3, 0.5], Some(54)),
    ("near, 64 matches a pair", ScenarioKind::Near, &[0.1, 0.3, 0.5], Some(64)),
];

/// Scenario, share of outliers, and matches a pair if they differ from the scenario's.
fn fused_cases() -> Vec<(ScenarioKind, f64, Option<usize>)> {
    let cases = |(_, kind, outliers, matches): &Scenes| {
        let (kind, matches) = (*kind, *matches);
        outliers.iter().map(move |share| (kind, *share, matches))
    };
    SCENES.iter().flat_map(cases).collect()
}
