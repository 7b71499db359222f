//! The table of figures, and its file: a comment that names the compiler, then CSV.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use serde::{Deserialize, Serialize};

/// One figure.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Row {
    pub(crate) board: String,
    pub(crate) scalar: String,
    /// `opt-level` of the build.
    pub(crate) opt: String,
    pub(crate) what: String,
    pub(crate) unit: String,
    pub(crate) value: u64,
}

impl Row {
    /// What the figure is of.
    pub(crate) fn key(&self) -> [&str; 4] {
        [&self.board, &self.scalar, &self.opt, &self.what]
    }
}

/// All figures of one compiler.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table {
    pub(crate) compiler: String,
    pub(crate) rows: Vec<Row>,
}

const COMPILER: &str = "# rustc ";

impl Table {
    pub(crate) fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path)
            .with_context(|| format!("cannot read {}: --update makes it", path.display()))?;
        Self::parse(&text).with_context(|| format!("in {}", path.display()))
    }

    fn parse(text: &str) -> Result<Self> {
        let compiler = text.lines().find_map(|line| line.strip_prefix(COMPILER));
        let compiler = compiler.context("no line names the compiler")?.to_owned();
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
        let rows = reader.deserialize().collect::<Result<Vec<Row>, _>>()?;
        ensure!(!rows.is_empty(), "no figures");
        Ok(Self { compiler, rows })
    }

    pub(crate) fn write(&self, path: &Path) -> Result<()> {
        fs::write(path, self.text()?).with_context(|| format!("cannot write {}", path.display()))
    }

    fn text(&self) -> Result<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            writer.serialize(row)?;
        }
        let csv = String::from_utf8(writer.into_inner()?)?;
        Ok(format!("{COMPILER}{}\n{csv}", self.compiler))
    }
}

#[cfg(test)]
pub(crate) fn row(what: &str, value: u64) -> Row {
    let [board, scalar, opt] = ["m4f", "f32", "3"].map(String::from);
    Row { board, scalar, opt, what: what.into(), unit: "instructions".into(), value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_comes_back_as_it_was_written() {
        let table =
            Table { compiler: "1.2.3".into(), rows: vec![row("push", 365), row("fuse", 7)] };
        let text = table.text().unwrap();
        assert_eq!(
            text,
            "# rustc 1.2.3\nboard,scalar,opt,what,unit,value\nm4f,f32,3,push,instructions,365\n\
             m4f,f32,3,fuse,instructions,7\n"
        );
        assert_eq!(Table::parse(&text).unwrap(), table);
    }

    #[test]
    fn a_table_without_compiler_or_figures_is_refused() {
        assert!(
            Table::parse("board,scalar,opt,what,unit,value\nm4f,f32,3,push,bytes,1\n").is_err()
        );
        assert!(Table::parse("# rustc 1.2.3\nboard,scalar,opt,what,unit,value\n").is_err());
        assert!(Table::parse("# rustc 1.2.3\nboard,what\nm4f,push\n").is_err());
    }
}
