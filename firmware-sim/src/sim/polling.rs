//! Polls the application until it has processed the pair on the bus.

use anyhow::{Context, Result};
use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use firmware_sim::{App, Event, PairOutcome};
use stereo_selfcal::State;

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
pub(super) fn poll_until_idle<SPI, RDY, const N: usize>(
    app: &mut App<'_, SPI, RDY, N>,
) -> Result<Option<ProcessedPair>>
where
    SPI: SpiDevice<Error: Send + Sync + 'static>,
    RDY: InputPin<Error: Send + Sync + 'static>,
{
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
pub(super) fn poll_pair<SPI, RDY, const N: usize>(
    app: &mut App<'_, SPI, RDY, N>,
) -> Result<ProcessedPair>
where
    SPI: SpiDevice<Error: Send + Sync + 'static>,
    RDY: InputPin<Error: Send + Sync + 'static>,
{
    poll_until_idle(app)?.context("no frame on the bus")
}
