//! Replay of the published method. It has no calibration in use and no verdict, and takes no witnesses.

use stereo_selfcal::depth::RangeReading;
use stereo_selfcal::paper::{PaperCalibrator, Settings};
use stereo_selfcal::{Extrinsics, FactoryCalibration, Outcome, Rejection, Scalar};

use super::estimate::Estimate;
use super::log::RunLog;
use super::refused::{self, CountByReason, WitnessCounts};
use super::replayed::{Apply, Replayed};
use rigs::data::tracked::Track;
use rigs::data::{Match, in_f64};

/// The calibrator of a run, and another one that solves each pair alone.
#[derive(Debug)]
pub(super) struct Published<T: Scalar, const N: usize> {
    calibrator: Box<PaperCalibrator<T, N>>,
    alone: Box<PaperCalibrator<T, N>>,
}

impl<T: Scalar, const N: usize> Published<T, N> {
    /// The method from the cameras and extrinsics of a factory calibration.
    pub(super) fn new(settings: Settings, made: &FactoryCalibration<T>) -> Self {
        let calibrator = PaperCalibrator::new(settings, made.cameras, made.extrinsics);
        Self { alone: Box::new(calibrator.clone()), calibrator: Box::new(calibrator) }
    }

    /// The estimate from one pair; `None` if the pair is not solved, or not fused.
    fn alone(&mut self, pair: &[Match]) -> Option<Extrinsics<f64>> {
        self.alone.reset();
        let outcome = self.alone.take_pair(pair.iter().map(Match::correspondence));
        let found = self.alone.estimate().filter(|_| outcome.fused.is_ok());
        found.map(|estimate| in_f64(&estimate.extrinsics))
    }
}

impl<T: Scalar, const N: usize> Replayed for Published<T, N> {
    fn take(
        &mut self,
        pair: &[Match],
        _: (&[RangeReading<f64>], &[Track]),
        _: Apply,
        log: &mut RunLog,
    ) {
        let mut refused = CountByReason::new();
        for m in pair {
            if let Err(why) = self.calibrator.push(&m.correspondence()) {
                *refused.entry(refused::of_match(why)).or_default() += 1;
            }
        }
        let taken = self.calibrator.batch().matches().len();
        let Outcome { pair: report, fused } = self.calibrator.solve_pair();
        let outcome = report.map(|report| (report, fused)).ok_or(fused.err());
        let outcome = outcome.map_err(|why| why.unwrap_or(Rejection::NotBegun));
        let estimate = self.calibrator.estimate();
        log.record([pair.len(), taken], outcome, estimate.as_ref().map(Estimate::published));
        log.note_counts(refused, WitnessCounts::default());
        log.note_alone(self.alone(pair));
    }
}
