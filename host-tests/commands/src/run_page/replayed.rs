//! A replayed data set with its log.

use host_tests::data::Dataset;
use host_tests::run::{DepthErrors, RunLog};

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
