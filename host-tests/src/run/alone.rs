//! Pairs alone: a fresh calibrator solves each, as `sigma_t` and `sigma_theta` require.
//!
//! In a run the robust preset tracks a pair from the running estimate, so its solution there depends on earlier pairs.

use stereo_selfcal::{Calibrator, Config, Extrinsics, FactoryCalibration, Scalar};

use crate::data::{Match, in_f64};

/// Solves pairs alone.
#[derive(Debug)]
pub struct PairSolver<T: Scalar, const N: usize> {
    calibrator: Box<Calibrator<T, N>>,
}

impl<T: Scalar, const N: usize> PairSolver<T, N> {
    /// * `factory`: start of every pair.
    #[must_use]
    pub fn new(config: Config, factory: &FactoryCalibration<T>) -> Self {
        Self { calibrator: Box::new(Calibrator::new(config, factory)) }
    }

    /// The estimate from one pair; `None` if it is not solved, or not fused.
    pub fn solve(&mut self, pair: &[Match]) -> Option<Extrinsics<f64>> {
        self.calibrator.reset();
        // A refused match does not count, as in the run.
        let outcome = self.calibrator.take_pair(pair.iter().map(Match::correspondence));
        let found = self.calibrator.proposal().filter(|_| outcome.fused.is_ok());
        found.map(|proposal| in_f64(&proposal.extrinsics))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::replay;
    use crate::synth::Scene;

    #[test]
    fn a_pair_alone_has_the_same_estimate_whatever_came_before() {
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
        // The run tracks its later pairs.
        let run = replay::<f32>(&set, Config::robust(), start, |_| ()).unwrap();
        let solved = run.steps()[3].solved.unwrap().extrinsics;
        assert_ne!(Some(solved), new().solve(&set.pairs[3]));
    }
}
