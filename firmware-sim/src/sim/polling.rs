//! Polls the application until it has processed the pair on the bus.

use anyhow::{Context, Result};
use firmware_sim::{App, Event, PairOutcome};
use stereo_selfcal::State;
use stereo_selfcal::link::FpgaMatcher;
use test_support::wire::Wire;

/// The application on a simulated wire.
pub(super) type SimApp<'a, const N: usize> = App<'a, Wire, Wire, N>;

/// The driver of a matcher on a simulated wire.
pub(super) fn driver(wire: &Wire) -> FpgaMatcher<Wire, Wire> {
    FpgaMatcher::new(wire.clone(), wire.clone())
}

/// A pair that the application has processed.
pub(super) struct ProcessedPair {
    /// Correspondences taken into the batch.
    pub(super) taken: usize,
    pub(super) pair: PairOutcome,
    /// State before and after the pair, if it has changed.
    pub(super) change: Option<[State; 2]>,
}

/// Largest number of polls per pair: more than the longest frame and its solution take.
const POLLS: usize = 500;

/// Polls until the bus is idle, at most [`POLLS`] times. Returns the last pair that was finished.
///
/// # Errors
/// If the bus fails.
pub(super) fn poll_until_idle<const N: usize>(
    app: &mut SimApp<'_, N>,
) -> Result<Option<ProcessedPair>> {
    let (mut in_batch, mut finished, mut change) = (0, None, None);
    for _ in 0..POLLS {
        match app.poll()? {
            Event::Frame { taken, .. } => in_batch = taken,
            Event::Pair(outcome) => finished = Some(outcome),
            Event::StateChanged { before, after } => change = Some([before, after]),
            Event::Idle => break,
            _ => (),
        }
    }
    Ok(finished.map(|pair| ProcessedPair { taken: in_batch, pair, change }))
}

/// As [`poll_until_idle`], for a bus with a pair on it.
///
/// # Errors
/// If the bus fails or has no frame.
pub(super) fn poll_pair<const N: usize>(app: &mut SimApp<'_, N>) -> Result<ProcessedPair> {
    poll_until_idle(app)?.context("no frame on the bus")
}
