//! Tables I and II of the paper, in its layout: one table a data set, `e_t` and `e_theta` of each view.

use super::labels::named;
use super::published::comparable;
use crate::findings::Findings;
use crate::on_recorded::{Quantity, Row, error_pair};
use crate::recorded_sets::TURN_DEG;
use crate::rivals::{Tuning, Variant};
use crate::verdict;
use page::report::{Cell, Section, Table};

const FUSED: [Quantity; 2] = [Quantity::ErrorT, Quantity::ErrorTheta];

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("Tables I and II of the paper, by data set");
    section.text(format!(
        "e_t / e_theta in rad, all pairs fused. Each recording unchanged (middle) and turned by {TURN_DEG} \
         degrees up, down, left and right: the left image, the right one, or both, the right one by the next \
         of top, right, bottom, left. The paper does not say which image of the public sets it turns; its \
         authors' script reads a turned right image. A turn of the left image leaves t unchanged, and so does \
         a turn of the right one about the baseline. A figure is grey, and not counted, if the truth differs \
         from the start by no more than the reference's error.",
    ));
    section.text(
        "The last columns are the paper's figures for Middlebury 2021 (or KITTI 2015, for a set of that name). \
         Its scenes and matches differ from ours, and it has several pairs where ours has one, so only the \
         order of magnitude compares.",
    );
    for set in findings.sets {
        let rows: Vec<&Row<'_>> =
            findings.rows.iter().filter(|row| row.set.digest == set.digest).collect();
        let caption = format!(
            "{}. Paper and [7]: with the gate of the paper, and with RANSAC in front as well. Best rival: the \
             best method and settings for that figure of that row.",
            set.name
        );
        section.table(table(findings, &rows).explained(caption, &findings.request.command));
    }
    section
}

/// Columns of one method each, with their settings.
fn columns(findings: &Findings<'_>) -> Vec<(&'static str, Vec<usize>)> {
    let plain = Tuning::default();
    let prefiltered = Tuning { prefiltered: true, ..plain };
    let place = |method: &str, tuning: Tuning| -> Vec<usize> {
        let at = |by: &Variant| by.method.name() == method && by.tuning == tuning;
        findings.variants.iter().position(at).into_iter().collect()
    };
    let gated = |tuning| Tuning { gated: true, ..tuning };
    vec![
        ("robust (ours)", place("robust", plain)),
        ("paper", place("paper", plain)),
        ("paper + RANSAC", place("paper", prefiltered)),
        ("ling-shen [7]", place("ling-shen", gated(plain))),
        ("ling-shen [7] + RANSAC", place("ling-shen", gated(prefiltered))),
        ("best rival", verdict::rivals(findings.variants)),
    ]
}

fn table(findings: &Findings<'_>, rows: &[&Row<'_>]) -> Table {
    let columns: Vec<_> =
        columns(findings).into_iter().filter(|(_, among)| !among.is_empty()).collect();
    let name = rows.first().map_or("", |row| row.set.name.as_str());
    let published = rows.iter().any(|row| comparable(name, row.seen.view).is_some());
    let mut heading = vec!["turned, view".to_owned(), "do nothing e_t".into(), "e_theta".into()];
    for (name, _) in &columns {
        heading.extend([format!("{name} e_t"), "e_theta".into()]);
    }
    if published {
        let reported =
            ["ling-shen [7], reported: e_t", "e_theta", "paper, reported: e_t", "e_theta"];
        heading.extend(reported.map(String::from));
    }
    let digest = rows.first().map_or("", |row| &row.set.digest);
    let place = findings.sets.iter().position(|set| set.digest == digest).unwrap_or_default();
    let mut table = Table::new(&format!("table_{}_{name}", place + 1), heading);
    for row in rows {
        let mut cells = row_of(findings, row, &columns);
        if published {
            match comparable(name, row.seen.view) {
                Some(reported) => {
                    cells.extend(reported.concat().iter().map(|e| Cell::number(*e, 4)));
                }
                None => cells.extend([0; 4].map(|_| Cell::missing("", "not reported"))),
            }
        }
        table.push(cells);
    }
    table
}

fn row_of(findings: &Findings<'_>, row: &Row<'_>, columns: &[(&str, Vec<usize>)]) -> Vec<Cell> {
    let counts = row.seen.is_evidence(row.set.reference);
    let shown = |value: f64, part: usize| {
        let cell = Cell::number(value, 4);
        if counts[part] {
            cell
        } else {
            cell.faint().with_hint("no evidence: the start is the truth")
        }
    };
    let seen = row.seen;
    let words = row.seen.words();
    let still = error_pair(seen.still());
    let mut cells = vec![Cell::text(words), shown(still[0], 0), shown(still[1], 1)];
    for (_, among) in columns {
        cells.extend(FUSED.map(|quantity| match row.least(quantity, among) {
            Some((i, value)) if counts[quantity.part()] => {
                shown(value, quantity.part()).with_hint(named(&findings.variants[i]))
            }
            Some((_, value)) => shown(value, quantity.part()),
            None => Cell::missing("none", "no estimate"),
        }));
    }
    cells
}
