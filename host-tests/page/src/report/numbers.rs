//! The numbers of a table or a figure, as a CSV file.

use std::path::Path;

use anyhow::Result;

/// Rows under a heading; written as `csv/NAME.csv` beside the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Csv {
    /// Name of the file, without its ending: letters, digits, `-` and `_`.
    pub name: String,
    /// Names of the columns, with units.
    pub heading: Vec<String>,
    /// Rows as long as the heading.
    pub rows: Vec<Vec<String>>,
}

impl Csv {
    /// A table without rows.
    pub fn new(name: &str, heading: &[&str]) -> Self {
        let heading = heading.iter().map(|&column| column.to_owned()).collect();
        Self { name: name.to_owned(), heading, rows: Vec::new() }
    }

    /// Adds a row.
    pub fn push(&mut self, row: impl IntoIterator<Item = String>) {
        self.rows.push(row.into_iter().collect());
    }

    /// Path of the file from the page.
    pub fn link(&self) -> String {
        format!("csv/{}.csv", self.name)
    }

    pub(super) fn write(&self, dir: &Path) -> Result<()> {
        let mut file = csv::Writer::from_writer(Vec::new());
        file.write_record(&self.heading)?;
        self.rows.iter().try_for_each(|row| file.write_record(row))?;
        crate::write(&dir.join(self.link()), &String::from_utf8(file.into_inner()?)?)
    }
}
