//! CSV files with rows of one type.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use anyhow::{Context, Error, Result, anyhow};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The rows of a file. The error names the file, and the line if known.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<Vec<T>> {
    let read = || csv::Reader::from_path(path)?.into_deserialize().collect();
    let rows: Result<_, csv::Error> = read();
    rows.map_err(|why| in_words(path, &why))
        .with_context(|| format!("cannot read {}", path.display()))
}

/// An error in words of a user: the cause that the first bytes show, or the line.
fn in_words(path: &Path, why: &csv::Error) -> Error {
    if let csv::ErrorKind::Io(why) = why.kind() {
        return anyhow!("{why}");
    }
    let mut start = Vec::new();
    // Without the first bytes the line is named.
    let _ = File::open(path).map(|file| file.take(FIRST).read_to_end(&mut start));
    let line = why.position().map_or(0, csv::Position::line);
    let field = match why.kind() {
        csv::ErrorKind::Deserialize { err, .. } => err.field(),
        _ => None,
    };
    let field = field.map_or(String::new(), |field| format!(", column {}", field + 1));
    match cause(&start) {
        Some(cause) => anyhow!("{cause}"),
        None => anyhow!(
            "line {line}{field}: expected as many fields as the first line has names, and finite numbers in them"
        ),
    }
}

/// Number of the first bytes that tell a cause.
const FIRST: u64 = 4096;

/// Why bytes are no CSV with commas, if their start shows it.
pub(super) fn cause(start: &[u8]) -> Option<&'static str> {
    let line = start.split(|byte| *byte == b'\n').next().unwrap_or_default();
    match start {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Some("it is UTF-16: save it as UTF-8"),
        _ if start.contains(&0) => {
            Some("it has bytes of 0, so it is no text: save it as CSV in UTF-8")
        }
        _ if line.contains(&b';') => Some(
            "its columns are separated by semicolons: save it with commas between columns, and points in numbers",
        ),
        _ if line.contains(&b'\t') && !line.contains(&b',') => {
            Some("its columns are separated by tabs: save it with commas")
        }
        _ => None,
    }
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
