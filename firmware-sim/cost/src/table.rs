//! The table of figures: a CSV file, headed by the version of the compiler.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use emulator::Board;

const COMPILER: &str = "# rustc ";
/// Before the name of a figure in cycles.
const CYCLES_OF: &str = "cycles of ";
const COLUMNS: &str = "board,scalar,opt,what,unit,value";

/// One figure.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Row {
    /// Board, scalar, `opt-level` and what was measured: they identify the figure.
    pub(crate) key: [String; 4],
    pub(crate) unit: String,
    pub(crate) value: u64,
}

impl Row {
    pub(crate) fn new(key: [&str; 4], unit: &str, value: u64) -> Self {
        Self { key: key.map(String::from), unit: unit.into(), value }
    }

    fn parse(line: &str) -> Option<Self> {
        let fields: Vec<&str> = line.split(',').collect();
        let [board, scalar, opt, what, unit, value] = *fields.as_slice() else { return None };
        Some(Self::new([board, scalar, opt, what], unit, value.parse().ok()?))
    }

    /// The row of the same figure in cycles, of a run that counts cycles in place of instructions.
    pub(crate) fn in_cycles(&self) -> Option<Self> {
        let per = self.unit.strip_prefix("instructions")?;
        let [board, scalar, opt, what] = self.key.clone();
        let key = [board, scalar, opt, format!("{CYCLES_OF}{what}")];
        Some(Self { key, unit: format!("cycles{per}"), value: self.value })
    }

    /// Whether it has the cycles of another row.
    pub(crate) fn is_in_cycles(&self) -> bool {
        self.key[3].starts_with(CYCLES_OF)
    }

    /// Time, ms: from cycles, or from instructions on a board without a count of cycles. `None` for other units.
    pub(crate) fn ms(&self) -> Option<f64> {
        let board = Board::named(&self.key[0])?;
        let cycles = match self.unit.as_str() {
            "cycles" => 1.0,
            "instructions" => board.cycles?,
            _ => return None,
        };
        Some(as_f64(self.value) * cycles / board.hertz * 1e3)
    }
}

#[expect(clippy::cast_precision_loss, reason = "figures are far below 2^52")]
pub(crate) fn as_f64(value: u64) -> f64 {
    value as f64
}

/// All figures of one compiler.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table {
    pub(crate) compiler: String,
    pub(crate) rows: Vec<Row>,
}

impl Table {
    pub(crate) fn read(file: &Path) -> Result<Self> {
        let text = fs::read_to_string(file).map_err(anyhow::Error::from);
        let table = text.and_then(|text| Self::parse(&text));
        table.with_context(|| format!("{}: --update writes the table", file.display()))
    }

    pub(crate) fn parse(text: &str) -> Result<Self> {
        let mut lines = text.lines();
        let compiler = lines.next().and_then(|line| line.strip_prefix(COMPILER));
        let compiler = compiler.context("the first line names no compiler")?.to_owned();
        ensure!(lines.next() == Some(COLUMNS), "columns {COLUMNS} are needed");
        let row = |line| Row::parse(line).with_context(|| format!("not a row: {line}"));
        let rows = lines.map(row).collect::<Result<Vec<_>>>()?;
        ensure!(!rows.is_empty(), "no figures");
        Ok(Self { compiler, rows })
    }

    pub(crate) fn text(&self) -> String {
        let rows = self.rows.iter();
        let rows = rows.map(|row| format!("{},{},{}\n", row.key.join(","), row.unit, row.value));
        format!("{COMPILER}{}\n{COLUMNS}\n{}", self.compiler, rows.collect::<String>())
    }

    /// Time of the figure with a key, ms.
    pub(crate) fn ms(&self, [board, scalar, opt, what]: [&str; 4]) -> Option<f64> {
        let counted = self.get([board, scalar, opt, &format!("{CYCLES_OF}{what}")]);
        counted.or_else(|| self.get([board, scalar, opt, what]))?.ms()
    }

    /// The figure with a key.
    pub(crate) fn get(&self, key: [&str; 4]) -> Option<&Row> {
        self.rows.iter().find(|row| row.key == key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_reads_back_as_written() {
        let row = |what, value| Row::new(["m4f", "f32", "3", what], "instructions", value);
        let table =
            Table { compiler: "1.2.3".into(), rows: vec![row("push", 365), row("fuse", 7)] };
        let text = table.text();
        assert_eq!(
            text,
            "# rustc 1.2.3\nboard,scalar,opt,what,unit,value\nm4f,f32,3,push,instructions,365\n\
             m4f,f32,3,fuse,instructions,7\n"
        );
        assert_eq!(Table::parse(&text).unwrap(), table);
    }

    #[test]
    fn a_table_without_compiler_figures_or_columns_is_refused() {
        let head = format!("{COMPILER}1.2.3\n{COLUMNS}\n");
        assert!(Table::parse(&format!("{head}m4f,f32,3,push,bytes,1\n")).is_ok());
        for text in [
            head.as_str(),
            "# rustc 1.2.3\nboard,what\nm4f,push\n",
            "board,scalar,opt,what,unit,value\nm4f,f32,3,push,bytes,1\n",
            &format!("{head}m4f,f32,3,push,bytes,many\n"),
        ] {
            assert!(Table::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn cycles_take_time_and_without_them_instructions_do() {
        let row = |board, unit, value| Row::new([board, "f32", "3", "update"], unit, value);
        assert_eq!(row("m4f", "bytes", 5).ms(), None);
        assert_eq!(row("m4f", "instructions", 5).ms(), None);
        assert!((row("m7", "instructions", 4_800_000).ms().unwrap() - 10.0).abs() < 1e-9);
        let cycles = row("m4f", "instructions", 8_400_000).in_cycles().unwrap();
        assert!(cycles.is_in_cycles() && cycles.unit == "cycles");
        assert!((cycles.ms().unwrap() - 50.0).abs() < 1e-9);
        let rows = vec![row("m4f", "instructions", 1), cycles];
        let table = Table { compiler: "1.2.3".into(), rows };
        assert_eq!(table.ms(["m4f", "f32", "3", "update"]).map(f64::round), Some(50.0));
        assert_eq!(row("m4f", "bytes", 5).in_cycles(), None);
    }
}
