//! The committed table of a campaign: `NAME.csv`, and below the words of `NAME.md`.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

use super::{Campaign, Chance, Figure, Row};

/// A table as text, the heading first. The first column has the names of the cases.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table(Vec<Vec<String>>);

/// A comparison with a committed table.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Compared {
    pub(crate) equal: usize,
    /// Figures that differ by no more than chance.
    pub(crate) near: usize,
    pub(crate) differences: Vec<String>,
}

impl Table {
    /// * `columns`: names of the figures shown; all if `None`.
    pub(crate) fn of(rows: &[Row], columns: Option<&[&str]>) -> Self {
        let first = || rows.iter().flat_map(|row| &row.figures).map(|figure| figure.name);
        let columns: Vec<&str> = match columns {
            Some(columns) => columns.to_vec(),
            None => first().take(rows.first().map_or(0, |row| row.figures.len())).collect(),
        };
        let cells = |row: &Row| {
            let cell = |name: &&str| row.figure(name).map_or(String::new(), Figure::text);
            [row.case.clone()].into_iter().chain(columns.iter().map(cell)).collect()
        };
        let heading = ["case"].iter().chain(&columns).map(|name| (*name).to_owned()).collect();
        Self([heading].into_iter().chain(rows.iter().map(cells)).collect())
    }

    /// A table of these lines, the heading first.
    pub(crate) fn of_lines(lines: Vec<Vec<String>>) -> Self {
        Self(lines)
    }

    pub(crate) fn read(file: &Path) -> Result<Self> {
        let name = || format!("cannot read {}", file.display());
        let mut reader =
            csv::ReaderBuilder::new().has_headers(false).from_path(file).with_context(name)?;
        let line = |record: csv::Result<csv::StringRecord>| {
            Ok(record.with_context(name)?.iter().map(str::to_owned).collect())
        };
        Ok(Self(reader.records().map(line).collect::<Result<_>>()?))
    }

    /// Writes `NAME.csv`, and the table of `NAME.md` below its words.
    pub(crate) fn write(&self, name: &str, dir: &Path) -> Result<()> {
        self.write_csv(&dir.join(format!("{name}.csv")))?;
        let page = dir.join(format!("{name}.md"));
        let words = fs::read_to_string(&page).ok();
        fs::write(&page, with_table(words.as_deref(), name, &self.markdown()))
            .with_context(|| format!("cannot write {}", page.display()))
    }

    pub(crate) fn write_csv(&self, file: &Path) -> Result<()> {
        let name = || format!("cannot write {}", file.display());
        let mut writer = csv::Writer::from_path(file).with_context(name)?;
        for line in &self.0 {
            writer.write_record(line).with_context(name)?;
        }
        writer.flush().with_context(name)
    }

    fn markdown(&self) -> String {
        let mut lines = self.0.iter().map(|line| format!("| {} |\n", line.join(" | ")));
        let heading = lines.next().unwrap_or_default();
        let rule = "---|".repeat(self.0.first().map_or(0, Vec::len));
        format!("{heading}|{rule}\n{}", lines.collect::<String>())
    }

    /// Columns of equal width, for a terminal.
    pub(crate) fn aligned(&self) -> String {
        let width = |column: usize| {
            self.0.iter().map(|line| line[column].chars().count()).max().unwrap_or_default()
        };
        let widths: Vec<usize> = (0..self.0.first().map_or(0, Vec::len)).map(width).collect();
        let mut text = String::new();
        for line in &self.0 {
            for (cell, (i, width)) in line.iter().zip(widths.iter().enumerate()) {
                let _ = if i == 0 {
                    write!(text, "{cell:<width$}")
                } else {
                    write!(text, "  {cell:>width$}")
                };
            }
            text.push('\n');
        }
        text
    }

    fn cell(&self, case: &str, column: &str) -> Option<&str> {
        let column = self.0.first()?.iter().position(|name| name == column)?;
        let line = self.0[1..].iter().find(|line| line[0] == case)?;
        line.get(column).map(String::as_str)
    }

    fn cases(&self) -> impl Iterator<Item = &str> {
        self.0.iter().skip(1).map(|line| line[0].as_str())
    }

    /// Compares measured rows with this table.
    ///
    /// * `all`: whether the rows are all of the campaign.
    pub(crate) fn compare(&self, campaign: &Campaign, rows: &[Row], all: bool) -> Compared {
        let mut compared = Compared::default();
        for row in rows {
            for name in campaign.columns() {
                let committed = self.cell(&row.case, name);
                compared.add(
                    &format!("{}, {}, {name}", campaign.name, row.case),
                    committed,
                    row.figure(name),
                );
            }
        }
        let lost = self.cases().filter(|case| all && rows.iter().all(|row| row.case != *case));
        let lost = lost.map(|case| format!("{}, {case}: not measured", campaign.name));
        compared.differences.extend(lost);
        compared
    }
}

impl Compared {
    fn add(&mut self, what: &str, committed: Option<&str>, measured: Option<&Figure>) {
        let (Some(text), Some(Figure { value, chance, .. })) = (committed, measured) else {
            self.differences.push(format!("{what}: in the table or measured only"));
            return;
        };
        let number = text.parse().unwrap_or(f64::NAN);
        let decimals = text.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let whole = decimals == 0 && matches!(chance, Chance::Count);
        let rounding =
            if whole { 0.0 } else { 0.501 } * 0.1_f64.powi(i32::try_from(decimals).unwrap_or(0));
        if Chance::Exact.explains(number, *value, rounding) {
            self.equal += 1;
        } else if chance.explains(number, *value, rounding) {
            self.near += 1;
        } else {
            self.differences.push(format!("{what}: {text} in the table, {value:.4e} measured"));
        }
    }
}

impl Row {
    pub(super) fn figure(&self, name: &str) -> Option<&Figure> {
        self.figures.iter().find(|figure| figure.name == name)
    }
}

impl Figure {
    /// Whole numbers as such; else three significant digits, four decimals of a share. Empty without data.
    fn text(&self) -> String {
        let size = self.value.abs();
        if !self.value.is_finite() {
            return String::new();
        }
        let whole = self.value.trunc().total_cmp(&self.value).is_eq();
        let decimals = match self.chance {
            Chance::Count | Chance::Exact if whole => 0,
            Chance::Share(_) => 4,
            _ => (0..12_i32).find(|decimals| size * 10_f64.powi(*decimals) >= 99.5).unwrap_or(2),
        };
        format!("{:.*}", usize::try_from(decimals).unwrap_or(0), self.value)
    }
}

/// The words of a page, and below them this table.
fn with_table(page: Option<&str>, name: &str, table: &str) -> String {
    let words = page.map_or_else(
        || format!("# {name}"),
        |page| {
            page.lines().take_while(|line| !line.starts_with('|')).collect::<Vec<_>>().join("\n")
        },
    );
    format!("{}\n\n{table}", words.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn figure(name: &'static str, value: f64, chance: Chance) -> Figure {
        Figure { name, value, chance }
    }

    fn rows(e: f64, bad: f64) -> Vec<Row> {
        let figures = vec![figure("e", e, Chance::rms(200)), figure("bad", bad, Chance::Count)];
        vec![Row { case: "one, 30 %".into(), figures }]
    }

    fn campaign() -> Campaign {
        let measure = super::super::Measure::Rows(|_| Ok(rows(1.0604, 0.0)));
        let lens = sim::run::LensTracking::Report;
        let columns = "e, bad";
        Campaign {
            name: "c",
            trials: 1,
            seeds: &[1],
            lens,
            columns,
            quick: None,
            worst_first: None,
            measure,
            chart: None,
        }
    }

    #[test]
    fn figures_have_three_significant_digits_and_counts_none() {
        let numbers = [0.010_049, 1.0604, 12.346, 0.1234, 123.4, 0.000_029_12, f64::NAN];
        let texts = ["0.0100", "1.06", "12.3", "0.123", "123", "0.0000291", ""];
        assert_eq!(numbers.map(|n| figure("", n, Chance::Exact).text()), texts);
        assert_eq!(figure("", 3.0, Chance::Count).text(), "3");
        assert_eq!(figure("", 0.9955, Chance::Share(200.0)).text(), "0.9955");
    }

    #[test]
    fn a_planted_difference_is_found_and_chance_is_not_one() {
        let committed = Table::of(&rows(1.0604, 0.0), Some(&["e", "bad"]));
        let compare = |rows: &[Row]| committed.compare(&campaign(), rows, true);
        let same = compare(&rows(1.0604, 0.0));
        assert_eq!(same, Compared { equal: 2, ..Compared::default() });
        let near = compare(&rows(1.2, 1.0));
        assert_eq!((near.equal, near.near, near.differences.len()), (0, 2, 0));
        let planted = compare(&rows(1.35, 6.0));
        let expected = [
            "c, one, 30 %, e: 1.06 in the table, 1.3500e0 measured",
            "c, one, 30 %, bad: 0 in the table, 6.0000e0 measured",
        ];
        assert_eq!(planted.differences, expected);
        let other = [Row { case: "other".into(), ..rows(1.0, 0.0).remove(0) }];
        assert_eq!(compare(&other).differences.len(), 3, "two figures, and the case that is gone");
    }

    #[test]
    fn a_table_is_read_as_written_and_stands_below_its_words() {
        let dir = tempfile::tempdir().unwrap();
        let table = Table::of(&rows(1.0604, 0.0), Some(&["e", "bad"]));
        table.write("c", dir.path()).unwrap();
        assert_eq!(Table::read(&dir.path().join("c.csv")).unwrap(), table);
        let page = fs::read_to_string(dir.path().join("c.md")).unwrap();
        let lines = "| case | e | bad |\n|---|---|---|\n| one, 30 % | 1.06 | 0 |\n";
        assert_eq!(page, format!("# c\n\n{lines}"));
        assert_eq!(
            with_table(Some("# C\n\nWords.\n\n| old |\n"), "c", lines),
            format!("# C\n\nWords.\n\n{lines}")
        );
        assert_eq!(table.aligned(), "case          e  bad\none, 30 %  1.06    0\n");
    }
}
