//! The running estimates of a rig that is knocked once.

use super::labels::named;
use crate::findings::Findings;
use crate::rivals::Variant;
use crate::step_response::{PAIRS, StepResponse, TURN_DEG};
use crate::verdict::OURS;
use page::chart::curves::{self, Curve, Line, Scale};
use page::report::{Cell, Csv, Entry, Figure, Mark, Picture, Section, Table};
use sim::stats::geometric_mean;

/// The first pair of the turned rig.
const FIRST: usize = PAIRS / 2;

/// Pairs since the knock whose errors are in the table; 0 is the pair before it.
const AFTER: [usize; 4] = [0, 1, 3, 10];

const PARTS: [&str; 2] = ["e_t", "e_theta"];

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("After a knock");
    section.text(format!(
        "The right camera turns by {TURN_DEG} degrees about a random axis at pair {FIRST} of {PAIRS}, with 10 % \
         outliers. A mean over all pairs keeps the old rig. A steady filter (process noise 1e-5 rad a pair) \
         forgets it slowly; an agile one (1e-3 rad) follows within a pair or two, and pays with the error \
         between knocks, which is the first column. The robust preset detects the change and restarts.",
    ));
    let command = findings.request.command.as_str();
    section.table(table(findings).explained(
        "e_t, rad, before the knock and so many pairs after it, of every method and setting, root mean square \
         over the runs. The best of a column is marked.",
        command,
    ));
    section.figure(figure(findings));
    section
}

fn at(response: &StepResponse, after: usize) -> Option<f64> {
    response.get((FIRST + after).checked_sub(1)?).copied().flatten().map(|[t, _]| t)
}

fn table(findings: &Findings<'_>) -> Table {
    let all = findings.step_responses.iter();
    rows("after_a_knock", all.map(|(by, response)| (named(by), response)).collect())
}

/// The rows of the methods that are drawn.
pub(super) fn drawn_rows(findings: &Findings<'_>) -> Table {
    rows("after_a_knock", drawn(findings))
}

fn rows(name: &str, responses: Vec<(String, &StepResponse)>) -> Table {
    let heading = ["method, settings", "before", "after 1 pair", "after 3", "after 10"];
    let mut table = Table::new(name, heading.map(String::from));
    let best = AFTER.map(|after| {
        let all = responses.iter().filter_map(|(_, response)| at(response, after));
        all.fold(f64::INFINITY, f64::min)
    });
    for (name, response) in responses {
        let cell = |(after, best): (usize, f64)| match at(response, after) {
            Some(e) if e <= best => Cell::number(e, 5).best(),
            Some(e) => Cell::number(e, 5),
            None => Cell::missing("none", "an estimate in fewer than half of the runs"),
        };
        let mut row = vec![Cell::text(name)];
        row.extend(AFTER.into_iter().zip(best).map(cell));
        table.push(row);
    }
    table
}

/// Ours, and the best rival without and the best with agile process noise, over the whole run.
fn drawn<'a>(findings: &'a Findings<'_>) -> Vec<(String, &'a StepResponse)> {
    let mean = |response: &StepResponse| {
        let errors = response.iter().flatten().map(|[t, _]| *t);
        geometric_mean(errors).unwrap_or(f64::INFINITY)
    };
    let responses = || findings.step_responses.iter();
    let best = |which: &dyn Fn(&Variant) -> bool| {
        let all = responses().filter(|(by, response)| which(by) && mean(response).is_finite());
        all.min_by(|(_, a), (_, b)| mean(a).total_cmp(&mean(b)))
    };
    let ours = best(&|by| by.method.name() == OURS);
    let others = [false, true]
        .map(|agile| best(&|by: &Variant| by.method.name() != OURS && by.tuning.agile == agile));
    let all = ours.into_iter().chain(others.into_iter().flatten());
    all.map(|(by, response)| (named(by), response)).collect()
}

/// The chart of an error, and its legend.
pub(super) fn chart(findings: &Findings<'_>, part: usize) -> (String, Vec<Entry>) {
    let drawn = drawn(findings);
    let curve = |(i, (_, response)): (usize, &(String, &StepResponse))| {
        let errors = response.iter().map(|errors| errors.map(|errors| errors[part]));
        let points = (0_u32..).map(f64::from).zip(errors).collect();
        let line = if i == 0 { Line::Broad } else { Line::Thin };
        Curve { color: Some(curves::shade(i)), line, points }
    };
    // Ours is drawn last, on top.
    let all: Vec<Curve> = drawn.iter().enumerate().map(curve).rev().collect();
    let x = Scale { name: "pair".into(), log: false };
    let entry = |(i, (name, _)): (usize, &(String, _))| {
        Entry::new(Mark::Line, Some(curves::shade(i)), name)
    };
    let svg = curves::curves(&format!("{}, rad", PARTS[part]), &x, &all);
    (svg, drawn.iter().enumerate().map(entry).collect())
}

fn figure(findings: &Findings<'_>) -> Figure {
    let panel = |part: usize| {
        (Picture::Svg(chart(findings, part).0), format!("{}, rad over pairs", PARTS[part]))
    };
    let mut numbers = Csv::new("step", &["pair", "method", "e_t, rad", "e_theta, rad"]);
    for (by, response) in &findings.step_responses {
        for (pair, error) in response.iter().enumerate() {
            let text = |part: usize| error.map_or(String::new(), |e| e[part].to_string());
            numbers.push([pair.to_string(), by.name(), text(0), text(1)]);
        }
    }
    Figure {
        panels: [0, 1].map(panel).into(),
        legend: chart(findings, 0).1,
        caption: format!(
            "Error of the running estimate after each pair, root mean square over {} runs: ours, the rival that \
             is best without and the one that is best with agile process noise.",
            findings.request.effort.steps
        ),
        command: findings.request.command.clone(),
        numbers,
    }
}
