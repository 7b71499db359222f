//! Cache of finished measurements: one line of JSON each, in `cells.jsonl` beside the page of the evaluation.
//!
//! A line has the digest of the program that measured it, and a key: the serialised measurement. When the file is
//! opened, lines that another build wrote and damaged lines are dropped.

use std::collections::HashMap;
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Finished measurements (cells), in a file.
#[derive(Debug)]
pub struct Cache {
    path: PathBuf,
    build: String,
    known: HashMap<String, Value>,
    file: Mutex<File>,
}

#[derive(Serialize, Deserialize)]
struct Line {
    build: String,
    cell: String,
    outcome: Value,
}

impl Cache {
    /// Opens `cells.jsonl` in a folder, which is made if missing.
    ///
    /// * `fresh`: drop its content.
    ///
    /// # Errors
    /// If the file or this program cannot be read, or the folder cannot be written.
    pub fn open(dir: &Path, fresh: bool) -> Result<Self> {
        fs::create_dir_all(dir).with_context(|| format!("cannot make {}", dir.display()))?;
        let path = dir.join("cells.jsonl");
        let build = build()?;
        let old = if fresh || !path.exists() { Vec::new() } else { read(&path)? };
        let lines = || old.split(|&byte| byte == b'\n');
        let parsed = lines().filter_map(|line| serde_json::from_slice::<Line>(line).ok());
        let kept: Vec<Line> = parsed.filter(|line| line.build == build).collect();
        let file = rewrite(&path, &kept).with_context(|| unwritable(&path))?;
        let known = kept.into_iter().map(|line| (line.cell, line.outcome)).collect();
        Ok(Self { path, build, known, file: Mutex::new(file) })
    }

    /// The outcome of a cell that this build measured before the cache was opened.
    #[must_use]
    pub fn get(&self, cell: &str) -> Option<&Value> {
        self.known.get(cell)
    }

    /// Keeps an outcome for later runs.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn put(&self, cell: &str, outcome: Value) -> Result<()> {
        let line = Line { build: self.build.clone(), cell: cell.to_owned(), outcome };
        let line = serde_json::to_string(&line)? + "\n";
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        file.write_all(line.as_bytes()).with_context(|| unwritable(&self.path))
    }
}

/// FNV-1a of some bytes, 64 bits in hex, to distinguish inputs.
#[must_use]
pub fn digest(bytes: &[u8]) -> String {
    let mix = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", bytes.iter().fold(0xcbf2_9ce4_8422_2325, mix))
}

/// The digest of this program.
fn build() -> Result<String> {
    let program = std::env::current_exe().context("cannot find this program")?;
    Ok(digest(&read(&program)?))
}

fn read(path: &Path) -> Result<Vec<u8>> {
    fs::read(path).with_context(|| format!("cannot read {}", path.display()))
}

fn unwritable(path: &Path) -> String {
    format!("cannot write {}", path.display())
}

/// The file with only these lines, open for appending.
fn rewrite(path: &Path, lines: &[Line]) -> Result<File> {
    let next = path.with_extension("jsonl.new");
    let mut file = File::create(&next)?;
    for line in lines {
        writeln!(file, "{}", serde_json::to_string(line)?)?;
    }
    fs::rename(&next, path)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_digest_is_the_published_one() {
        assert_eq!([&b""[..], b"foobar"].map(digest), ["cbf29ce484222325", "85944171f73967e8"]);
    }

    #[test]
    fn outcomes_stay_in_the_cache_unless_it_starts_afresh() {
        let dir = tempfile::tempdir().unwrap();
        let third = Value::from(1.0 / 3.0);
        let cache = Cache::open(dir.path(), false).unwrap();
        cache.put("a", third.clone()).unwrap();
        assert_eq!(cache.get("a"), None);
        let again = Cache::open(dir.path(), false).unwrap();
        assert_eq!((again.get("a"), again.get("b")), (Some(&third), None));
        assert_eq!(Cache::open(dir.path(), true).unwrap().get("a"), None);
        assert_eq!(Cache::open(dir.path(), false).unwrap().get("a"), None);
    }

    #[test]
    fn damaged_lines_and_those_of_another_program_are_left_out() {
        let dir = tempfile::tempdir().unwrap();
        let cache = Cache::open(dir.path(), false).unwrap();
        cache.put("kept", 1.into()).unwrap();
        let path = dir.path().join("cells.jsonl");
        let mut bytes = fs::read(&path).unwrap();
        let other = br#"{"build":"0123456789abcdef","cell":"other","outcome":2}"#;
        bytes.extend([&other[..], b"\n\xff\xfe\n{\"build\":\"", &bytes.clone()[..20]].concat());
        fs::write(&path, bytes).unwrap();
        let again = Cache::open(dir.path(), false).unwrap();
        assert_eq!((again.get("kept"), again.get("other")), (Some(&1.into()), None));
        again.put("more", 3.into()).unwrap();
        let last = Cache::open(dir.path(), false).unwrap();
        assert_eq!((last.get("kept"), last.get("more")), (Some(&1.into()), Some(&3.into())));
    }
}
