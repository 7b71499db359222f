//! The application polled until it is done with the pair on the bus.

use anyhow::{Context, Result};
use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use firmware_sim::{App, Event, PairOutcome};
use stereo_selfcal::State;

/// What the application did with a pair.
pub(super) struct Driven {
    /// Correspondences taken into the batch.
    pub(super) taken: usize,
    pub(super) pair: PairOutcome,
    /// State before and after, if it has changed.
    pub(super) change: Option<[State; 2]>,
}

/// Polls in the time from one pair to the next: more than the longest frame and solve take.
const POLLS: usize = 500;

/// Polls until nothing waits any more, or the time is over: what came of the last pair that was done with.
///
/// # Errors
/// If the bus fails.
pub(super) fn attend<SPI, RDY, const N: usize>(
    app: &mut App<'_, SPI, RDY, N>,
) -> Result<Option<Driven>>
where
    SPI: SpiDevice<Error: Send + Sync + 'static>,
    RDY: InputPin<Error: Send + Sync + 'static>,
{
    let (mut in_batch, mut done, mut change) = (0, None, None);
    for _ in 0..POLLS {
        match app.poll()? {
            Event::Frame { taken, .. } => in_batch = taken,
            Event::Pair(outcome) => done = Some(outcome),
            Event::StateChanged { before, after } => change = Some([before, after]),
            Event::Idle => break,
            _ => (),
        }
    }
    Ok(done.map(|pair| Driven { taken: in_batch, pair, change }))
}

/// As [`attend`], where there must be a pair.
///
/// # Errors
/// If the bus fails, or there was no frame on it.
pub(super) fn drive<SPI, RDY, const N: usize>(app: &mut App<'_, SPI, RDY, N>) -> Result<Driven>
where
    SPI: SpiDevice<Error: Send + Sync + 'static>,
    RDY: InputPin<Error: Send + Sync + 'static>,
{
    attend(app)?.context("the application saw no frame on the bus")
}
