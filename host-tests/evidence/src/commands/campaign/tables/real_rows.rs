//! Tables of `campaign real`.

use anyhow::{Context, Result};
use sim::run::LensTracking;
use sim::run::real_figures::Figures;

use super::super::{CampaignArgs, What, real};
use super::accuracy::arguments;
use super::{Row, Table, figure, joined, list, percent};

/// Label of a row, and its cases.
type Cases = (&'static str, &'static [&'static str]);

const LENSES: [Cases; 12] = [
    ("right lens as given", &["lens/none"]),
    (
        "right focal length off by 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1 %",
        &[
            "lens/f_r=0.01%",
            "lens/f_r=0.02%",
            "lens/f_r=0.05%",
            "lens/f_r=0.1%",
            "lens/f_r=0.2%",
            "lens/f_r=0.5%",
            "lens/f_r=1%",
        ],
    ),
    (
        "right `k1` off by 0.0002, 0.002, 0.005, 0.02",
        &["lens/k1_r=0.0002", "lens/k1_r=0.002", "lens/k1_r=0.005", "lens/k1_r=0.02"],
    ),
    (
        "right principal column off by 1, 5, row by 0.5, 2 px",
        &["lens/cx_r=1", "lens/cx_r=5", "lens/cy_r=0.5", "lens/cy_r=2"],
    ),
    ("right `p1`, `p2` off by 0.0005", &["lens/p1_r=0.0005", "lens/p2_r=0.0005"]),
    ("right `k2` off by 0.01, aspect by 0.2 %", &["lens/k2_r=0.01", "lens/aspect_r=0.2%"]),
    (
        "both focal lengths off by 0.2, 1 %, both `k1` by 0.02",
        &["lens/f_both=0.2%", "lens/f_both=1%", "lens/k1_both=0.02"],
    ),
    ("all drawn from the prior", &["lens/prior"]),
    ("drift of 0.005 degrees a pair, right lens as given", &["moving/drift-0.005-none"]),
    (
        "the same drift, focal length off by 0.1, 0.2 %",
        &["moving/drift-0.005-f_r=0.1%", "moving/drift-0.005-f_r=0.2%"],
    ),
    ("step of 0.5 degrees, focal length off by 0.1 %", &["moving/step-0.5-f_r=0.1%"]),
    (
        "creeping by 2, 4, 10 px a pair",
        &["creeping/creeping-2", "creeping/creeping-4", "creeping/creeping-10"],
    ),
];

/// Rows of the table `lenses` only.
const GIVEN: [Cases; 4] = [
    ("1000 pairs, right lens as given", &["long/none"]),
    ("1000 pairs, focal length off by 0.01, 0.02 %", &["long/f_r=0.01%", "long/f_r=0.02%"]),
    ("1000 pairs, principal column off by 1, row by 0.5 px", &["long/cx_r=1", "long/cy_r=0.5"]),
    ("parked for 200 pairs, then 100 moving", &["parked/landmarks"]),
];

/// Rows of the table `compensated` only.
const COMPENSATED: [Cases; 1] = [(
    "right lens as given, vibration of 0.02, 0.05, 0.1, 0.2 degrees",
    &["vibration/0.02", "vibration/0.05", "vibration/0.1", "vibration/0.2"],
)];

const FENCES: [Cases; 6] = [
    (
        "fence of 40 %, 1.5, 3, 8 px, 8 px in a part of the image",
        &["fence/0.4-1.5", "fence/0.4-3", "fence/0.4-8", "fence/0.4-8-local"],
    ),
    (
        "fence of 30 %, the same",
        &["fence/0.3-1.5", "fence/0.3-3", "fence/0.3-8", "fence/0.3-8-local"],
    ),
    (
        "fence of 20 %, the same",
        &["fence/0.2-1.5", "fence/0.2-3", "fence/0.2-8", "fence/0.2-8-local"],
    ),
    (
        "noise of 1, 2, 4 px, no outliers",
        &["noise/1-outliers-0", "noise/2-outliers-0", "noise/4-outliers-0"],
    ),
    (
        "noise of 1, 2, 4 px, 30 % outliers",
        &["noise/1-outliers-0.3", "noise/2-outliers-0.3", "noise/4-outliers-0.3"],
    ),
    ("no fence, noise of 0.3 px", &["ideal/near"]),
];

const ALTITUDE: [Cases; 10] = [
    ("250, 300 to 3000", &["altitude/f250-300-3000"]),
    ("250, 500 to 5000", &["altitude/f250-500-5000"]),
    ("250, 1000 to 10,000", &["altitude/f250-1000-10000"]),
    ("1400, 3 to 80", &["altitude/f1400-3-80"]),
    ("1400, 30 to 800", &["altitude/f1400-30-800"]),
    ("1400, 300 to 3000", &["altitude/f1400-300-3000"]),
    ("1400, 1000 to 10,000", &["altitude/f1400-1000-10000"]),
    ("1400, 3000 to 30,000", &["altitude/f1400-3000-30000"]),
    (
        "1400, 6 % from 3 to 80, others from 300 to 3000; 0, 10, 30 % outliers",
        &["altitude/near-few-0", "altitude/near-few-0.1", "altitude/near-few-0.3"],
    ),
    ("1400, 5 % from 3 to 80, others in the sky", &["altitude/sky"]),
];

const VIBRATION: [Cases; 4] = [
    ("0.02", &["vibration/0.02"]),
    ("0.05", &["vibration/0.05"]),
    ("0.1", &["vibration/0.1"]),
    ("0.2", &["vibration/0.2"]),
];

/// Values of `a`, one for each row, and knocks, one for each column of a start.
const ERRORS: [&str; 4] = ["0", "0.001", "0.003", "0.01"];
const KNOCKS: [&str; 4] = ["none", "pitch", "yaw", "roll"];

pub(super) fn tables() -> Vec<Table> {
    let lenses = &[
        "rig",
        "`e_t`, median",
        "worst",
        "error over reported sd, 95 %: t; R",
        "armed after 50 pairs; at the end",
        "runs with a locked pair beyond 5 sd",
    ];
    let altitude = &[
        "focal length in px, depths in baselines",
        "`e_R` over the joint fit",
        "`e_t`, median",
        "`e_t` in use, worst over the start",
        "runs with a locked pair beyond 5 sd",
    ];
    let reported = || real_args(24, SEED);
    let compensated = || CampaignArgs { lens: LensTracking::Compensate, ..real_args(24, SEED) };
    vec![
        table("lenses", lenses, &[&LENSES[..], &GIVEN].concat(), reported, lens_cells, None),
        table(
            "compensated",
            lenses,
            &[&LENSES[..], &COMPENSATED].concat(),
            compensated,
            lens_cells,
            None,
        ),
        table(
            "fences",
            &[
                "matches",
                "`e_t` over the joint fit",
                "`e_R`",
                "`e_t`, median",
                "worst",
                "runs with a locked pair beyond 5 sd",
            ],
            &FENCES,
            reported,
            fence_cells,
            Some(4),
        ),
        table(
            "vibration",
            &[
                "degrees RMS",
                "runs that have locked, by pair 8, 10, 15, 30",
                "`e_t`, `e_R`, median",
                "error over reported sd, 95 %: t; R",
                "reported vibration, degrees",
                "runs with a locked pair beyond 5 sd",
            ],
            &VIBRATION,
            || real_args(200, 4_000_000),
            vibration_cells,
            None,
        ),
        table("altitude", altitude, &ALTITUDE, reported, altitude_cells, Some(0)),
        table(
            "altitude-1000",
            altitude,
            &ALTITUDE,
            || real_args(1000, 3_000_000),
            altitude_cells,
            None,
        ),
        Table {
            name: "depth",
            heading: &[
                "`a`",
                "factory: no turn",
                "pitch",
                "yaw",
                "roll",
                "guess: no turn",
                "pitch",
                "yaw",
                "roll",
            ],
            rows: ERRORS.map(|a| Row::new(a, move || depth_cells(a))).into(),
            quick: None,
        },
    ]
}

/// First seed of the campaigns of real rigs with few runs.
const SEED: u64 = 1_000_000;

fn real_args(trials: u32, seed: u64) -> CampaignArgs {
    arguments(What::Real, trials, seed)
}

/// A table whose rows show several cases each.
fn table(
    name: &'static str,
    heading: &'static [&'static str],
    rows: &[Cases],
    args: fn() -> CampaignArgs,
    cells: fn(&[Vec<Figures>]) -> Vec<String>,
    quick: Option<usize>,
) -> Table {
    let row = |(label, paths): &Cases| {
        let paths = *paths;
        Row::new(*label, move || {
            let all = paths.iter().map(|path| real::figures(&args(), path));
            Ok(cells(&all.collect::<Result<Vec<_>>>()?))
        })
    };
    Table { name, heading, rows: rows.iter().map(row).collect(), quick }
}

/// Figures of all cases after each reported number of pairs, case by case. The last ones of a case are of its end.
fn ends(cases: &[Vec<Figures>]) -> impl Iterator<Item = &Figures> + Clone {
    cases.iter().flatten()
}

fn last(cases: &[Vec<Figures>]) -> impl Iterator<Item = &Figures> + Clone {
    cases.iter().filter_map(|case| case.last())
}

fn bad(cases: &[Vec<Figures>]) -> String {
    joined(last(cases).map(|f| f.bad.to_string()))
}

/// 95th percentiles of the error over the reported deviation.
fn in_sd(cases: &[Vec<Figures>]) -> String {
    let t = list(last(cases).map(|f| f.t_in_sd[0]));
    format!("{t}; {}", list(last(cases).map(|f| f.r_in_sd[0])))
}

fn lens_cells(cases: &[Vec<Figures>]) -> Vec<String> {
    let armed = |at: usize| percent(last(cases).map(|f| f.armed[at]), 0);
    vec![
        list(last(cases).map(|f| f.e_t[0])),
        list(last(cases).map(|f| f.e_t[1])),
        in_sd(cases),
        format!("{}; {}", armed(1), armed(2)),
        bad(cases),
    ]
}

fn fence_cells(cases: &[Vec<Figures>]) -> Vec<String> {
    vec![
        list(last(cases).map(|f| f.over_joint_fit()[0])),
        list(last(cases).map(|f| f.over_joint_fit()[1])),
        list(last(cases).map(|f| f.e_t[0])),
        list(last(cases).map(|f| f.e_t[1])),
        bad(cases),
    ]
}

fn vibration_cells(cases: &[Vec<Figures>]) -> Vec<String> {
    let locked: Vec<String> = ends(cases).map(|f| f.locked[1].to_string()).collect();
    let [least, _, most] = last(cases).next().map_or([f64::NAN; 3], |f| f.vibration_r);
    let per_axis = |rad: f64| figure(rad.to_degrees());
    vec![
        locked[..locked.len().min(4)].join(", "),
        joined(last(cases).map(|f| format!("{}, {}", figure(f.e_t[0]), figure(f.e_r[0])))),
        in_sd(cases),
        format!("{} to {}", per_axis(least), per_axis(most)),
        bad(cases),
    ]
}

fn altitude_cells(cases: &[Vec<Figures>]) -> Vec<String> {
    vec![
        list(last(cases).map(|f| f.over_joint_fit()[1])),
        list(last(cases).map(|f| f.e_t[0])),
        list(last(cases).map(|f| f.in_use_growth)),
        bad(cases),
    ]
}

/// Error of `R` at the end, median and worst, mrad.
fn depth_cells(a: &str) -> Result<Vec<String>> {
    let starts = ["factory", "guess"];
    let paths =
        starts.iter().flat_map(|start| KNOCKS.map(|knock| format!("depth/{a}-{knock}-{start}")));
    let cell = |path: String| {
        let figures = real::figures(&real_args(6, SEED), &path)?;
        let e = figures.last().context("figures")?.e_r;
        Ok(e.map(|e| figure(1e3 * e)).join(", "))
    };
    paths.map(cell).collect()
}
