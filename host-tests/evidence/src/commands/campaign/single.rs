//! `evidence campaign single`.

use std::io::{self, Write};

use anyhow::{Result, ensure};
use sim::run::monte_carlo::Run;
use sim::stats::rms_deviation;
use sim::synth::{Fence, Scenario, ScenarioKind, five_degrees_off, rig};

use super::stats::passes;
use super::{CampaignArgs, share};

/// A generated pair, and its name.
struct Case {
    name: String,
    scenario: Scenario,
}

impl Case {
    fn new(matches: usize, outliers: f64) -> Self {
        let mut scenario = Scenario::new(ScenarioKind::Near, 1);
        (scenario.scene.matches, scenario.scene.outliers) = (matches, outliers);
        scenario.scene.rig = five_degrees_off();
        Self { name: format!("n{matches}/outliers-{outliers}"), scenario }
    }

    fn named(mut self, name: impl Into<String>, change: impl FnOnce(&mut Scenario)) -> Self {
        self.name = name.into();
        change(&mut self.scenario);
        self
    }
}

fn cases() -> Result<Vec<Case>> {
    let counts = [
        (256, 0.0),
        (256, 0.3),
        (256, 0.5),
        (256, 0.6),
        (256, 0.7),
        (64, 0.3),
        (64, 0.5),
        (64, 0.6),
        (30, 0.3),
        (30, 0.5),
        (20, 0.2),
        (12, 0.2),
    ];
    let mut cases: Vec<Case> = counts.map(|(n, outliers)| Case::new(n, outliers)).into();
    for (off, outliers) in [(10.0, 0.3), (10.0, 0.7), (20.0, 0.3), (20.0, 0.5)] {
        let name = format!("start/{off}-degrees-outliers-{outliers}");
        cases.push(Case::new(256, outliers).named(name, |s| {
            s.scene.rig = stereo_selfcal::Extrinsics::SIDE_BY_SIDE;
            s.off_deg = off;
        }));
    }
    let pitched = rig([20.0, 0.0, 0.0], [0.0, 0.0])?;
    let name = "start/pitch-20-outliers-0.4";
    cases.push(Case::new(256, 0.4).named(name, |s| s.scene.rig = pitched));
    for (noise, outliers) in [1.0, 2.0, 4.0].into_iter().flat_map(|n| [(n, 0.0), (n, 0.3)]) {
        let name = format!("noise/{noise}-px-outliers-{outliers}");
        cases.push(Case::new(256, outliers).named(name, |s| s.scene.noise_px = noise));
    }
    for share in [0.2, 0.3, 0.4] {
        for (across_px, local) in [(1.5, false), (3.0, false), (8.0, false), (8.0, true)] {
            let place = if local { "-local" } else { "" };
            let name = format!("fence/{share}-{across_px}-px{place}");
            let fence = Fence { share, across_px, local };
            cases.push(Case::new(256, 0.1).named(name, |s| s.scene.fence = Some(fence)));
        }
    }
    Ok(cases)
}

/// All cases, name and scenario.
pub(super) fn scenarios() -> Result<Vec<(String, Scenario)>> {
    Ok(cases()?.into_iter().map(|Case { name, scenario }| (name, scenario)).collect())
}

/// Figures of the runs of a case.
pub(super) struct Figures {
    /// RMS error of `t` and `R` over the bound, of the pairs within 4 times the bound.
    pub(super) sigma: [f64; 2],
    /// Share of pairs within 4 times the bound, beyond, and without an answer.
    pub(super) within: f64,
    pub(super) wrong: f64,
    pub(super) none: f64,
    /// Mean and most.
    pub(super) passes: [f64; 2],
}

impl Figures {
    pub(super) fn of(runs: &[Run]) -> Self {
        let within = |run: &&Run| {
            run.last().is_some_and(|m| {
                m.error.translation < 4.0 * run.bound.translation
                    && m.error.rotation < 4.0 * run.bound.rotation
            })
        };
        let good: Vec<&Run> = runs.iter().filter(within).collect();
        let none = runs.iter().filter(|run| run.last().is_none()).count();
        let e = rms_deviation(good.iter().filter_map(|run| run.last()).map(|m| m.error));
        let b = rms_deviation(good.iter().map(|run| run.bound));
        Self {
            sigma: [e.translation / b.translation, e.rotation / b.rotation],
            within: share(good.len(), runs.len()),
            wrong: share(runs.len() - good.len() - none, runs.len()),
            none: share(none, runs.len()),
            passes: passes(runs, |_| true),
        }
    }
}

impl CampaignArgs {
    pub(super) fn single(&self) -> Result<()> {
        let mut out = io::stdout();
        writeln!(
            out,
            "sigma: RMS error of one pair over the bound, of those within 4 times the bound. Wrong: an answer beyond."
        )?;
        writeln!(
            out,
            "{:<32}  sigma_t  sigma_theta  within  wrong   none    passes mean, most",
            "pair"
        )?;
        let mut cases = cases()?;
        cases.retain(|case| self.takes(&case.name));
        ensure!(!cases.is_empty(), "no case begins with {}", self.only.join(" or "));
        for Case { name, scenario } in cases {
            let runs = self.runs::<f32>(&scenario)?;
            let Figures { sigma, within, wrong, none, passes: [mean, most] } = Figures::of(&runs);
            writeln!(
                out,
                "{name:<32}  {:>7.3}  {:>11.3}  {within:>6.4}  {wrong:>6.4}  {none:>6.4}  {mean:>6.2}, {most}",
                sigma[0], sigma[1],
            )?;
        }
        Ok(())
    }
}
