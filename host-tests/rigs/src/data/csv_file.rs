//! CSV files with rows of one type.

use std::path::Path;

use anyhow::{Context, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The rows of a file. The error names the file, and the line if known.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    let read = || csv::Reader::from_path(path)?.into_deserialize().collect();
    let rows: Result<_, csv::Error> = read();
    rows.with_context(|| format!("cannot read {}", path.display()))
}

/// As [`read`], for the file of a pair in a folder. A pair without a file has no rows.
pub(super) fn read_pair<T: DeserializeOwned>(folder: &Path, pair: usize) -> Result<Vec<T>> {
    let path = of_pair(folder, pair);
    if path.is_file() { read(&path) } else { Ok(Vec::new()) }
}

/// The file of a pair in a folder; `pair` is its number from 0.
pub(super) fn of_pair(folder: &Path, pair: usize) -> std::path::PathBuf {
    folder.join(format!("{pair:04}.csv"))
}

/// Writes rows under a heading; an older file is replaced. The error names the file.
pub(super) fn write<T: Serialize>(path: &Path, rows: impl IntoIterator<Item = T>) -> Result<()> {
    let write = || -> Result<()> {
        let mut file = csv::Writer::from_path(path)?;
        rows.into_iter().try_for_each(|row| file.serialize(row))?;
        Ok(file.flush()?)
    };
    write().with_context(|| format!("cannot write {}", path.display()))
}
