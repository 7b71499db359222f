//! Pairs alone: a calibrator without earlier pairs solves each pair, as the definition of `sigma_t` and `sigma_theta`
//! (eqs 25, 26) requires.
//!
//! In a run, the robust preset solves a pair from the running estimate if there is one, so the solution depends on
//! earlier pairs.

use stereo_selfcal::{Calibrator, Config, Extrinsics, FactoryCalibration, PairReport, Scalar};

use rigs::data::{Match, in_f64};

/// Returns the report of the default calibrator on one pair, of up to 1024 matches; `None` if the pair is not solved.
/// A match without a ray is left out.
pub fn report_alone(factory: &FactoryCalibration<f64>, pair: &[Match]) -> Option<PairReport<f64>> {
    let mut calibrator = Box::new(Calibrator::<f64, 1024>::new(Config::robust(), factory));
    calibrator.take_pair(pair.iter().map(Match::correspondence)).pair
}

/// Solves pairs alone.
#[derive(Debug)]
pub struct PairSolver<T: Scalar, const N: usize> {
    calibrator: Box<Calibrator<T, N>>,
}

impl<T: Scalar, const N: usize> PairSolver<T, N> {
    /// * `factory`: factory calibration, whose extrinsics every pair starts from.
    pub fn new(config: Config, factory: &FactoryCalibration<T>) -> Self {
        Self { calibrator: Box::new(Calibrator::new(config, factory)) }
    }

    /// The estimate from one pair; `None` if the pair is not solved, or not fused.
    pub fn solve(&mut self, pair: &[Match]) -> Option<Extrinsics<f64>> {
        self.calibrator.reset();
        // As in a run, a refused match is left out.
        let outcome = self.calibrator.take_pair(pair.iter().map(Match::correspondence));
        let found = self.calibrator.proposal().filter(|_| outcome.fused.is_ok());
        found.map(|proposal| in_f64(&proposal.extrinsics))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Start, replay};
    use crate::synth::Scene;

    #[test]
    fn the_estimate_from_a_pair_alone_does_not_depend_on_earlier_pairs() {
        let set = Scene { outliers: 0.3, ..Scene::default() }.dataset(4, 1).unwrap();
        let start = Extrinsics::SIDE_BY_SIDE;
        let new = || {
            let cameras = set.cameras().unwrap();
            let factory = FactoryCalibration::new(cameras, start);
            PairSolver::<f32, 2048>::new(Config::robust(), &factory)
        };
        let mut one = new();
        for pair in &set.pairs {
            let found = one.solve(pair);
            assert!(found.is_some());
            assert_eq!(found, new().solve(pair));
        }
        assert_eq!(one.solve(&set.pairs[0][..3]), None);
        assert_eq!(one.solve(&set.pairs[0]), new().solve(&set.pairs[0]));
        // In the run, the fourth pair starts from the running estimate.
        let run = replay::<f32>(&set, Config::robust(), Start::Guess, |_| ()).unwrap();
        let solved = run.steps()[3].solved.unwrap().extrinsics;
        assert_ne!(Some(solved), new().solve(&set.pairs[3]));
    }
}
