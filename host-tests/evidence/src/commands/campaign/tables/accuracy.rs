//! Tables of `campaign single`, `fused`, `steps`, `garbage` and `grids`.

use anyhow::{Context, Result};
use sim::run::LensTracking;
use sim::run::monte_carlo::Run;
use sim::synth::ScenarioKind;

use super::super::fused::{self, SCENES, Scenes};
use super::super::stats::{after, alarms};
use super::super::steps::{Found, STEPS};
use super::super::{CampaignArgs, GARBAGE, What, grids, rigs_on_grids, single};
use super::{Row, Table, figure, joined, list, outliers, percent};

/// Seeds of the table of locks: one campaign of 1000 runs per seed, scene and share of outliers.
const LOCK_SEEDS: [u64; 3] = [9_500_000, 9_700_000, 9_800_000];

/// Cases of a row of single pairs: label, and names.
const SINGLE: [(&str, &[&str]); 12] = [
    (
        "256 matches, 0, 30, 50, 60, 70 % outliers",
        &[
            "n256/outliers-0",
            "n256/outliers-0.3",
            "n256/outliers-0.5",
            "n256/outliers-0.6",
            "n256/outliers-0.7",
        ],
    ),
    ("64 matches, 30, 50, 60 %", &["n64/outliers-0.3", "n64/outliers-0.5", "n64/outliers-0.6"]),
    ("30 matches, 30, 50 %", &["n30/outliers-0.3", "n30/outliers-0.5"]),
    ("20, 12 matches, 20 %", &["n20/outliers-0.2", "n12/outliers-0.2"]),
    (
        "start 10 degrees off, 30, 70 %",
        &["start/10-degrees-outliers-0.3", "start/10-degrees-outliers-0.7"],
    ),
    (
        "start 20 degrees off, 30, 50 %",
        &["start/20-degrees-outliers-0.3", "start/20-degrees-outliers-0.5"],
    ),
    ("start 20 degrees off in pitch, 40 %", &["start/pitch-20-outliers-0.4"]),
    (
        "noise of 1, 2, 4 px, no outliers",
        &["noise/1-px-outliers-0", "noise/2-px-outliers-0", "noise/4-px-outliers-0"],
    ),
    (
        "noise of 1, 2, 4 px, 30 %",
        &["noise/1-px-outliers-0.3", "noise/2-px-outliers-0.3", "noise/4-px-outliers-0.3"],
    ),
    (
        "fence of 20 % of the matches, 1.5, 3, 8 px across it, 8 px and local",
        &["fence/0.2-1.5-px", "fence/0.2-3-px", "fence/0.2-8-px", "fence/0.2-8-px-local"],
    ),
    (
        "fence of 30 %, the same",
        &["fence/0.3-1.5-px", "fence/0.3-3-px", "fence/0.3-8-px", "fence/0.3-8-px-local"],
    ),
    (
        "fence of 40 %, the same",
        &["fence/0.4-1.5-px", "fence/0.4-3-px", "fence/0.4-8-px", "fence/0.4-8-px-local"],
    ),
];

/// Arguments of a campaign.
pub(super) fn arguments(what: What, trials: u32, seed: u64) -> CampaignArgs {
    let (lens, vibration) = (LensTracking::Report, 0.0);
    let (trials, pairs, only, csv) = (Some(trials), None, Vec::new(), None);
    CampaignArgs { what, trials, pairs, seed, lens, vibration, only, csv }
}

pub(super) fn tables() -> Vec<Table> {
    vec![
        Table {
            name: "single",
            heading: &[
                "one pair",
                "`sigma_t`, `sigma_theta` over the bound",
                "within 4 times the bound",
                "no answer",
                "passes: mean; most",
            ],
            rows: SINGLE.map(|(label, names)| Row::new(label, || single_row(names))).into(),
            quick: Some(0),
        },
        Table {
            name: "fused",
            heading: &[
                "100 pairs fused",
                "`e_t` over the joint fit",
                "`e_theta`",
                "NEES",
                "all locked by pair",
                "locked pairs beyond 5 sd",
                "passes: locked; before; at most",
            ],
            rows: SCENES.map(|scenes| Row::new(label(&scenes), move || fused_row(scenes))).into(),
            quick: Some(4),
        },
        Table {
            name: "locks",
            heading: &["20 pairs fused", "runs", "locked pairs", "beyond 5 sd", "runs so at lock"],
            rows: SCENES.map(|scenes| Row::new(label(&scenes), move || locks_row(scenes))).into(),
            quick: None,
        },
        Table {
            name: "steps",
            heading: &[
                "step, degrees",
                "pairs until it is followed: median, 99 %, last",
                "never",
                "`e_t`, `e_theta` in use after 3 pairs",
                "after 15",
                "after 100",
            ],
            rows: STEPS
                .map(|degrees| Row::new(degrees.to_string(), move || step_row(degrees)))
                .into(),
            quick: None,
        },
        Table {
            name: "steady",
            heading: &["what", "figure"],
            rows: vec![
                Row::new(
                    "drift of 0.01 degrees a pair: `e_t`, `e_theta` in use after 100 pairs",
                    drift_row,
                ),
                Row::new("no step: changes of the estimate", calm_row),
            ],
            quick: Some(0),
        },
        Table {
            name: "garbage",
            heading: &["wrong matches a pair, and no right one", "runs of 100 pairs that lock"],
            rows: GARBAGE
                .map(|matches| Row::new(matches.to_string(), move || garbage_row(matches)))
                .into(),
            quick: Some(3),
        },
        Table {
            name: "grids",
            heading: &[
                "noise, grid",
                "`e_t` over the bound; rig 0.02, 0.1, 5 degrees off",
                "`e_theta`",
                "runs that lock",
            ],
            rows: [0.1, 0.3].into_iter().flat_map(grid_rows).collect(),
            quick: None,
        },
    ]
}

fn single_row(names: &[&str]) -> Result<Vec<String>> {
    let args = arguments(What::Single, 1000, 9_000_000);
    let scenarios = single::scenarios()?;
    let figures = names.iter().map(|name| {
        let scenario = scenarios.iter().find(|(of, _)| of == name);
        let (_, scenario) = scenario.with_context(|| format!("no case {name}"))?;
        Ok(single::Figures::of(&args.runs::<f32>(scenario)?))
    });
    let figures: Vec<single::Figures> = figures.collect::<Result<_>>()?;
    let sigma = |part: usize| list(figures.iter().map(|f| f.sigma[part]));
    Ok(vec![
        format!("{}; {}", sigma(0), sigma(1)),
        percent(figures.iter().map(|f| f.within), 1),
        percent(figures.iter().map(|f| f.none), 1),
        format!(
            "{}; {}",
            joined(figures.iter().map(|f| format!("{:.1}", f.passes[0]))),
            joined(figures.iter().map(|f| f.passes[1].to_string()))
        ),
    ])
}

fn label((name, _, shares, _): &Scenes) -> String {
    format!("{name}, {}", outliers(shares))
}

/// Figures of all scenes of a row.
fn fused(args: &CampaignArgs, (_, kind, shares, matches): Scenes) -> Result<Vec<fused::Figures>> {
    let figures = shares.iter().map(|share| {
        let mut scenario = args.scenario(kind, *share, 100);
        scenario.scene.matches = matches.unwrap_or(scenario.scene.matches);
        Ok(fused::Figures::of(&args.runs::<f32>(&scenario)?))
    });
    figures.collect()
}

fn fused_row(scenes: Scenes) -> Result<Vec<String>> {
    let args = arguments(What::Fused, 200, 9_000_000);
    let all = fused(&args, scenes)?;
    let runs = usize::try_from(args.trials())?;
    let locked = |f: &fused::Figures| match f.locked {
        locked if locked == runs => f.by_pair.to_string(),
        locked => format!("{locked} of {runs} runs"),
    };
    let passes = |state: usize, part: usize| all.iter().map(move |f| f.passes[state][part]);
    Ok(vec![
        list(all.iter().map(|f| f.e[0])),
        list(all.iter().map(|f| f.e[1])),
        list(all.iter().map(|f| f.nees)),
        joined(all.iter().map(locked)),
        joined(all.iter().map(|f| f.beyond[1].to_string())),
        format!(
            "{}; {}; {}",
            list(passes(0, 0)),
            list(passes(1, 0)),
            passes(1, 1).fold(0.0, f64::max)
        ),
    ])
}

fn locks_row(scenes: Scenes) -> Result<Vec<String>> {
    let mut sums = [0; 3];
    for seed in LOCK_SEEDS {
        let mut args = arguments(What::Fused, 1000, seed);
        args.pairs = Some(20);
        for figures in fused(&args, scenes)? {
            sums.iter_mut().zip(figures.beyond).for_each(|(sum, n)| *sum += n);
        }
    }
    let runs = 1000 * LOCK_SEEDS.len() * scenes.2.len();
    Ok([runs, sums[0], sums[1], sums[2]].map(|n| n.to_string()).into())
}

/// `e_t`, `e_theta` in use after so many pairs.
fn in_use(runs: &[Run], pairs: usize) -> String {
    after(runs, pairs)
        .map_or("-".into(), |(e, _)| format!("{}, {}", figure(e.translation), figure(e.rotation)))
}

fn step_row(degrees: f64) -> Result<Vec<String>> {
    let args = arguments(What::Steps, 200, 9_600_000);
    let mut scenario = args.scenario(ScenarioKind::Step, 0.1, 200);
    scenario.turn_deg = degrees;
    let runs = args.runs::<f32>(&scenario)?;
    let step = scenario.pairs.div_ceil(2);
    let found = Found::of(&runs, step);
    let quantiles = [0.5, 0.99, 1.0].map(|share| format!("{:.0}", found.quantile(share)));
    let mut cells =
        vec![quantiles.join(", "), format!("{} of {}", runs.len() - found.after.len(), runs.len())];
    cells.extend([3, 15, 100].map(|pairs| in_use(&runs, step + pairs)));
    Ok(cells)
}

fn drift_row() -> Result<Vec<String>> {
    let args = arguments(What::Steps, 200, 9_600_000);
    let mut drift = args.scenario(ScenarioKind::Drift, 0.1, 100);
    drift.turn_deg = 0.01;
    Ok(vec![in_use(&args.runs::<f32>(&drift)?, 100)])
}

fn calm_row() -> Result<Vec<String>> {
    let args = arguments(What::Steps, 200, 9_600_000);
    let calm = args.runs::<f32>(&args.scenario(ScenarioKind::Near, 0.1, 300))?;
    let pairs: usize = calm.iter().map(|run| run.pairs.len()).sum();
    Ok(vec![format!("{} in {pairs} pairs", alarms(&calm, 0))])
}

fn garbage_row(matches: usize) -> Result<Vec<String>> {
    let [locked, runs] = arguments(What::Garbage, 400, 7_000_000).garbage_locks(matches)?;
    Ok(vec![format!("{locked} of {runs}")])
}

fn grid_rows(noise: f64) -> Vec<Row> {
    let row = |(name, grid, effective): (String, _, f64)| {
        let label = format!("{noise} px, {name}");
        Row::new(label, move || {
            let args = arguments(What::Grids, 200, 9_700_000);
            let all = rigs_on_grids()?.map(|(_, rig)| args.on_grid((noise, grid, effective), &rig));
            let all: Vec<([f64; 2], usize)> = all.into_iter().collect::<Result<_>>()?;
            Ok(vec![
                list(all.iter().map(|(e, _)| e[0])),
                list(all.iter().map(|(e, _)| e[1])),
                joined(all.iter().map(|(_, locked)| locked.to_string())),
            ])
        })
    };
    grids(noise).into_iter().map(row).collect()
}
