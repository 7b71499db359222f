//! Tables and curves of EVIDENCE.md, of an evaluation.

use std::path::Path;

use anyhow::Result;
use page::chart::Svg;
use page::chart::legend::Key;
use page::chart::palette::Rgb;
use page::report::{Entry, Table};

use super::{brief, curves, drift, knock};
use crate::campaigns;
use crate::findings::Findings;
use crate::sweep::SweepAxis;
use crate::verdict;

/// Size of a chart, and the height of its legend, px.
const CHART: [f64; 2] = [480.0, 330.0];
const LEGEND: f64 = 18.0;

/// Writes tables, each below the words of its page, and curves.
///
/// # Errors
/// If a file cannot be written.
pub(crate) fn write(findings: &Findings<'_>, dir: &Path) -> Result<()> {
    let [ours, rivals] = findings.sides();
    let cells = verdict::cells(findings.rows, &ours, &rivals);
    let tables = [
        ("cells", brief::by_quantity(findings, &cells)),
        ("published", brief::published(findings, &ours)),
        ("over-bound", brief::over_bounds(findings)),
        ("knock", knock::drawn_rows(findings)),
        ("drift-rivals", drift::of_each_method(findings)),
    ];
    for (name, table) in tables {
        write_table(&table, name, dir)?;
    }
    let axes = [SweepAxis::Outliers, SweepAxis::Matches, SweepAxis::Noise];
    let of_axis = |axis: SweepAxis| Some((axis.name(), curves::of_document(findings, axis)?));
    let charts = axes.into_iter().filter_map(of_axis);
    for (name, (svg, legend)) in charts.chain([("knock", knock::chart(findings, 0))]) {
        page::write(&dir.join(format!("{name}.svg")), &alone(&svg, &legend))?;
    }
    Ok(())
}

fn write_table(table: &Table, name: &str, dir: &Path) -> Result<()> {
    let shown =
        table.rows.iter().map(|row| row.iter().map(|cell| cell.shown().to_owned()).collect());
    let lines = [table.heading.clone()].into_iter().chain(shown);
    campaigns::Table::of_lines(lines.collect()).write(name, dir)
}

/// A chart with its legend, on white.
pub(crate) fn alone(chart: &str, legend: &[Entry]) -> String {
    let [width, height] = CHART;
    let rows: Vec<f64> =
        legend.iter().zip(0_u32..).map(|(_, i)| height + LEGEND * (f64::from(i) + 0.5)).collect();
    let end = rows.last().map_or(height, |y| y + LEGEND);
    let mut svg = Svg::new([width, end]).on_white();
    for (entry, y) in legend.iter().zip(rows) {
        let color = entry.color.map_or(Rgb::BLACK, |color| color.light);
        Key::new(entry.mark, color, entry.name.clone()).draw(&mut svg, [64.0, y]);
    }
    svg.finish().replace("</svg>\n", &format!("{chart}</svg>\n"))
}
