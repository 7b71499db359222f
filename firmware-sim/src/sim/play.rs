//! Every pair of a data set onto the bus, and the application polled until it is done with it.

use std::io::Write;

use anyhow::{Result, bail};
use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use firmware_sim::{App, Event, PairOutcome};
use host_tests::dataset::Dataset;
use host_tests::evaluation::{Evaluation, Step, in_f64};
use host_tests::progress;
use stereo_selfcal::Health;

use super::matcher::SimMatcher;

/// A run of the application over a data set.
pub(super) struct Run {
    /// Pair by pair, against the truth.
    pub(super) evaluation: Evaluation,
    /// As of the last pair that had matches to judge by.
    pub(super) health: Option<Health<f32>>,
}

/// Plays every pair, and prints a line about each.
///
/// # Errors
/// If the bus fails, or the truth of the data set is not valid.
pub(super) fn play<SPI, RDY, const N: usize>(
    set: &Dataset,
    matcher: &SimMatcher,
    app: &mut App<'_, SPI, RDY, N>,
    out: &mut impl Write,
) -> Result<Run>
where
    SPI: SpiDevice<Error: Send + Sync + 'static>,
    RDY: InputPin<Error: Send + Sync + 'static>,
{
    let start = in_f64(app.calibrator().in_use());
    let mut run = Run { evaluation: Evaluation::new(set.truth()?, start), health: None };
    let bar = progress::over(set.pairs.len(), "pairs");
    writeln!(out, "pair {}", Step::HEADING)?;
    for (sequence, pair) in (0_u32..).zip(&set.pairs) {
        matcher.send(sequence, pair);
        let (taken, solved) = finish_pair(app)?;
        let estimate = app.calibrator().proposal();
        let counts = [pair.len(), taken];
        let step = run.evaluation.record(counts, solved.outcome, estimate.as_ref());
        bar.suspend(|| writeln!(out, "{sequence:>4} {step}"))?;
        run.health = solved.health.or(run.health);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(run)
}

/// Polls from the frame to the end of its pair; how many correspondences were taken, and the outcome.
fn finish_pair<SPI, RDY, const N: usize>(
    app: &mut App<'_, SPI, RDY, N>,
) -> Result<(usize, PairOutcome)>
where
    SPI: SpiDevice<Error: Send + Sync + 'static>,
    RDY: InputPin<Error: Send + Sync + 'static>,
{
    let mut in_batch = 0;
    loop {
        match app.poll()? {
            Event::Frame { taken, .. } => in_batch = taken,
            Event::Pair(outcome) => return Ok((in_batch, outcome)),
            Event::Idle => bail!("the application saw no frame on the bus"),
            _ => (),
        }
    }
}
