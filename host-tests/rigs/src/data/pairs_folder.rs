//! The folder of a data set, written pair by pair.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};

use super::csv_file;
use super::matches::Match;
use super::meta::Meta;

/// A data set in progress: the pairs written so far stay if the run is interrupted.
#[derive(Debug)]
pub struct PairsFolder {
    pairs_dir: PathBuf,
    count: usize,
}

impl PairsFolder {
    /// Begins a data set: writes its rig.
    ///
    /// # Errors
    /// If the folder exists and is not empty, or a file cannot be written; names the file.
    pub fn begin(dir: &Path, meta: &Meta) -> Result<Self> {
        if dir.exists() && fs::read_dir(dir)?.next().is_some() {
            bail!("{} is not empty: nothing is overwritten", dir.display());
        }
        let pairs_dir = dir.join("pairs");
        fs::create_dir_all(&pairs_dir)
            .with_context(|| format!("cannot make {}", pairs_dir.display()))?;
        let path = dir.join("meta.json");
        let text = serde_json::to_string_pretty(meta)?;
        fs::write(&path, text + "\n")
            .with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self { pairs_dir, count: 0 })
    }

    /// Writes the next pair.
    pub fn push(&mut self, pair: &[Match]) -> Result<()> {
        csv_file::write(&csv_file::of_pair(&self.pairs_dir, self.count), pair)?;
        self.count += 1;
        Ok(())
    }
}
