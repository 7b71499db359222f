//! A row a pair: what both made of it, and whether that is the same.

use std::io::Write;

use anyhow::Result;
use firmware_sim::Controller;
use host_tests::data::{Dataset, in_f64};
use host_tests::run::{RunLog, Step};

use super::super::drive::Driven;
use super::compare::Difference;

/// Differences that are shown of a pair.
const SHOWN: usize = 3;

/// The rows so far.
pub(super) struct Table {
    log: RunLog,
}

impl Table {
    /// Of a calibrator that has seen nothing yet.
    ///
    /// # Errors
    /// If the truth of the data set is not that of a rig.
    pub(super) fn new(set: &Dataset, calibrator: &Controller) -> Result<Self> {
        let log = RunLog::new(set.truth()?, in_f64(calibrator.in_use()));
        Ok(Self { log: log.with_truths(set.truths()?) })
    }

    pub(super) fn heading(out: &mut impl Write) -> Result<()> {
        Ok(writeln!(out, "pair bits    {}", Step::HEADING)?)
    }

    /// * `offered`: matches of the pair.
    /// * `calibrator`: after it.
    pub(super) fn row(
        &mut self,
        out: &mut impl Write,
        offered: usize,
        driven: &Driven,
        calibrator: &Controller,
        found: &[Difference],
    ) -> Result<()> {
        let number = self.log.steps().len();
        let bits = if found.is_empty() { "same" } else { "DIFFER" };
        let counts = [offered, driven.taken];
        let estimate = calibrator.proposal();
        let step = self.log.record(counts, driven.pair.outcome, estimate.as_ref());
        writeln!(out, "{number:>4} {bits:<7} {step}")?;
        if let Some([before, after]) = driven.change {
            writeln!(out, "     {before} -> {after}")?;
        }
        for difference in found.iter().take(SHOWN) {
            writeln!(out, "     {difference}")?;
        }
        if found.len() > SHOWN {
            writeln!(out, "     and {} parts more", found.len() - SHOWN)?;
        }
        Ok(())
    }
}
