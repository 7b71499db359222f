//! Campaigns of the project's figures: single pairs, fused pairs, steps, wrong matches, grids, numbers.
#![expect(clippy::unnecessary_wraps, reason = "all groups of cases have one type")]

use anyhow::{Context, Result};
use sim::run::LensTracking::Report;
use sim::run::monte_carlo::{long_run, runs};
use sim::run::progress;
use sim::stats::rms;
use sim::synth::{Fence, Grid, Scenario, ScenarioKind, five_degrees_off, rig};
use stereo_selfcal::geometry::metrics::Deviation;
use stereo_selfcal::{Config, Extrinsics};

use super::chance::Chance;
use super::figures::{Figure, counted};
use super::{Campaign, Case, Measure, Request, Row};

pub(super) fn campaigns() -> Vec<Campaign> {
    use Measure::{Rows, Runs};
    let campaign = |name, trials, seeds, measure, columns| Campaign {
        name,
        trials,
        seeds,
        lens: Report,
        columns,
        quick: None,
        worst_first: None,
        measure,
        chart: None,
    };
    let single = campaign(
        "single",
        1000,
        &[9_000_000],
        Runs(single_cases),
        "sigma_t over bound, sigma_R over bound, within 4 bounds, no estimate, passes, passes at most",
    );
    let fused = "e_t over joint fit, e_R over joint fit, NEES, locked, all locked by pair, pairs beyond 5 sd, \
                 passes before";
    let locks = "runs, locked pairs, pairs beyond 5 sd, locks beyond 5 sd";
    let steps = "followed after, followed after 99 %, followed after at most, never followed, e_t 3 pairs later, \
                 e_R 3 pairs later, e_t 15 pairs later, e_R 15 pairs later, e_t in use, e_R in use";
    let steady = "e_t in use, e_R in use, changes, pairs";
    let steady = campaign("steady", 200, &[9_600_000], Runs(steady_cases), steady);
    let garbage = campaign("garbage", 400, &[7_000_000], Runs(garbage_cases), "ever locked");
    let grids = "e_t over bound, e_R over bound, locked";
    vec![
        Campaign { quick: Some("256 matches, 30 %"), ..single },
        campaign("fused", 200, &[9_000_000], Runs(fused_cases), fused),
        campaign("locks", 1000, &[9_500_000, 9_700_000, 9_800_000], Runs(lock_cases), locks),
        campaign("steps", 200, &[9_600_000], Runs(step_cases), steps),
        Campaign { quick: Some("drift"), ..steady },
        Campaign { quick: Some("20 "), ..garbage },
        campaign("grids", 200, &[9_700_000], Runs(grid_cases), grids),
        campaign("numbers", 20, &[9_800_000], Rows(numbers), "t over bound"),
        campaign("long", 1, &[1_000_000], Rows(long), "e_t, e_R"),
    ]
}

/// Pairs from 5 degrees off about all axes, `t` 5 degrees off.
fn scenario(kind: ScenarioKind, outliers: f64, pairs: usize) -> Scenario {
    let mut scenario = Scenario::new(kind, pairs);
    scenario.scene.outliers = outliers;
    scenario.scene.rig = five_degrees_off();
    scenario
}

fn case(name: impl Into<String>, scenarios: Vec<Scenario>) -> Case {
    Case { name: name.into(), scenarios, also_after: &[] }
}

fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}

fn single_cases() -> Result<Vec<Case>> {
    let pair = |name: String, outliers: f64, change: &dyn Fn(&mut Scenario)| {
        let mut one = scenario(ScenarioKind::Near, outliers, 1);
        change(&mut one);
        case(format!("{name}, {} outliers", percent(outliers)), vec![one])
    };
    let counts: [(usize, &[f64]); 5] = [
        (256, &[0.0, 0.3, 0.5, 0.6, 0.7]),
        (64, &[0.3, 0.5, 0.6]),
        (30, &[0.3, 0.5]),
        (20, &[0.2]),
        (12, &[0.2]),
    ];
    let mut cases = Vec::new();
    for (matches, shares) in counts {
        cases.extend(shares.iter().map(|share| {
            pair(format!("{matches} matches"), *share, &|one| one.scene.matches = matches)
        }));
    }
    for (off, outliers) in [(10.0, 0.3), (10.0, 0.7), (20.0, 0.3), (20.0, 0.5)] {
        cases.push(pair(format!("start {off} degrees off"), outliers, &|one| {
            (one.scene.rig, one.off_deg) = (Extrinsics::SIDE_BY_SIDE, off);
        }));
    }
    let pitched = rig([20.0, 0.0, 0.0], [0.0, 0.0])?;
    cases.push(pair("start 20 degrees off in pitch".into(), 0.4, &|one| one.scene.rig = pitched));
    for (px, outliers) in
        [0.0, 0.3].into_iter().flat_map(|share| [1.0, 2.0, 4.0].map(|px| (px, share)))
    {
        cases.push(pair(format!("noise of {px} px"), outliers, &|one| one.scene.noise_px = px));
    }
    cases.extend(fences().into_iter().map(|(name, fence)| {
        pair(format!("fence of {name}"), 0.1, &|one| one.scene.fence = Some(fence))
    }));
    Ok(cases)
}

/// Matches that agree with each other but not with the scene.
pub(super) fn fences() -> Vec<(String, Fence)> {
    let shapes = [(1.5, false), (3.0, false), (8.0, false), (8.0, true)];
    let all =
        [0.2, 0.3, 0.4].into_iter().flat_map(|share| shapes.map(|(px, local)| (share, px, local)));
    all.map(|(share, across_px, local)| {
        let place = if local { ", in a part of the image" } else { "" };
        let name = format!("{}, {across_px} px across{place}", percent(share));
        (name, Fence { share, across_px, local })
    })
    .collect()
}

/// Scenes, shares of outliers, and matches a pair if they differ from the scene's.
const SCENES: [(&str, ScenarioKind, &[f64], Option<usize>); 9] = [
    ("near", ScenarioKind::Near, &[0.0, 0.1, 0.3, 0.5], None),
    ("far", ScenarioKind::Far, &[0.1, 0.3], None),
    ("very far", ScenarioKind::VeryFar, &[0.1, 0.3], None),
    ("heterogeneous", ScenarioKind::Heterogeneous, &[0.1, 0.5], None),
    ("narrow band", ScenarioKind::NarrowBand, &[0.3], None),
    ("planar", ScenarioKind::Planar, &[0.3, 0.5], None),
    ("fronto-parallel", ScenarioKind::FrontoParallel, &[0.3, 0.5], None),
    ("near, 54 matches a pair", ScenarioKind::Near, &[0.1, 0.3, 0.5], Some(54)),
    ("near, 64 matches a pair", ScenarioKind::Near, &[0.1, 0.3, 0.5], Some(64)),
];

fn fused_cases() -> Result<Vec<Case>> {
    let cases = scenes(100).into_iter().flat_map(|(name, scenes)| {
        scenes.into_iter().map(move |scene| {
            case(format!("{name}, {} outliers", percent(scene.scene.outliers)), vec![scene])
        })
    });
    Ok(cases.collect())
}

/// One case for all shares of outliers.
fn lock_cases() -> Result<Vec<Case>> {
    Ok(scenes(20).into_iter().map(|(name, scenes)| case(name, scenes)).collect())
}

fn scenes(pairs: usize) -> Vec<(&'static str, Vec<Scenario>)> {
    SCENES
        .map(|(name, kind, shares, matches)| {
            let of = |share: &f64| {
                let mut scenario = scenario(kind, *share, pairs);
                scenario.scene.matches = matches.unwrap_or(scenario.scene.matches);
                scenario
            };
            (name, shares.iter().map(of).collect())
        })
        .into()
}

fn step_cases() -> Result<Vec<Case>> {
    let step = |degrees: f64| {
        let step = Scenario { turn_deg: degrees, ..scenario(ScenarioKind::Step, 0.1, 200) };
        case(format!("{degrees} degrees"), vec![step])
    };
    Ok([5.0, 0.5, 0.3, 0.1, 0.05, 0.02, 0.01].map(step).into())
}

fn steady_cases() -> Result<Vec<Case>> {
    let drift = Scenario { turn_deg: 0.01, ..scenario(ScenarioKind::Drift, 0.1, 100) };
    Ok(vec![
        case("drift of 0.01 degrees a pair", vec![drift]),
        case("no turn", vec![scenario(ScenarioKind::Near, 0.1, 300)]),
    ])
}

fn garbage_cases() -> Result<Vec<Case>> {
    let wrong = |matches: usize| {
        let mut wrong = scenario(ScenarioKind::Near, 1.0, 100);
        wrong.scene.matches = matches;
        case(format!("{matches} wrong matches a pair"), vec![wrong])
    };
    Ok([256, 64, 30, 20].map(wrong).into())
}

fn grid_cases() -> Result<Vec<Case>> {
    let rigs = [
        ("0.02", rig([0.02, 0.01, 0.0], [0.02, 0.02])?),
        ("0.1", rig([0.1, 0.1, 0.1], [0.1, 0.1])?),
        ("5", five_degrees_off()),
    ];
    let grids = [
        ("1 px", Grid::Pixels(1.0)),
        ("0.5 px", Grid::Pixels(0.5)),
        ("0.25 px", Grid::Pixels(0.25)),
        ("pyramid", Grid::Pyramid),
    ];
    let all = [0.1, 0.3].into_iter().flat_map(|noise| grids.map(|grid| (noise, grid)));
    let all = all.flat_map(|(noise, grid)| rigs.map(|rig| (noise, grid, rig)));
    let of = |(noise, (grid_name, grid), (off, rig)): (f64, (&str, Grid), (&str, _))| {
        let mut rounded = scenario(ScenarioKind::Near, 0.1, 100);
        (rounded.scene.noise_px, rounded.scene.grid, rounded.scene.rig) = (noise, grid, rig);
        case(format!("noise {noise} px, grid {grid_name}, {off} degrees off"), vec![rounded])
    };
    Ok(all.map(of).collect())
}

/// `f32` against `f64`: RMS difference of `t` and of `R` over the bound of all pairs.
fn numbers(request: &Request) -> Result<Vec<Row>> {
    let kinds =
        [ScenarioKind::Near, ScenarioKind::Far, ScenarioKind::VeryFar, ScenarioKind::Heterogeneous];
    let first = request.seeds.first().context("a campaign has a seed")?;
    let seeds = || *first..*first + u64::from(request.trials);
    let mut rows = Vec::new();
    for kind in kinds.into_iter().filter(|kind| request.takes(&kind.to_string())) {
        let scenario = scenario(kind, 0.3, request.pairs.unwrap_or(1000));
        let bar = progress::over(2 * seeds().count(), "runs");
        let single = runs::<f32>(&scenario, Config::default(), seeds(), || bar.inc(1))?;
        let double = runs::<f64>(&scenario, Config::default(), seeds(), || bar.inc(1))?;
        bar.finish_and_clear();
        let apart = single.iter().zip(&double).filter_map(|(a, b)| {
            let apart = Deviation::between(&a.last()?.found, &b.last()?.found);
            let bound = b.bound?;
            Some([apart.translation / bound.translation, apart.rotation / bound.rotation])
        });
        let apart: Vec<[f64; 2]> = apart.collect();
        let of = |name, part: usize| {
            let value = rms(apart.iter().map(|apart| apart[part])).unwrap_or(f64::NAN);
            Figure { name, value, chance: Chance::rms(apart.len()) }
        };
        let figures = vec![of("t over bound", 0), of("R over bound", 1)];
        rows.push(Row { case: kind.to_string(), figures });
    }
    Ok(rows)
}

/// One run, after 1000 pairs and each further power of ten.
fn long(request: &Request) -> Result<Vec<Row>> {
    let scenario = scenario(ScenarioKind::Near, 0.3, request.pairs.unwrap_or(1_000_000));
    let seed = *request.seeds.first().context("a campaign has a seed")?;
    let bar = progress::over(scenario.pairs, "pairs");
    let kept = long_run::<f32>(&scenario, Config::default(), seed, || bar.inc(1))?;
    bar.finish_and_clear();
    let row = |(pairs, m): &(usize, sim::run::monte_carlo::AfterPair)| {
        let one = |name, value| Figure { name, value, chance: Chance::rms(1) };
        let figures = vec![
            one("e_t", m.error.translation),
            one("e_R", m.error.rotation),
            one("error over sd", m.error_in_sd),
            counted("pairs", *pairs),
        ];
        Row { case: format!("{pairs} pairs"), figures }
    };
    Ok(kept.iter().filter(|(pairs, _)| *pairs >= 1000).map(row).collect())
}
