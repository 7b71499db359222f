//! Campaigns: one table each, of figures of many runs of generated scenes, or of recorded data.
//!
//! A campaign is an entry of [`all`]. `cargo evidence campaign NAME` measures it with any number of runs and prints it.
//! `cargo evidence tables NAME` measures it as the committed table says, and writes or compares the table.

mod alarms;
mod chance;
mod figures;
mod images;
mod made;
mod real;
mod recorded;
mod recording;
mod table;

use std::path::PathBuf;

use anyhow::{Context, Result, ensure};
use sim::run::{LensTracking, monte_carlo, progress};
use sim::synth::Scenario;

pub(crate) use alarms::NAMES as ALARMS;
pub(crate) use chance::Chance;
pub(crate) use figures::Figure;
pub(crate) use images::means;
pub(crate) use table::{Compared, Table};

/// A table, and its measurement.
pub(crate) struct Campaign {
    pub(crate) name: &'static str,
    /// Runs of each case and first seed, of the committed table.
    trials: u32,
    /// First seeds; each has so many runs.
    seeds: &'static [u64],
    lens: LensTracking,
    /// The figures of the table, with commas between. A campaign may measure more, for `--csv`.
    columns: &'static str,
    /// Begin of the names of the cases that take seconds; `None`: all take longer.
    quick: Option<&'static str>,
    /// The figure by which the cases are sorted, largest first; `None`: they keep their order.
    worst_first: Option<&'static str>,
    measure: Measure,
    /// Picture of the rows, beside the table.
    pub(crate) chart: Option<fn(&[Row]) -> String>,
}

#[derive(Clone, Copy)]
enum Measure {
    /// Figures of the runs of each case.
    Runs(fn() -> Result<Vec<Case>>),
    Rows(fn(&Request) -> Result<Vec<Row>>),
}

/// Scenes whose runs are counted together.
#[derive(Debug, Clone)]
struct Case {
    name: String,
    scenarios: Vec<Scenario>,
    /// Numbers of pairs after which figures are also taken, besides the last.
    also_after: &'static [usize],
}

/// Figures of a case, in any order.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    pub(crate) case: String,
    pub(crate) figures: Vec<Figure>,
}

/// Runs and cases to measure.
#[derive(Debug, Clone)]
pub(crate) struct Request {
    pub(crate) trials: u32,
    pub(crate) seeds: Vec<u64>,
    /// Pairs of each run, instead of those of the case.
    pub(crate) pairs: Option<usize>,
    pub(crate) lens: LensTracking,
    /// Begins of names of cases; all if empty.
    pub(crate) only: Vec<String>,
    /// Folders of recordings for the campaigns of alarms, instead of the shipped ones; the shipped ones if empty.
    pub(crate) recordings: Vec<PathBuf>,
}

impl Request {
    fn takes(&self, case: &str) -> bool {
        self.only.is_empty() || self.only.iter().any(|prefix| case.starts_with(prefix))
    }
}

/// All campaigns, in the order of the tables.
pub(crate) fn all() -> Vec<Campaign> {
    let groups = [
        recorded::campaigns(),
        alarms::campaigns(),
        made::campaigns(),
        real::campaigns(),
        images::campaigns(),
    ];
    groups.into_iter().flatten().collect()
}

/// The campaigns of these names; all without a name.
pub(crate) fn named(names: &[String]) -> Result<Vec<Campaign>> {
    let all = all();
    let known: Vec<&str> = all.iter().map(|campaign| campaign.name).collect();
    for name in names {
        ensure!(known.contains(&&**name), "no campaign {name}; there are {}", known.join(", "));
    }
    let chosen = |of: &Campaign| names.is_empty() || names.iter().any(|name| name == of.name);
    Ok(all.into_iter().filter(chosen).collect())
}

impl Campaign {
    pub(crate) fn columns(&self) -> Vec<&'static str> {
        self.columns.split(", ").collect()
    }

    /// All of the committed table, or its quick cases; `None` without such.
    pub(crate) fn request(&self, quick: bool) -> Option<Request> {
        let only = if quick { vec![self.quick?.to_owned()] } else { Vec::new() };
        let (trials, seeds) = (self.trials, self.seeds.to_vec());
        Some(Request { trials, seeds, pairs: None, lens: self.lens, only, recordings: Vec::new() })
    }

    /// Measures the requested cases.
    pub(crate) fn rows(&self, request: &Request) -> Result<Vec<Row>> {
        let mut rows = match self.measure {
            Measure::Rows(rows) => rows(request)?,
            Measure::Runs(cases) => of_runs(self.name, cases()?, request)?,
        };
        if let Some(name) = self.worst_first {
            let loss = |row: &Row| row.figure(name).map_or(f64::NAN, |figure| figure.value);
            rows.sort_by(|a, b| loss(b).total_cmp(&loss(a)));
        }
        ensure!(!rows.is_empty(), "no case begins with {}", request.only.join(" or "));
        Ok(rows)
    }
}

fn of_runs(campaign: &str, mut cases: Vec<Case>, request: &Request) -> Result<Vec<Row>> {
    cases.retain(|case| request.takes(&case.name));
    let seeds = || request.seeds.iter().map(|seed| *seed..*seed + u64::from(request.trials));
    let scenes: usize = cases.iter().map(|case| case.scenarios.len()).sum();
    let bar = progress::over(scenes * seeds().map(Iterator::count).sum::<usize>(), "runs");
    let mut rows = Vec::new();
    for Case { name, mut scenarios, also_after } in cases {
        bar.set_message(format!("runs, {campaign}: {name}"));
        let mut runs = Vec::new();
        for scenario in &mut scenarios {
            scenario.pairs = request.pairs.unwrap_or(scenario.pairs);
            for seeds in seeds() {
                // Most rigs start from a guess, which confirms no depth: arming is measured by rows.
                let config = request.lens.config().with_depth_limit_px(f32::INFINITY)?;
                let of = monte_carlo::runs::<f32>(scenario, config, seeds, || bar.inc(1));
                runs.extend(of.with_context(|| name.clone())?);
            }
        }
        let scenario = scenarios.last().with_context(|| format!("{name} has no scene"))?;
        let end = scenario.pairs;
        let also = also_after.iter().copied().filter(|&pairs| pairs < end);
        for pairs in also.chain([end]) {
            let after = if pairs < end { format!(", after {pairs} pairs") } else { String::new() };
            let figures = figures::all(&runs, scenario, pairs);
            rows.push(Row { case: format!("{name}{after}"), figures });
        }
    }
    bar.finish_and_clear();
    Ok(rows)
}
