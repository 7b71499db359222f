//! The run pair by pair: states, row offsets, errors and reported standard deviations.

use super::Replayed;
use super::states;
use crate::chart::curves::{Curve, Line, Scale, curves};
use crate::chart::palette::{Color, SERIES};
use crate::report::{Cell, Csv, Entry, Figure, Mark, Picture, Section, Table};
use sim::run::{Reference, Solved, Step};

pub(super) fn section(replayed: &Replayed<'_>, reference: Reference) -> Section {
    let steps = replayed.log.steps();
    let mut section = Section::new("Pair by pair");
    let mut states_csv = Csv::new("states", &["pair", "state", "outcome"]);
    for (i, step) in steps.iter().enumerate() {
        let state = step.estimate.map(|e| e.to_string()).unwrap_or_default();
        states_csv.push([i.to_string(), state, step.verdict.to_string()]);
    }
    section.figure(Figure {
        panels: vec![(Picture::Svg(states::strip(steps)), "state after each pair".into())],
        legend: states::legend(),
        caption: "State of the calibrator after each pair. A cross: the pair was not fused.".into(),
        command: replayed.command.to_owned(),
        numbers: states_csv,
    });
    section.figure(rows_and_errors(replayed, steps, reference));
    section.table(table(replayed, steps));
    section
}

/// One series over the pairs.
struct Series {
    name: &'static str,
    color: Option<Color>,
    line: Line,
    of: fn(&Step) -> Option<f64>,
}

/// * `color`: number of the colour in [`SERIES`].
const fn series(
    name: &'static str,
    color: usize,
    line: Line,
    of: fn(&Step) -> Option<f64>,
) -> Series {
    Series { name, color: Some(SERIES[color]), line, of }
}

#[rustfmt::skip]
const OFFSETS: [Series; 2] = [
    series("row offset before, RMS, px", 7, Line::Thin, |step| step.solved.map(|s| s.rms_px_before)),
    series("row offset after, RMS, px", 2, Line::Broad, |step| step.solved.map(|s| s.rms_px_after)),
];

#[rustfmt::skip]
const ERRORS: [Series; 4] = [
    series("e_t of the estimate, mrad", 0, Line::Broad, |step| step.running.map(|e| 1e3 * e.translation)),
    series("sd of t, reported, mrad", 0, Line::Broken, |step| step.estimate.map(|e| 1e3 * e.sd.translation)),
    series("e_theta of the estimate, mrad", 1, Line::Broad, |step| step.running.map(|e| 1e3 * e.rotation)),
    series("sd of R, reported, mrad", 1, Line::Broken, |step| step.estimate.map(|e| 1e3 * e.sd.rotation)),
];

fn rows_and_errors(replayed: &Replayed<'_>, steps: &[Step], reference: Reference) -> Figure {
    let count = |i: usize| u32::try_from(i + 1).map_or(f64::NAN, f64::from);
    let drawn = |title: &str, series: &[Series]| {
        let curve = |series: &Series| Curve {
            color: series.color,
            line: series.line,
            points: steps.iter().enumerate().map(|(i, s)| (count(i), (series.of)(s))).collect(),
        };
        let all: Vec<Curve> = series.iter().map(curve).collect();
        curves(title, &Scale { name: "pairs so far".into(), log: false }, &all)
    };
    let all = || OFFSETS.iter().chain(&ERRORS);
    let heading: Vec<&str> = ["pair"].into_iter().chain(all().map(|series| series.name)).collect();
    let mut numbers = Csv::new("health", &heading);
    for (i, step) in steps.iter().enumerate() {
        let values = all().map(|series| (series.of)(step).map_or(String::new(), |x| x.to_string()));
        numbers.push([i.to_string()].into_iter().chain(values));
    }
    let entry = |series: &Series| {
        let mark = if series.line == Line::Broken { Mark::Dashes } else { Mark::Line };
        Entry::new(mark, series.color, series.name)
    };
    Figure {
        panels: vec![
            (Picture::Svg(drawn("row offset, px", &OFFSETS)), "row offsets of each pair".into()),
            (
                Picture::Svg(drawn("e_t, e_theta and reported sd, mrad", &ERRORS)),
                "errors and reported standard deviations".into(),
            ),
        ],
        legend: all().map(entry).collect(),
        caption: format!(
            "Left: row offsets of the fitting matches of each pair; before: with the estimate from the earlier \
             pairs, for the first pair with the start; after: with the solution of this pair. Right: distance of \
             the running estimate {}, and its reported standard deviation.",
            reference.words(),
        ),
        command: replayed.command.to_owned(),
        numbers,
    }
}

fn table(replayed: &Replayed<'_>, steps: &[Step]) -> Table {
    let heading = [
        "pair",
        "matches",
        "offered",
        "rows before, px",
        "rows after, px",
        "passes",
        "pair alone: e_t, mrad",
        "pair alone: e_theta, mrad",
        "running e_t, mrad",
        "running e_theta, mrad",
        "sd t, mrad",
        "sd R, mrad",
        "state",
        "outcome",
    ];
    let mut table = Table::new("pairs", heading.map(Into::into));
    for (i, step) in steps.iter().enumerate() {
        let number = |value: Option<f64>, decimals| Cell::known(value, decimals, "not solved");
        let solved = |of: fn(&Solved) -> f64| number(step.solved.as_ref().map(of), 3);
        let estimate = step.estimate.as_ref();
        table.push(vec![
            Cell::count(i),
            Cell::count(step.taken),
            Cell::count(step.offered),
            solved(|s| s.rms_px_before),
            solved(|s| s.rms_px_after),
            number(step.solved.map(|s| f64::from(s.passes)), 0),
            number(step.pair_error().map(|e| 1e3 * e.translation), 3),
            number(step.pair_error().map(|e| 1e3 * e.rotation), 3),
            number(step.running.map(|e| 1e3 * e.translation), 3),
            number(step.running.map(|e| 1e3 * e.rotation), 3),
            number(estimate.map(|e| 1e3 * e.sd.translation), 3),
            number(estimate.map(|e| 1e3 * e.sd.rotation), 3),
            Cell::text(estimate.map(ToString::to_string).unwrap_or_default()),
            Cell::text(step.verdict.to_string()),
        ]);
    }
    table.explained(
        "Every pair: its matches, rows and passes in the run, its errors when solved alone, and the running \
         estimate after it.",
        replayed.command,
    )
}
