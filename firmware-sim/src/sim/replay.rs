//! Replays a data set: sends each pair over the bus and polls the application.

use std::io::Write;

use anyhow::Result;
use rigs::data::{Dataset, in_f64};
use sim::run::{Estimate, PairSolver, RunLog, Step, progress};
use sim::wire::Sender;
use stereo_selfcal::{Config, FactoryCalibration};
use test_support::wire::Wire;

use super::polling::{ProcessedPair, SimApp, poll_pair};

/// A run of the application over a data set.
pub(super) struct Run {
    /// Errors after each pair, against the true extrinsics.
    pub(super) log: RunLog,
}

/// Replays every pair and prints its line.
///
/// # Errors
/// If the bus fails, or the true extrinsics of the data set are invalid.
pub(super) fn replay<const N: usize>(
    set: &Dataset,
    wire: &Wire,
    app: &mut SimApp<'_, N>,
    out: &mut impl Write,
) -> Result<Run> {
    let sender = Sender::of(set)?;
    let factory = app.calibrator().in_use().extrinsics;
    let guess = FactoryCalibration::new(set.cameras()?, factory).without_yaw();
    let start = in_f64(&factory);
    let mut run = Run { log: RunLog::new(set.truth()?, start) };
    let mut alone = PairSolver::<f32, N>::new(Config::robust(), &guess);
    let bar = progress::over(set.pairs.len(), "pairs");
    writeln!(out, "pair {}", Step::HEADING)?;
    for (sequence, pair) in (0_u32..).zip(&set.pairs) {
        wire.send(sender.frame(sequence, pair).0);
        let ProcessedPair { taken, pair: solved, change } = poll_pair(app)?;
        let estimate = app.calibrator().proposal();
        let counts = [pair.len(), taken];
        run.log.record(counts, solved.outcome, estimate.as_ref().map(Estimate::of));
        run.log.note_alone(alone.solve(pair));
        let Some(step) = run.log.steps().last() else { continue };
        bar.suspend(|| {
            writeln!(out, "{sequence:>4} {step}")?;
            change.map_or(Ok(()), |[before, after]| writeln!(out, "     {before} -> {after}"))
        })?;
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(run)
}
