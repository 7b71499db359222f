//! One row per pair: the result, and whether both sides are bit-identical.

use std::io::Write;

use anyhow::Result;
use firmware_sim::Controller;
use rigs::data::{Dataset, in_f64};
use sim::run::{RunLog, Step};

use super::super::polling::ProcessedPair;
use super::compare::Difference;

/// Largest number of differences printed per pair.
const SHOWN: usize = 3;

/// The rows so far.
pub(super) struct Table {
    log: RunLog,
}

impl Table {
    /// A table without rows.
    ///
    /// * `calibrator`: calibrator before the first pair.
    ///
    /// # Errors
    /// If the true extrinsics of the data set are invalid.
    pub(super) fn new(set: &Dataset, calibrator: &Controller) -> Result<Self> {
        let log = RunLog::new(set.truth()?, in_f64(&calibrator.in_use().extrinsics));
        Ok(Self { log: log.with_truths(set.truths()?) })
    }

    pub(super) fn heading(out: &mut impl Write) -> Result<()> {
        Ok(writeln!(out, "pair bits    {}", Step::HEADING)?)
    }

    /// Prints the row of a pair.
    ///
    /// * `offered`: number of matches of the pair.
    /// * `calibrator`: after the pair.
    pub(super) fn row(
        &mut self,
        out: &mut impl Write,
        offered: usize,
        processed: &ProcessedPair,
        calibrator: &Controller,
        found: &[Difference],
    ) -> Result<()> {
        let number = self.log.steps().len();
        let bits = if found.is_empty() { "same" } else { "DIFFER" };
        let counts = [offered, processed.taken];
        let estimate = calibrator.proposal();
        let step = self.log.record(counts, processed.pair.outcome, estimate.as_ref());
        writeln!(out, "{number:>4} {bits:<7} {step}")?;
        if let Some([before, after]) = processed.change {
            writeln!(out, "     {before} -> {after}")?;
        }
        for difference in found.iter().take(SHOWN) {
            writeln!(out, "     {difference}")?;
        }
        if found.len() > SHOWN {
            writeln!(out, "     and {} more fields", found.len() - SHOWN)?;
        }
        Ok(())
    }
}
