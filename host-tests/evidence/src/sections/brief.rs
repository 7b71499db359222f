//! The page in short: losses first, with each figure computed from the sections below.

use std::collections::BTreeMap;

use super::curves::rms;
use super::labels::{self, named};
use crate::findings::Findings;
use crate::on_recorded::{ErrorPair, Quantity};
use crate::rivals::{Tuning, Variant};
use crate::sweep::{Sweep, SweepAxis};
use crate::verdict::{self, OURS, Outcome, mean_ratio};
use page::report::{Cell, Section, Table};

type Judged<'a> = verdict::Cell<'a>;

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("In short, honestly");
    let [ours, rivals] = findings.sides();
    let cells = verdict::cells(findings.rows, &ours, &rivals);
    if cells.is_empty() {
        section.text(format!("Not judged: this needs {OURS} and a rival."));
        return section;
    }
    let count = |outcome| cells.iter().filter(|cell| cell.outcome == outcome).count();
    section.text(format!(
        "A rival may choose its method and settings anew in every cell, after seeing the result, which nobody \
         can do in use. Against this rival {OURS} loses {} of {} cells of the recordings, ties {} within the \
         error of the reference, and wins {}. A cell is a data set, a view and a quantity.",
        count(Outcome::Loss),
        cells.len(),
        count(Outcome::Tie),
        count(Outcome::Win),
    ));
    let command = findings.request.command.as_str();
    section.table(by_quantity(findings, &cells).explained(
        "Cells lost, tied and won, and the geometric mean of the rival's error over ours, above 1 where \
         ours is better: against the best of all methods and settings in each cell, and against the one method \
         with one setting that is best in that mean over all cells.",
        command,
    ));
    section.table(
        losses(findings, &cells).explained("Every lost cell, the widest margin first.", command),
    );
    section.text(unsolved(findings, &cells));
    let table = published(findings, &ours);
    if !table.rows.is_empty() {
        section.table(table.explained(
            "The method of the paper and ling-shen [7] over ours, as published and with preprocessing as in \
             use: geometric means over the cells of recordings with outliers. Order: cells in which robust <= \
             paper <= ling-shen, with all pairs fused.",
            command,
        ));
    }
    section.table(over_bounds(findings).explained(
        "Generated scenes: RMS error of robust over the least error that the true matches allow, which is 1 \
         within the chance of so many scenes; and that of the best rival, chosen anew in each row.",
        command,
    ));
    section
}

pub(super) fn by_quantity(findings: &Findings<'_>, cells: &[Judged<'_>]) -> Table {
    let heading = [
        "quantity",
        "lost",
        "tied",
        "won",
        "best rival over ours",
        "best single setting over ours",
        "that setting",
    ];
    let mut table = Table::new("in_short", heading.map(String::from));
    for quantity in Quantity::ALL {
        let of: Vec<&Judged<'_>> = cells.iter().filter(|c| c.quantity == quantity).collect();
        let count = |outcome| Cell::count(of.iter().filter(|c| c.outcome == outcome).count());
        let mut row = vec![Cell::text(quantity.name())];
        row.extend([Outcome::Loss, Outcome::Tie, Outcome::Win].map(count));
        row.push(ratio(mean_ratio(of.iter().copied())));
        match best_single(findings, quantity) {
            Some((by, mean)) => row.extend([Cell::number(mean, 2), Cell::text(named(by))]),
            None => row.extend([0; 2].map(|_| Cell::missing("-", "no rival has all cells"))),
        }
        table.push(row);
    }
    table
}

fn ratio(mean: Option<f64>) -> Cell {
    mean.map_or_else(|| Cell::missing("-", "no cell"), |mean| Cell::number(mean, 2))
}

/// The best rival over all cells with one setting, among those with an estimate in each cell.
fn best_single<'a>(findings: &Findings<'a>, quantity: Quantity) -> Option<(&'a Variant, f64)> {
    let [ours, rivals] = findings.sides();
    let all = verdict::cells(findings.rows, &ours, &rivals);
    let needed = all.iter().filter(|c| c.quantity == quantity).count();
    let mean = |&i: &usize| {
        let cells = verdict::cells(findings.rows, &ours, &[i]);
        let of: Vec<&Judged<'_>> = cells.iter().filter(|c| c.quantity == quantity).collect();
        let mean = mean_ratio(of.iter().copied()).filter(|_| of.len() == needed)?;
        Some((&findings.variants[i], mean))
    };
    rivals.iter().filter_map(mean).min_by(|(_, a), (_, b)| a.total_cmp(b))
}

fn losses(findings: &Findings<'_>, cells: &[Judged<'_>]) -> Table {
    let heading =
        ["data set, turned, view", "quantity", "ours", "rival", "ours over rival", "which"];
    let mut table = Table::new("losses", heading.map(String::from));
    let mut lost: Vec<&Judged<'_>> = cells.iter().filter(|c| c.outcome == Outcome::Loss).collect();
    lost.sort_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    for cell in lost {
        let ours = match cell.ours {
            ours if ours.is_finite() => Cell::number(ours, 4),
            _ => Cell::missing("none", "no estimate"),
        };
        table.push(vec![
            Cell::text(labels::cell(cell.row)),
            Cell::text(cell.quantity.name()),
            ours,
            Cell::number(cell.rival.1, 4),
            Cell::number(1.0 / cell.ratio(), 1),
            Cell::text(named(&findings.variants[cell.rival.0])),
        ]);
    }
    table
}

/// Cells in which doing nothing is better than ours, and better than all methods.
fn unsolved(findings: &Findings<'_>, cells: &[Judged<'_>]) -> String {
    let worse: Vec<&Judged<'_>> = cells.iter().filter(|c| c.still() < c.ours).collect();
    let by_all = worse.iter().filter(|c| c.still() < c.rival.1).count();
    let mut views = BTreeMap::<[&str; 2], Vec<String>>::new();
    for cell in &worse {
        let of = views.entry([cell.quantity.name(), cell.row.set.name.as_str()]).or_default();
        of.push(cell.row.seen.words());
    }
    let names = views
        .iter()
        .map(|([quantity, set], views)| format!("{quantity} of {set}: {}", views.join(", ")));
    let none = findings.sweeps.iter().flat_map(|sweep| unsolved_scenes(findings, sweep));
    let none: Vec<String> = none.collect();
    let list = |all: Vec<String>| if all.is_empty() { "none".into() } else { all.join("; ") };
    format!(
        "Cells in which doing nothing is better than ours: {}; in {by_all} of them it is better than every \
         method ({}). Generated scenes in which no method has an estimate in half of the trials: {}.",
        worse.len(),
        list(names.collect()),
        list(none),
    )
}

fn unsolved_scenes(findings: &Findings<'_>, sweep: &Sweep) -> Vec<String> {
    let solved =
        |at: usize| (0..findings.few.len()).any(|i| rms(&sweep.trials[i][at], 0).is_some());
    let numbered = sweep.values.iter().enumerate();
    let unsolved = numbered.filter(|(at, _)| !solved(*at));
    unsolved.map(|(_, value)| format!("{} {value}", sweep.axis.name())).collect()
}

/// Errors of `paper` and `ling-shen` over ours on the recordings with outliers, as geometric means: as published, with
/// the same gate, and with RANSAC in front. Counts the cells whose fused errors keep the order ours, `paper`,
/// `ling-shen`.
pub(super) fn published(findings: &Findings<'_>, ours: &[usize]) -> Table {
    let heading = [
        "settings",
        "paper over ours: e_t",
        "e_theta",
        "ling-shen [7] over ours: e_t",
        "e_theta",
        "order holds",
        "cells",
    ];
    let mut table = Table::new("published_methods", heading.map(String::from));
    let plain = Tuning::default();
    let gated = Tuning { gated: true, ..plain };
    let settings = [
        ("as published: paper with its gate, [7] without", plain, plain),
        ("the same gate", plain, gated),
        (
            "RANSAC in front, the same gate",
            Tuning { prefiltered: true, ..plain },
            Tuning { prefiltered: true, ..gated },
        ),
    ];
    for (words, paper, other) in settings {
        let place = |method: &str, tuning: Tuning| {
            let at = |by: &Variant| by.method.name() == method && by.tuning == tuning;
            findings.variants.iter().position(at)
        };
        let Some((paper, other)) = place("paper", paper).zip(place("ling-shen", other)) else {
            continue;
        };
        let [paper, other] = [paper, other].map(|i| with_outliers(findings, ours, i));
        let of = |cells: &[Judged<'_>], quantity| {
            ratio(mean_ratio(cells.iter().filter(|c| c.quantity == quantity)))
        };
        let fused =
            |c: &&Judged<'_>| [Quantity::ErrorT, Quantity::ErrorTheta].contains(&c.quantity);
        let pairs = paper.iter().filter(fused).zip(other.iter().filter(fused));
        let holds = pairs.filter(|(a, b)| a.ours <= a.rival.1 && a.rival.1 <= b.rival.1).count();
        table.push(vec![
            Cell::text(words),
            of(&paper, Quantity::ErrorT),
            of(&paper, Quantity::ErrorTheta),
            of(&other, Quantity::ErrorT),
            of(&other, Quantity::ErrorTheta),
            Cell::count(holds),
            Cell::count(paper.iter().filter(fused).count()),
        ]);
    }
    table
}

/// Cells of the recordings with outliers, against one method with one setting.
fn with_outliers<'a>(findings: &Findings<'a>, ours: &[usize], rival: usize) -> Vec<Judged<'a>> {
    let all = verdict::cells(findings.rows, ours, &[rival]);
    all.into_iter().filter(|c| c.row.set.outliers > FEW_OUTLIERS).collect()
}

/// Share of outliers below which a recording counts as one without outliers.
const FEW_OUTLIERS: f64 = 0.01;

pub(super) fn over_bounds(findings: &Findings<'_>) -> Table {
    let heading = ["scenes", "ours: e_t", "e_theta", "best rival: e_t", "e_theta", "which in e_t"];
    let mut table = Table::new("over_bound", heading.map(String::from));
    let lines = [
        (SweepAxis::Matches, 16.0, "one pair of 16 matches, no outliers"),
        (SweepAxis::Matches, 64.0, "one pair of 64 matches, no outliers"),
        (SweepAxis::Outliers, 0.0, "one pair of 256 matches, no outliers"),
        (SweepAxis::Outliers, 0.3, "one pair, 30 % outliers"),
        (SweepAxis::Outliers, 0.5, "one pair, 50 % outliers"),
        (SweepAxis::Outliers, 0.6, "one pair, 60 % outliers"),
        (SweepAxis::Noise, 2.0, "one pair, no outliers, 2 px of noise"),
        (SweepAxis::Depth, 30.0, "one pair, 10 % outliers, points 30 to 300 baselines away"),
        (SweepAxis::Depth, 300.0, "one pair, 10 % outliers, points 300 to 3,000 baselines away"),
        (SweepAxis::Pairs, 100.0, "100 pairs fused, 10 % outliers"),
    ];
    for (axis, value, words) in lines {
        let Some([ours, best]) = over_bound(findings, axis, value) else { continue };
        let cell = |of: &Option<(usize, ErrorPair)>, part: usize| match of {
            Some((_, errors)) => Cell::number(errors[part], 2),
            None => Cell::missing("none", "an estimate in fewer than half of the scenes"),
        };
        let which = best.map_or_else(String::new, |(i, _)| named(&findings.few[i]));
        table.push(vec![
            Cell::text(words),
            cell(&ours, 0),
            cell(&ours, 1),
            cell(&best, 0),
            cell(&best, 1),
            Cell::text(which),
        ]);
    }
    table
}

/// Errors of ours, and of the rival with the least `e_t`, over the bound.
fn over_bound(
    findings: &Findings<'_>,
    axis: SweepAxis,
    value: f64,
) -> Option<[Option<(usize, ErrorPair)>; 2]> {
    let sweep: &Sweep = findings.sweeps.iter().find(|sweep| sweep.axis == axis)?;
    let at = sweep.values.iter().position(|x| x.total_cmp(&value).is_eq())?;
    let [t, theta] = *sweep.bound[at].as_ref().ok()?;
    let of = |&i: &usize| {
        let trials = &sweep.trials[i][at];
        let errors = [rms(trials, 0)? / t, rms(trials, 1)? / theta];
        Some((i, errors))
    };
    let [ours, rivals] = [verdict::of_method(findings.few, OURS), verdict::rivals(findings.few)];
    let least = |among: &[usize]| {
        among.iter().filter_map(of).min_by(|(_, [a, _]), (_, [b, _])| a.total_cmp(b))
    };
    Some([least(&ours), least(&rivals)])
}
