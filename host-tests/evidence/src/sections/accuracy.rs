//! All methods at their best settings, cell by cell, and the errors of single pairs.

use super::labels::{self, label};
use crate::findings::Findings;
use crate::on_recorded::{ErrorPair, Errors, Quantity, Row, error_pair};
use crate::verdict::{self, OURS};
use page::chart::curves::{self, Bars};
use page::report::{Cell, Csv, Entry, Figure, Mark, Picture, Section, Table};

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("Every method at its best, cell by cell");
    section.text(
        "Each method with its best settings in that cell; the pointer over a number shows them. The CSV file \
         of the figure below has all settings of all methods. Figures without evidence are grey and not \
         counted.",
    );
    let command = findings.request.command.as_str();
    for quantity in Quantity::ALL {
        let caption = match quantity {
            Quantity::ErrorT | Quantity::ErrorTheta => format!(
                "{}, rad, of all pairs fused. The best of a row is marked; so are others, if both are below \
                 the reference's standard error.",
                quantity.name()
            ),
            Quantity::SigmaT | Quantity::SigmaTheta => format!(
                "{}, rad: RMS error of fresh single pairs, for methods that solve at least half of them.",
                quantity.name()
            ),
        };
        section.table(table(findings, quantity).explained(caption, command));
    }
    section.figure(spread(findings));
    section
}

fn table(findings: &Findings<'_>, quantity: Quantity) -> Table {
    let mut columns = vec!["data set, turned, view".to_owned(), "do nothing".into()];
    columns.extend(findings.methods.iter().map(|by| label(by.name())));
    columns.push("reference sd".to_owned());
    let mut table = Table::new(quantity.name(), columns);
    for row in findings.rows {
        table.push(cells(findings, row, quantity));
    }
    table
}

fn cells(findings: &Findings<'_>, row: &Row<'_>, quantity: Quantity) -> Vec<Cell> {
    let part = quantity.part();
    let least: Vec<Option<(usize, f64)>> = findings
        .methods
        .iter()
        .map(|by| row.least(quantity, &verdict::of_method(findings.variants, by.name())))
        .collect();
    let best = least.iter().flatten().map(|(_, e)| *e).fold(f64::INFINITY, f64::min);
    let sd = row.set.reference.map(|sd| [sd.translation, sd.rotation][part]);
    // Differences below the error of the reference do not count.
    let best = best.max(sd.unwrap_or(0.0));
    let evidence = row.seen.is_evidence(row.set.reference)[part];
    let shown = |error: f64| {
        let cell = Cell::number(error, 4);
        match (evidence, error <= best) {
            (false, _) => cell.faint(),
            (true, true) => cell.best(),
            (true, false) => cell,
        }
    };
    let mut cells = vec![Cell::text(labels::cell(row)), shown(error_pair(row.seen.still())[part])];
    cells.extend(least.iter().map(|least| match least {
        Some((i, error)) => shown(*error).with_hint(findings.variants[*i].tuning.words()),
        None => Cell::missing("none", "no estimate, or fewer than half of the pairs"),
    }));
    cells.push(match sd {
        Some(sd) => Cell::number(sd, 4).faint(),
        None => Cell::missing("", "not known"),
    });
    cells
}

/// All measurements on the recordings.
fn numbers(findings: &Findings<'_>) -> Csv {
    let heading = [
        "data set",
        "turned",
        "view",
        "method",
        "settings",
        "e_t, rad",
        "e_theta, rad",
        "sigma_t, rad",
        "sigma_theta, rad",
        "pairs solved",
        "pairs",
    ];
    let mut numbers = Csv::new("recorded", &heading);
    for row in findings.rows {
        for (by, errors) in findings.variants.iter().zip(&row.errors) {
            let errors = errors.as_ref().ok();
            let text = |pair: Option<ErrorPair>, part: usize| {
                pair.map_or(String::new(), |pair: ErrorPair| pair[part].to_string())
            };
            let fused = errors.map(|errors| errors.fused);
            let sigma = errors.and_then(Errors::sigma);
            let mut line = vec![
                row.set.name.clone(),
                row.seen.camera.to_owned(),
                row.seen.view.to_owned(),
                by.method.name().to_owned(),
                by.tuning.words(),
            ];
            line.extend([fused, sigma].iter().flat_map(|pair| [text(*pair, 0), text(*pair, 1)]));
            line.push(errors.map_or(0, Errors::solved).to_string());
            line.push(row.seen.pairs.len().to_string());
            numbers.push(line);
        }
    }
    numbers
}

/// Bars of `sigma_t` and `sigma_theta` of ours, the best rival, and the paper.
fn spread(findings: &Findings<'_>) -> Figure {
    let names = ["robust (ours)", "best rival", "paper, RANSAC in front or not"];
    let legend = names.iter().enumerate();
    let legend = legend.map(|(i, name)| Entry::new(Mark::Bars, Some(curves::shade(i)), name));
    Figure {
        panels: findings.sets.iter().flat_map(|set| panels(findings, &set.name)).collect(),
        legend: legend.collect(),
        caption: "Errors of fresh single pairs, root mean square, with the left image turned; a cross if fewer \
                  than half of the pairs have an estimate. For a recording of one pair its error replaces the \
                  mean. The form follows figures 2 and 3 of the paper. The CSV file has every method with \
                  every setting, in every view."
            .into(),
        command: findings.request.command.clone(),
        numbers: numbers(findings),
    }
}

/// Both errors of one data set.
fn panels(findings: &Findings<'_>, set: &str) -> Vec<(Picture, String)> {
    let of_set = |row: &&Row<'_>| row.set.name == set && row.seen.camera != "right";
    let rows: Vec<&Row<'_>> =
        findings.rows.iter().filter(of_set).filter(|row| row.seen.camera != "both").collect();
    let Some(first) = rows.first() else { return Vec::new() };
    let sides = [
        verdict::of_method(findings.variants, OURS),
        verdict::rivals(findings.variants),
        verdict::of_method(findings.variants, "paper"),
    ];
    let views: Vec<&str> = rows.iter().map(|row| row.seen.view).collect();
    let panel = |quantity: Quantity| {
        let series = sides.iter().enumerate().map(|(i, among)| Bars {
            color: curves::shade(i),
            heights: rows.iter().map(|row| Some(row.least(quantity, among)?.1)).collect(),
        });
        let title = format!("{}: {}, rad", first.set.name, quantity.name());
        let svg = curves::bars(&title, &views, &series.collect::<Vec<_>>());
        (Picture::Svg(svg), title)
    };
    [Quantity::SigmaT, Quantity::SigmaTheta].map(panel).to_vec()
}
