//! Campaigns of alarms over recorded pairs: knocks that must be answered, and rest that must not raise an alarm.
//!
//! The definitions judge by the truth, which is the reference with its knock, and by whether the calibration in use is
//! *right* ([`Judged::is_right`]):
//! - An *alarm* is a verdict that forbids arming. It is *false* if the calibration in use is right.
//! - A knock is *missed* if the verdict on the tenth pair after it permits arming with a wrong calibration in use.
//! - A run has *recovered* with the first pair from which on the calibration is right and the verdict permits arming.

use std::path::Path;

use anyhow::{Context, Result};
use page::chart::curves::{self, Curve, Line, Scale};
use page::chart::palette;
use page::report::{Entry, Mark};
use rayon::prelude::*;
use sim::run::{LensTracking, progress};

use super::chance::Chance;
use super::figures::{Figure, count, counted, quantile_of, shared};
use super::recording::{Axis, BEFORE, Fate, Judged, Recording};
use super::{Campaign, Measure, Request, Row};
use crate::sections::alone;

/// Names of the campaigns.
pub(crate) const NAMES: [&str; 2] = ["knocks", "rest"];

/// Recordings with reference extrinsics.
const SETS: [&str; 3] = ["opencv_chess_corners", "opencv_chess_sift", "oak_sift"];

/// Sizes of knocks, degrees.
const SIZES: [f64; 7] = [0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 3.0];

/// Pairs after a knock.
const AFTER: usize = 40;

/// Pairs after which a knock that was not answered is missed.
const PATIENCE: usize = 10;

/// Pairs of an hour at 10 Hz.
const HOUR: f64 = 36_000.0;

/// Pairs of a run at rest.
const REST: usize = 3000;

/// Pairs whose verdicts count as one for the chance of a share, because a verdict stays.
const RUN_OF_PAIRS: usize = 100;

/// Turn with every pair of a rig that drifts, rad.
const DRIFT: f64 = 1e-5;

const KNOCKED: &str = "runs, wrong by it, missed, alarm after, alarm after at most, recovered, recovered after, \
    recovered after at most, rows px, depth px";
const AT_REST: &str = "pairs, armed, false alarms, false alarms an hour, wrong and armed, applied";

pub(super) fn campaigns() -> Vec<Campaign> {
    let campaign = |name, columns, trials, rows| Campaign {
        name,
        trials,
        seeds: &[11_000_000],
        lens: LensTracking::Report,
        columns,
        quick: None,
        worst_first: None,
        measure: Measure::Rows(rows),
        chart: None,
    };
    let [of_knocks, of_rest] = NAMES;
    let knocked = campaign(of_knocks, KNOCKED, 24, knocks);
    vec![Campaign { chart: Some(chart), ..knocked }, campaign(of_rest, AT_REST, 12, rest)]
}

fn runs(
    recording: &Recording,
    fate: Fate,
    pairs: usize,
    request: &Request,
) -> Result<Vec<Vec<Judged>>> {
    let pairs = request.pairs.unwrap_or(pairs);
    let seeds = request.seeds.iter().flat_map(|seed| *seed..*seed + u64::from(request.trials));
    seeds.collect::<Vec<_>>().into_par_iter().map(|seed| recording.run(fate, pairs, seed)).collect()
}

fn recordings(request: &Request) -> Result<Vec<Recording>> {
    let load = |place: &Path| Recording::load(place).with_context(|| place.display().to_string());
    if request.recordings.is_empty() {
        SETS.iter().map(|name| load(Path::new(name))).collect()
    } else {
        request.recordings.iter().map(|place| load(place)).collect()
    }
}

fn knocks(request: &Request) -> Result<Vec<Row>> {
    let recordings = recordings(request)?;
    let cases = recordings.iter().flat_map(|of| {
        let sizes = |axis| SIZES.iter().map(move |size| (axis, *size));
        let all = Axis::ALL.into_iter().flat_map(sizes);
        all.map(move |((axis, word), size)| (of, axis, size, format!("{}/{word} {size}", of.name)))
    });
    let cases: Vec<_> = cases.filter(|(.., case)| request.takes(case)).collect();
    let bar = progress::over(cases.len(), "knocks");
    let mut rows = Vec::new();
    for (of, axis, size, case) in cases {
        let runs = runs(of, Fate::Knock(axis, size), BEFORE + AFTER, request)?;
        rows.push(Row { case, figures: answered(&runs) });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Share of the knocks that are not missed, one curve an axis, over all recordings.
fn chart(rows: &[Row]) -> String {
    let of_axis = |(i, (_, word)): (usize, (Axis, &str))| {
        let share = |size: f64| {
            let of_size =
                || rows.iter().filter(|row| row.case.ends_with(&format!("/{word} {size}")));
            let sum =
                |name| of_size().filter_map(|row| row.figure(name)).map(|f| f.value).sum::<f64>();
            1.0 - sum("missed") / sum("runs")
        };
        let points = SIZES.iter().map(|size| (*size, Some(share(*size)))).collect();
        Curve { color: Some(palette::series(i)), line: Line::Thin, points }
    };
    let curves: Vec<Curve> = Axis::ALL.into_iter().enumerate().map(of_axis).collect();
    let entry =
        |(curve, (_, word)): (&Curve, (Axis, &str))| Entry::new(Mark::Line, curve.color, word);
    let legend: Vec<Entry> = curves.iter().zip(Axis::ALL).map(entry).collect();
    let x = Scale { name: "knock, degrees".into(), log: true };
    alone(&curves::shares("share of knocks answered within ten pairs", &x, &curves), &legend)
}

/// Figures of knocked runs.
fn answered(runs: &[Vec<Judged>]) -> Vec<Figure> {
    let after = || runs.iter().filter_map(|run| run.get(BEFORE..));
    let wrong = after().filter(|run| run.first().is_some_and(|judged| !judged.is_right())).count();
    let missed = |run: &&[Judged]| {
        run.get(PATIENCE - 1).is_some_and(|judged| judged.armed && !judged.is_right())
    };
    let alarms: Vec<f64> = after()
        .filter_map(|run| run.iter().position(|judged| !judged.armed))
        .map(|at| count(at + 1))
        .collect();
    let good = |judged: &Judged| judged.armed && judged.is_right();
    let recovered: Vec<f64> = after()
        .map(|run| run.iter().rposition(|judged| !good(judged)).map_or(0, |at| at + 1))
        .filter(|at| *at < AFTER)
        .map(|at| count(at + 1))
        .collect();
    let last = |part: usize| {
        let off = runs.iter().filter_map(|run| run.last()).map(|judged| judged.off[part]);
        quantile_of(["rows px", "depth px"][part], 0.5, off, runs.len())
    };
    vec![
        counted("runs", runs.len()),
        counted("wrong by it", wrong),
        counted("missed", after().filter(missed).count()),
        quantile_of("alarm after", 0.5, alarms.iter().copied(), runs.len()),
        quantile_of("alarm after at most", 1.0, alarms.iter().copied(), runs.len()),
        counted("recovered", recovered.len()),
        quantile_of("recovered after", 0.5, recovered.iter().copied(), runs.len()),
        quantile_of("recovered after at most", 1.0, recovered.iter().copied(), runs.len()),
        last(0),
        last(1),
    ]
}

fn rest(request: &Request) -> Result<Vec<Row>> {
    let fates = [("rest", Fate::Drift(0.0)), ("drift of 1e-5 rad a pair", Fate::Drift(DRIFT))];
    let recordings = recordings(request)?;
    let cases = recordings
        .iter()
        .flat_map(|of| fates.map(|(word, fate)| (of, fate, format!("{}/{word}", of.name))));
    let cases: Vec<_> = cases.filter(|(.., case)| request.takes(case)).collect();
    let bar = progress::over(cases.len(), "recordings");
    let mut rows = Vec::new();
    for (of, fate, case) in cases {
        let runs = runs(of, fate, REST, request)?;
        rows.push(Row { case, figures: at_rest(&runs) });
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Figures of runs without a knock, after their first [`BEFORE`] pairs.
fn at_rest(runs: &[Vec<Judged>]) -> Vec<Figure> {
    let settled = || runs.iter().filter_map(|run| run.get(BEFORE - 1..));
    let pairs: usize = settled().map(|run| run.len() - 1).sum();
    let begins = |two: &&[Judged]| two[0].armed && !two[1].armed && two[1].is_right();
    let alarms = settled().map(|run| run.windows(2).filter(begins).count()).sum();
    let wrong = settled().flatten().filter(|judged| judged.armed && !judged.is_right()).count();
    let applied = settled().flat_map(|run| &run[1..]).filter(|judged| judged.applied).count();
    let armed = settled().flat_map(|run| &run[1..]).filter(|judged| judged.armed).count();
    let an_hour = count(alarms) * HOUR / count(pairs);
    let chance = Chance::mean_count(an_hour * count(pairs) / HOUR, 1);
    vec![
        counted("pairs", pairs),
        Figure {
            chance: Chance::Share(count(pairs / RUN_OF_PAIRS)),
            ..shared("armed", [armed, pairs])
        },
        counted("false alarms", alarms),
        Figure { name: "false alarms an hour", value: an_hour, chance },
        counted("wrong and armed", wrong),
        counted("applied", applied),
    ]
}
