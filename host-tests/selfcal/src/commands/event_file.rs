//! The file of `--events`.

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use anyhow::{Context, Result};
use sim::run::EventLine;

/// A file with one line of JSON for each change of a calibrator.
pub(super) struct EventFile(BufWriter<File>);

impl EventFile {
    /// An empty file; an earlier one is replaced.
    pub(super) fn create(path: &Path) -> Result<Self> {
        let file =
            File::create(path).with_context(|| format!("cannot write {}", path.display()))?;
        Ok(Self(BufWriter::new(file)))
    }

    /// Adds a line.
    pub(super) fn write(&mut self, event: &EventLine, time: Option<u64>) -> io::Result<()> {
        serde_json::to_writer(&mut self.0, &EventLine { time, ..event.clone() })?;
        writeln!(self.0)
    }

    /// Writes what is buffered.
    pub(super) fn end(mut self) -> io::Result<()> {
        self.0.flush()
    }
}
