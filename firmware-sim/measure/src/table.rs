//! Tables of figures: one for each compiler version, a CSV file named after it.

use std::cmp::Reverse;
use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use semver::Version;
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
    /// Identifies the figure.
    pub(crate) fn key(&self) -> [&str; 4] {
        [&self.board, &self.scalar, &self.opt, &self.what]
    }
}

/// All figures of one compiler.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Table {
    pub(crate) compiler: Version,
    pub(crate) rows: Vec<Row>,
}

impl Table {
    fn read(file: &Path) -> Result<Self> {
        let read = || {
            let version = file.file_stem().and_then(OsStr::to_str).unwrap_or_default();
            let compiler = version.parse().context("the file is not named after a version")?;
            Self::parse(compiler, &fs::read_to_string(file)?)
        };
        read().with_context(|| format!("in {}", file.display()))
    }

    fn parse(compiler: Version, text: &str) -> Result<Self> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let rows = reader.deserialize().collect::<Result<Vec<Row>, _>>()?;
        ensure!(!rows.is_empty(), "no figures");
        Ok(Self { compiler, rows })
    }

    /// Writes the file of this compiler into `folder`, in place of the one there.
    pub(crate) fn write(&self, folder: &Path) -> Result<()> {
        let file = folder.join(format!("{}.csv", self.compiler));
        let write = || {
            fs::create_dir_all(folder)?;
            anyhow::Ok(fs::write(&file, self.text()?)?)
        };
        write().with_context(|| format!("cannot write {}", file.display()))
    }

    fn text(&self) -> Result<String> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        for row in &self.rows {
            writer.serialize(row)?;
        }
        Ok(String::from_utf8(writer.into_inner()?)?)
    }
}

/// All tables of a folder, at least one.
pub(crate) fn read_all(folder: &Path) -> Result<Vec<Table>> {
    let tables = || {
        let files = fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
        let files = files.collect::<Result<Vec<_>>>()?;
        let tables = files.iter().filter(|file| file.extension() == Some(OsStr::new("csv")));
        let tables = tables.map(|file| Table::read(file)).collect::<Result<Vec<_>>>()?;
        ensure!(!tables.is_empty(), "no table");
        Ok(tables)
    };
    tables().with_context(|| format!("{}: --update writes a table", folder.display()))
}

/// The table of this compiler, otherwise of the nearest version; at equal distance the newer.
pub(crate) fn nearest<'a>(tables: &'a [Table], compiler: &Version) -> Option<&'a Table> {
    let number = |v: &Version| (v.major * 1000 + v.minor) * 1000 + v.patch;
    tables.iter().min_by_key(|table| {
        let distance = number(compiler).abs_diff(number(&table.compiler));
        (distance, table.compiler != *compiler, Reverse(&table.compiler))
    })
}

#[cfg(test)]
pub(crate) fn row(what: &str, value: u64) -> Row {
    let [board, scalar, opt] = ["m4f", "f32", "3"].map(String::from);
    Row { board, scalar, opt, what: what.into(), unit: "instructions".into(), value }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(compiler: &str, rows: &[Row]) -> Table {
        Table { compiler: compiler.parse().unwrap(), rows: rows.to_vec() }
    }

    #[test]
    fn a_table_reads_back_as_written() {
        let table = table("1.2.3", &[row("push", 365), row("fuse", 7)]);
        let text = table.text().unwrap();
        assert_eq!(
            text,
            "board,scalar,opt,what,unit,value\nm4f,f32,3,push,instructions,365\n\
             m4f,f32,3,fuse,instructions,7\n"
        );
        assert_eq!(Table::parse(table.compiler.clone(), &text).unwrap(), table);
    }

    #[test]
    fn a_table_without_figures_or_columns_is_refused() {
        let refused = |text| Table::parse(Version::new(1, 2, 3), text).is_err();
        assert!(refused("board,scalar,opt,what,unit,value\n"));
        assert!(refused("board,what\nm4f,push\n"));
    }

    #[test]
    fn each_compiler_has_its_file_and_an_update_replaces_only_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("costs");
        assert!(read_all(&folder).is_err());
        let [old, new] = ["1.95.0", "1.96.0"].map(|version| table(version, &[row("push", 1)]));
        let updated = Table { rows: vec![row("push", 2)], ..new.clone() };
        for table in [&old, &new, &updated] {
            table.write(&folder).unwrap();
        }
        let mut tables = read_all(&folder).unwrap();
        tables.sort_by(|a, b| a.compiler.cmp(&b.compiler));
        assert_eq!(tables, [old, updated]);
    }

    #[test]
    fn a_file_that_names_no_version_is_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("notes.csv"), "").unwrap();
        let error = format!("{:#}", read_all(folder.path()).unwrap_err());
        assert!(error.contains("notes.csv"), "{error}");
    }

    #[test]
    fn the_table_of_the_compiler_is_selected_else_that_of_the_nearest_version() {
        let tables = ["1.90.0", "1.95.0", "1.96.0", "1.96.2"].map(|v| table(v, &[]));
        let selected = |compiler: &str| {
            nearest(&tables, &compiler.parse().unwrap()).map(|table| table.compiler.to_string())
        };
        for (compiler, expected) in [
            ("1.96.0", "1.96.0"),
            ("1.95.0", "1.95.0"),
            ("1.95.1", "1.95.0"),
            ("1.96.1", "1.96.2"),
            ("1.97.0-nightly", "1.96.2"),
            ("1.96.0-beta.3", "1.96.0"),
            ("1.91.0", "1.90.0"),
            ("2.0.0", "1.96.2"),
        ] {
            assert_eq!(selected(compiler).as_deref(), Some(expected), "{compiler}");
        }
        assert_eq!(nearest(&[], &Version::new(1, 96, 0)), None);
    }
}
