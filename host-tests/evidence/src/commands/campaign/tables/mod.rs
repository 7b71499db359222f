//! `evidence tables`: tables of `EVIDENCE.md` that campaigns measure.

mod accuracy;
mod document;
mod real_rows;

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;

use document::replaced;

/// Measure tables of host-tests/EVIDENCE.md again, and write them.
///
/// A table stands between `<!-- campaign NAME -->` and `<!-- end -->`. All tables take about ten minutes on two idle
/// cores; each is written as soon as it is measured. Figures have two decimals; below 0.1 they have two significant
/// digits.
#[derive(Debug, Args)]
#[command(after_help = "Examples:
  evidence tables
  evidence tables fused locks
  evidence tables --check")]
pub struct TablesArgs {
    /// Names of the tables; default all.
    names: Vec<String>,

    /// Measure one quick row of each table, and compare it with the file.
    #[arg(long)]
    check: bool,
}

/// A row: its label, and the measurement of its other cells.
struct Row {
    label: String,
    measure: Box<dyn Fn() -> Result<Vec<String>>>,
}

impl Row {
    fn new(label: impl Into<String>, measure: impl Fn() -> Result<Vec<String>> + 'static) -> Self {
        Self { label: label.into(), measure: Box::new(measure) }
    }

    /// The row in markdown.
    fn measured(&self) -> Result<String> {
        let cells = (self.measure)().with_context(|| self.label.clone())?;
        Ok(format!("| {} | {} |", self.label, cells.join(" | ")))
    }
}

struct Table {
    name: &'static str,
    /// Cells of the heading.
    heading: &'static [&'static str],
    rows: Vec<Row>,
    /// The row that takes seconds; `None`: each takes longer.
    quick: Option<usize>,
}

fn all() -> Vec<Table> {
    [accuracy::tables(), real_rows::tables()].into_iter().flatten().collect()
}

fn path() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../EVIDENCE.md")
}

/// Runs `evidence tables`.
pub(crate) fn tables(args: &TablesArgs) -> Result<()> {
    let all = all();
    for name in &args.names {
        let known: Vec<&str> = all.iter().map(|table| table.name).collect();
        ensure!(known.contains(&&**name), "no table {name}; there are {}", known.join(", "));
    }
    let chosen =
        |table: &&Table| args.names.is_empty() || args.names.iter().any(|n| n == table.name);
    for table in all.iter().filter(chosen) {
        if args.check { check(table)? } else { write(table)? }
    }
    Ok(())
}

fn write(table: &Table) -> Result<()> {
    let mut lines = vec![
        format!("| {} |", table.heading.join(" | ")),
        format!("|{}", "---|".repeat(table.heading.len())),
    ];
    for (i, row) in table.rows.iter().enumerate() {
        eprintln!("{}: row {} of {}, {}", table.name, i + 1, table.rows.len(), row.label);
        lines.push(row.measured()?);
    }
    let text = fs::read_to_string(path()).context("EVIDENCE.md")?;
    fs::write(path(), replaced(&text, table.name, &lines)?).context("EVIDENCE.md")?;
    println!("{}: written", table.name);
    Ok(())
}

fn check(table: &Table) -> Result<()> {
    let text = fs::read_to_string(path()).context("EVIDENCE.md")?;
    let written = document::lines(&text, table.name)?;
    let Some(quick) = table.quick else { return Ok(()) };
    let measured = table.rows[quick].measured()?;
    ensure!(
        written.contains(&&*measured),
        "EVIDENCE.md, {}: `cargo evidence tables` writes\n{measured}",
        table.name
    );
    println!("{}: equal", table.name);
    Ok(())
}

/// Two decimals; two significant digits below 0.1.
fn figure(number: f64) -> String {
    let size = number.abs();
    if !number.is_finite() {
        return "-".into();
    }
    let mut decimals = 2;
    let mut unit = 0.1;
    while size > 0.0 && size < unit * 0.995 && decimals < 9 {
        unit /= 10.0;
        decimals += 1;
    }
    format!("{number:.decimals$}")
}

/// Figures of several cases in one cell.
fn list(numbers: impl IntoIterator<Item = f64>) -> String {
    joined(numbers.into_iter().map(figure))
}

/// Texts of several cases in one cell; a single one if all are equal.
fn joined(texts: impl IntoIterator<Item = String>) -> String {
    let texts: Vec<String> = texts.into_iter().collect();
    match &texts[..] {
        [first, others @ ..] if others.iter().all(|other| other == first) => first.clone(),
        _ => texts.join(", "),
    }
}

/// Shares of several cases in per cent.
fn percent(shares: impl IntoIterator<Item = f64>, decimals: usize) -> String {
    let text = |share: f64| {
        if share.is_nan() { "-".into() } else { format!("{:.decimals$}", 100.0 * share) }
    };
    format!("{} %", joined(shares.into_iter().map(text)))
}

/// `10, 30 % outliers`.
fn outliers(shares: &[f64]) -> String {
    let all: Vec<String> = shares.iter().map(|share| format!("{:.0}", 100.0 * share)).collect();
    format!("{} % outliers", all.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_two_decimals_or_two_digits() {
        let numbers = [1.004, 12.346, 0.1234, 0.0999, 0.0123, 0.000_561, 0.0, f64::NAN];
        let texts = ["1.00", "12.35", "0.12", "0.10", "0.012", "0.00056", "0.00", "-"];
        assert_eq!(numbers.map(figure), texts.map(str::to_owned));
    }

    #[test]
    fn each_table_has_its_place_in_the_document_and_its_quick_row() {
        let text = fs::read_to_string(path()).unwrap();
        for table in all() {
            let lines = document::lines(&text, table.name).unwrap();
            assert!(lines.len() > 2, "{}", table.name);
            assert!(table.quick.is_none_or(|quick| quick < table.rows.len()), "{}", table.name);
        }
        let places = text.lines().filter(|line| line.starts_with("<!-- campaign ")).count();
        assert_eq!(places, all().len());
    }
}
