//! Every pair of a data set onto the bus, and the application polled until it is done with it.

use std::io::Write;

use anyhow::Result;
use embedded_hal::digital::InputPin;
use embedded_hal::spi::SpiDevice;
use firmware_sim::App;
use host_tests::data::{Dataset, in_f64};
use host_tests::run::{RunLog, Step, progress};
use host_tests::wire::SimMatcher;
use stereo_selfcal::Health;

use super::drive::{Driven, drive};

/// A run of the application over a data set.
pub(super) struct Run {
    /// Pair by pair, against the truth.
    pub(super) log: RunLog,
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
    let mut run = Run { log: RunLog::new(set.truth()?, start), health: None };
    let bar = progress::over(set.pairs.len(), "pairs");
    writeln!(out, "pair {}", Step::HEADING)?;
    for (sequence, pair) in (0_u32..).zip(&set.pairs) {
        matcher.send(sequence, pair);
        let Driven { taken, pair: solved, change } = drive(app)?;
        let estimate = app.calibrator().proposal();
        let counts = [pair.len(), taken];
        let step = run.log.record(counts, solved.outcome, estimate.as_ref());
        bar.suspend(|| {
            writeln!(out, "{sequence:>4} {step}")?;
            change.map_or(Ok(()), |[before, after]| writeln!(out, "     {before} -> {after}"))
        })?;
        run.health = solved.health.or(run.health);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(run)
}
