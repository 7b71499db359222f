//! Measurements: taken on all cores; a failure or a panic is an outcome too.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};

use anyhow::Result;
use indicatif::ProgressBar;
use rayon::prelude::*;

/// An independent measurement.
pub trait Measurement: Sync {
    /// Its result.
    type Outcome: Send;

    /// Its name in messages: the quantity, and after the last comma its view or scenes.
    fn label(&self) -> String;

    /// Measures it deterministically: without threads or clock, and with seeded random numbers only.
    ///
    /// # Errors
    /// Why there is no outcome.
    fn measure(&self) -> Result<Self::Outcome>;
}

/// The outcome of a measurement, or the reason for its absence.
pub type Measured<T> = Result<T, String>;

/// Takes measurements, and counts them.
#[derive(Debug)]
pub struct Runner<'a> {
    bar: &'a ProgressBar,
    counts: Mutex<MeasurementCounts>,
}

/// Numbers of measurements by their outcome.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct MeasurementCounts {
    /// All measurements.
    pub measurements: usize,
    /// Measurements without an outcome, and why, in order.
    pub failed: Vec<(String, String)>,
}

impl<'a> Runner<'a> {
    /// * `bar`: advances with every measurement.
    #[must_use]
    pub fn new(bar: &'a ProgressBar) -> Self {
        Self { bar, counts: Mutex::default() }
    }

    /// Outcomes in the order of the measurements. A measurement that fails or panics has an error as its outcome.
    pub fn run<C: Measurement>(&self, measurements: &[C]) -> Vec<Measured<C::Outcome>> {
        self.bar.inc_length(measurements.len() as u64);
        measurements.par_iter().map(|measurement| self.one(measurement)).collect()
    }

    /// Counts of all measurements so far.
    #[must_use]
    pub fn counts(&self) -> MeasurementCounts {
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner).clone();
        counts.failed.sort();
        counts.failed.dedup();
        counts
    }

    fn one<C: Measurement>(&self, measurement: &C) -> Measured<C::Outcome> {
        self.bar.set_message(measurement.label());
        let outcome = match catch_unwind(AssertUnwindSafe(|| measurement.measure())) {
            Ok(outcome) => outcome.map_err(|error| format!("{error:#}")),
            Err(panic) => Err(format!("it panicked: {}", words(&*panic))),
        };
        let mut counts = self.counts.lock().unwrap_or_else(PoisonError::into_inner);
        counts.measurements += 1;
        let why = outcome.as_ref().err();
        counts.failed.extend(why.map(|why| (measurement.label(), why.clone())));
        self.bar.inc(1);
        outcome
    }
}

fn words(panic: &(dyn std::any::Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or(panic.downcast_ref::<String>().map(String::as_str)).unwrap_or("without a word")
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::bail;

    struct Half(u32);

    impl Measurement for Half {
        type Outcome = f64;

        fn label(&self) -> String {
            format!("half of {}", self.0)
        }

        fn measure(&self) -> Result<f64> {
            match self.0 {
                7 => bail!("seven is odd"),
                9 => panic!("nine"),
                n => Ok(f64::from(n) / 2.0),
            }
        }
    }

    #[test]
    fn failures_and_panics_are_named_beside_the_outcomes() {
        let bar = ProgressBar::hidden();
        let runner = Runner::new(&bar);
        let found = runner.run(&[2, 7, 4, 9].map(Half));
        let counts = runner.counts();
        assert_eq!((found[0].clone(), found[2].clone()), (Ok(1.0), Ok(2.0)));
        let failed = [("half of 7", "seven is odd"), ("half of 9", "it panicked: nine")];
        let failed = failed.map(|(what, why)| (what.to_owned(), why.to_owned())).to_vec();
        assert_eq!(counts, MeasurementCounts { measurements: 4, failed });
    }
}
