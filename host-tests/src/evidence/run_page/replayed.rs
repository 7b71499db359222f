//! A run and what it was made of.

use crate::data::Dataset;
use crate::run::RunLog;

/// A replayed recording.
#[derive(Debug, Clone, Copy)]
pub struct Replayed<'a> {
    /// What was replayed.
    pub set: &'a Dataset,
    /// What came of it.
    pub log: &'a RunLog,
    /// The command that replays it.
    pub command: &'a str,
}
