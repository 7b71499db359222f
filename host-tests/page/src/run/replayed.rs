//! A replayed data set with its log.

use rigs::data::Dataset;
use sim::run::{DepthErrors, RunLog};

/// A replayed recording.
#[derive(Debug, Clone, Copy)]
pub struct Replayed<'a> {
    /// The data set.
    pub set: &'a Dataset,
    /// Log of the replay.
    pub log: &'a RunLog,
    /// Measured error of depth, if true depths are known.
    pub depth: Option<DepthErrors>,
    /// The command that replays it.
    pub command: &'a str,
}
