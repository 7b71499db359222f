//! A change of the calibrator in words, for a line of JSON.

use serde::Serialize;
use stereo_selfcal::Scalar;
use stereo_selfcal::outcome::Event;

use super::checked::Judged;
use super::summary::JudgedInWords;

/// An event of the core's history in words: the fields of a line of `--events`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct EventLine {
    /// Time of the pair on the clock of its source; `null` for a recording without times.
    pub time: Option<u64>,
    /// Number of the pair, from 0.
    pub pair: u32,
    /// The parts that differ from the event before.
    pub changes: Vec<String>,
    /// Generation of the calibration in use.
    pub generation: u32,
    /// State of the estimate.
    pub state: String,
    /// The verdict after the pair.
    #[serde(flatten)]
    pub verdict: JudgedInWords,
}

impl EventLine {
    /// An event in words.
    ///
    /// * `time`: time of the pair, if its source has a clock.
    pub fn of<T: Scalar>(event: &Event<T>, time: Option<u64>) -> Self {
        Self {
            time,
            pair: event.pair,
            changes: event.changes.iter().map(|change| change.to_string()).collect(),
            generation: event.generation,
            state: event.verdict.state.to_string(),
            verdict: JudgedInWords::of(&Judged::of(&event.verdict)),
        }
    }
}
