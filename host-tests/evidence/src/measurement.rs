//! Measurements: taken once, on all cores, and cached.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use anyhow::{Context, Result};
use indicatif::ProgressBar;
use rayon::prelude::*;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::cache::Cache;

/// An independent measurement: its serialized form determines its outcome.
pub trait Measurement: Serialize + Sync {
    /// Its result.
    type Outcome: Serialize + DeserializeOwned + Send;

    /// Name of this kind of measurement; unique.
    const KIND: &'static str;

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

/// Takes measurements, or reads them from the cache.
pub struct Runner<'a> {
    cache: &'a Cache,
    bar: &'a ProgressBar,
    measurements: AtomicUsize,
    reused: AtomicUsize,
    failed: Mutex<Vec<(String, String)>>,
}

/// Numbers of measurements by their outcome.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeasurementCounts {
    /// All measurements.
    pub measurements: usize,
    /// Measurements from an earlier run.
    pub reused: usize,
    /// Measurements without an outcome, and why, in order.
    pub failed: Vec<(String, String)>,
}

impl<'a> Runner<'a> {
    /// * `bar`: advances with every measurement.
    #[must_use]
    pub fn new(cache: &'a Cache, bar: &'a ProgressBar) -> Self {
        let [measurements, reused] = [0, 0].map(AtomicUsize::new);
        Self { cache, bar, measurements, reused, failed: Mutex::new(Vec::new()) }
    }

    /// Outcomes in the order of the measurements.
    ///
    /// # Errors
    /// If the cache cannot be written. A measurement that fails or panics has an error as its outcome.
    pub fn run<C: Measurement>(&self, measurements: &[C]) -> Result<Vec<Measured<C::Outcome>>> {
        self.bar.inc_length(measurements.len() as u64);
        measurements.par_iter().map(|measurement| self.one(measurement)).collect()
    }

    /// Counts of all measurements so far.
    #[must_use]
    pub fn counts(&self) -> MeasurementCounts {
        let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner).clone();
        failed.sort();
        failed.dedup();
        MeasurementCounts {
            measurements: self.measurements.load(Ordering::Relaxed),
            reused: self.reused.load(Ordering::Relaxed),
            failed,
        }
    }

    fn one<C: Measurement>(&self, measurement: &C) -> Result<Measured<C::Outcome>> {
        self.measurements.fetch_add(1, Ordering::Relaxed);
        let key =
            serde_json::to_string(&(C::KIND, measurement)).context("a measurement has no key")?;
        let known = self.cache.get(&key);
        // An outcome that does not parse is measured again.
        let known = known.and_then(|value| serde_json::from_value(value.clone()).ok());
        if let Some(outcome) = known {
            self.reused.fetch_add(1, Ordering::Relaxed);
            self.bar.inc(1);
            return Ok(Ok(outcome));
        }
        self.bar.set_message(measurement.label());
        let outcome = match catch_unwind(AssertUnwindSafe(|| measurement.measure())) {
            Ok(outcome) => outcome.map_err(|error| format!("{error:#}")),
            Err(panic) => Err(format!("it panicked: {}", words(&*panic))),
        };
        match &outcome {
            Ok(outcome) => self.cache.put(&key, serde_json::to_value(outcome)?)?,
            Err(why) => {
                let mut failed = self.failed.lock().unwrap_or_else(PoisonError::into_inner);
                failed.push((measurement.label(), why.clone()));
            }
        }
        self.bar.inc(1);
        Ok(outcome)
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

    #[derive(Serialize)]
    struct Half(u32);

    impl Measurement for Half {
        type Outcome = f64;
        const KIND: &'static str = "half";

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

    fn run(dir: &std::path::Path) -> (Vec<Measured<f64>>, MeasurementCounts) {
        let cache = Cache::open(dir, false).unwrap();
        let bar = ProgressBar::hidden();
        let runner = Runner::new(&cache, &bar);
        (runner.run(&[2, 7, 4, 9].map(Half)).unwrap(), runner.counts())
    }

    #[test]
    fn measurements_are_taken_once_and_failures_reported_each_time() {
        let dir = tempfile::tempdir().unwrap();
        let (first, counts) = run(dir.path());
        assert_eq!((first[0].clone(), first[2].clone()), (Ok(1.0), Ok(2.0)));
        assert_eq!((counts.measurements, counts.reused), (4, 0));
        let failed = [("half of 7", "seven is odd"), ("half of 9", "it panicked: nine")];
        assert_eq!(counts.failed, failed.map(|(what, why)| (what.to_owned(), why.to_owned())));
        let (again, tally_again) = run(dir.path());
        assert_eq!(again, first);
        assert_eq!(tally_again, MeasurementCounts { reused: 2, ..counts });
    }
}
