//! Tables I and II and figures 2 and 3 of the paper, in form.

use super::labels::label;
use crate::chart::curves::{self, Bars};
use crate::evidence::findings::Findings;
use crate::evidence::measurement::Measured;
use crate::evidence::on_recorded::{ErrorPair, Errors, Row};
use crate::evidence::recorded_sets::TURN_DEG;
use crate::evidence::report::{Cell, Csv, Entry, Figure, Picture, Sample, Section, Table};

const PARTS: [&str; 2] = ["t", "theta"];

pub(super) fn section(findings: &Findings<'_>) -> Section {
    let mut section = Section::new("Accuracy on recorded data");
    section.text(format!(
        "Each recording is used unchanged (middle) and with the left image turned by {TURN_DEG} degrees up, \
         down, left and right, as in tables I and II of the paper. A rectified recording is true to the \
         start: its middle view is no evidence, shown faint and counted nowhere.",
    ));
    let command = findings.request.command.as_str();
    for (part, name) in PARTS.iter().enumerate() {
        let caption = format!(
            "e_{name}, rad, of all pairs fused; the best of a row is marked, with what \
             is, like it, below the reference's standard error. Last columns: the joint \
             maximum-likelihood fit of the matches within 2 px of the reference's rows, which is how far \
             the data themselves are from the reference, and the reference's standard error. Table {} \
             of the paper in form.",
            ["I", "II"][part],
        );
        section.table(fused(findings, part).explained(caption, command));
    }
    section.figure(spread(findings));
    section
}

fn fused(findings: &Findings<'_>, part: usize) -> Table {
    let mut heading = vec!["data set".to_owned(), "view".to_owned()];
    heading.extend(findings.methods.iter().map(|by| label(by.name())));
    heading.extend(["data's own".to_owned(), "reference sd".to_owned()]);
    let mut table = Table::new(&format!("e_{}", PARTS[part]), heading);
    for row in findings.rows {
        table.push(cells(row, part));
    }
    table
}

fn cells(row: &Row<'_>, part: usize) -> Vec<Cell> {
    let errors: Vec<Measured<f64>> =
        row.errors.iter().map(|errors| value(errors, |errors| errors.fused[part])).collect();
    let best = errors.iter().flatten().copied().fold(f64::INFINITY, f64::min);
    let sd = row.set.reference.map(|sd| [sd.translation, sd.rotation][part]);
    // Below the error of the reference nothing is better than anything.
    let best = best.max(sd.unwrap_or(0.0));
    let evidence = row.seen.is_evidence();
    let cell = |error: &Measured<f64>| match error {
        Err(why) => Cell::missing("failed", why),
        Ok(error) if !evidence => {
            Cell::number(*error, 4).faint().with_hint("no evidence: the start is the truth")
        }
        Ok(error) if *error <= best => Cell::number(*error, 4).best(),
        Ok(error) => Cell::number(*error, 4),
    };
    let mut cells = vec![Cell::text(row.set.name.as_str()), Cell::text(row.seen.view)];
    cells.extend(errors.iter().map(cell));
    cells.push(match &row.data_optimum {
        Ok(errors) => Cell::number(errors[part], 4).faint(),
        Err(why) => Cell::missing("failed", why),
    });
    cells.push(match sd {
        Some(sd) => Cell::number(sd, 4).faint(),
        None => Cell::missing("", "not known"),
    });
    cells
}

fn value<T>(measured: &Measured<Errors>, of: impl Fn(&Errors) -> T) -> Measured<T> {
    measured.as_ref().map(of).map_err(Clone::clone)
}

/// Bars of `sigma_t` and `sigma_theta`.
fn spread(findings: &Findings<'_>) -> Figure {
    let names: Vec<&str> = findings.methods.iter().map(|by| by.name()).collect();
    let legend =
        names.iter().map(|name| Entry::new(Sample::Bar, Some(findings.color(name)), &label(name)));
    let heading =
        ["data set", "view", "method", "sigma_t, rad", "sigma_theta, rad", "pairs solved", "pairs"];
    let mut numbers = Csv::new("sigma", &heading);
    for row in findings.rows {
        for (name, errors) in names.iter().zip(&row.errors) {
            let solved = value(errors, |errors| errors.single.iter().flatten().count());
            let sigma = value(errors, Errors::sigma).ok().flatten();
            let text =
                |part: usize| sigma.map_or(String::new(), |s: ErrorPair| s[part].to_string());
            numbers.push([
                row.set.name.clone(),
                row.seen.view.to_owned(),
                (*name).to_owned(),
                text(0),
                text(1),
                solved.unwrap_or(0).to_string(),
                row.seen.pairs.len().to_string(),
            ]);
        }
    }
    Figure {
        panels: findings.sets.iter().flat_map(|set| panels(findings, &set.digest)).collect(),
        legend: legend.collect(),
        caption: "Errors of single pairs, root mean square over those that a method solved, by view. A \
                  recording of one pair has its error in place of a mean; a cross is a method without an estimate. Views that are no evidence are \
                  left out. Figures 2 and 3 of the paper in form."
            .into(),
        command: findings.request.command.clone(),
        numbers,
    }
}

/// Both errors of one data set.
fn panels(findings: &Findings<'_>, digest: &str) -> Vec<(Picture, String)> {
    let rows: Vec<&Row<'_>> = findings
        .rows
        .iter()
        .filter(|row| row.set.digest == digest && row.seen.is_evidence())
        .collect();
    let views: Vec<&str> = rows.iter().map(|row| row.seen.view).collect();
    let Some(first) = rows.first() else { return Vec::new() };
    let panel = |(part, name): (usize, &&str)| {
        let series = findings.methods.iter().enumerate().map(|(i, by)| Bars {
            color: findings.color(by.name()),
            heights: rows
                .iter()
                .map(|row| Some(row.errors[i].as_ref().ok()?.sigma()?[part]))
                .collect(),
        });
        let title = format!("{}: sigma_{name}, rad", first.set.name);
        let series: Vec<Bars> = series.collect();
        let svg = curves::bars(&title, &views, &series);
        (Picture::Svg(svg), title)
    };
    PARTS.iter().enumerate().map(panel).collect()
}
