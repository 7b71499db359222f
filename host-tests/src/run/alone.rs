//! Pairs alone: each solved by a calibrator that has seen no other, as `sigma_t` and `sigma_theta` ask for.
//!
//! In a run the robust preset tracks a pair from the running estimate, so that its solution there is not
//! that of the pair alone.

use stereo_selfcal::{Calibrator, Cameras, Config, Extrinsics, Scalar};

use crate::data::{Match, in_f64};

/// Solves pairs alone.
#[derive(Debug)]
pub struct PairSolver<T: Scalar, const N: usize> {
    calibrator: Box<Calibrator<T, N>>,
}

impl<T: Scalar, const N: usize> PairSolver<T, N> {
    /// * `start`: extrinsics that every pair starts from.
    #[must_use]
    pub fn new(config: Config, cameras: Cameras<T>, start: Extrinsics<T>) -> Self {
        let mut calibrator = Box::new(Calibrator::<T, N>::new(config));
        calibrator.set_cameras(cameras);
        calibrator.set_factory(start);
        Self { calibrator }
    }

    /// The estimate from one pair; `None` if it is not solved, or not fused.
    pub fn solve(&mut self, pair: &[Match]) -> Option<Extrinsics<f64>> {
        self.calibrator.reset();
        self.calibrator.clear_pair();
        for m in pair {
            // A refused match does not count, as in the run.
            let _ = self.calibrator.push(&m.correspondence());
        }
        let solved = self.calibrator.solve_pair().is_ok() && self.calibrator.fuse().is_ok();
        let found = self.calibrator.proposal().filter(|_| solved);
        found.map(|proposal| in_f64(&proposal.extrinsics))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{CAPACITY, replay};
    use crate::synth::Scene;

    #[test]
    fn a_pair_alone_has_the_same_estimate_whatever_came_before() {
        let set = Scene { outliers: 0.3, ..Scene::default() }.dataset(4, 1).unwrap();
        let start = Extrinsics::SIDE_BY_SIDE;
        let new = || {
            let cameras = set.cameras().unwrap();
            PairSolver::<f32, CAPACITY>::new(Config::robust(), cameras, start)
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
