//! One pair, by the method that the configuration names, one pass at a time.

use crate::config::{Config, Method};
use crate::correspondence::RayPair;
use crate::error::PairError;
use crate::extrinsics::Extrinsics;
use crate::huber::HuberSolver;
use crate::report::{PairReport, Stop};
use crate::robust::RobustSolver;
use crate::scalar::Scalar;

/// A pair on its way to its optimum.
#[derive(Debug, Clone)]
pub struct Solver<T: Scalar>(Kind<T>);

#[derive(Debug, Clone)]
enum Kind<T: Scalar> {
    Huber(HuberSolver<T>),
    Robust(RobustSolver<T>),
}

impl<T: Scalar> Solver<T> {
    /// Takes the first pass, at the start.
    ///
    /// * `focal`: mean focal length of the cameras, px.
    ///
    /// # Errors
    /// [`PairError::TooFew`], [`PairError::Unobservable`].
    pub fn begin(
        config: &Config,
        focal: T,
        start: &Extrinsics<T>,
        pairs: &[RayPair<T>],
    ) -> Result<Self, PairError> {
        Ok(Self(match config.method {
            Method::Paper => Kind::Huber(HuberSolver::begin(config, focal, start, pairs)?),
            Method::Robust => Kind::Robust(RobustSolver::begin(config, focal, start, pairs)?),
        }))
    }

    /// Takes one more pass: at most one step. `Some` when done.
    ///
    /// * `pairs`: the same at every call.
    pub fn advance(&mut self, pairs: &[RayPair<T>]) -> Option<Stop> {
        match &mut self.0 {
            Kind::Huber(solver) => solver.advance(pairs),
            Kind::Robust(solver) => solver.advance(pairs),
        }
    }

    /// Whether [`Solver::report`] is all that is left to do.
    pub fn is_done(&self) -> bool {
        match &self.0 {
            Kind::Huber(solver) => solver.is_done(),
            Kind::Robust(solver) => solver.is_done(),
        }
    }

    /// Judges the pose reached, in one pass (paper) or two (robust), and reports.
    ///
    /// # Errors
    /// [`PairError`]: what fits the pose does not determine it.
    pub fn report(&self, pairs: &[RayPair<T>]) -> Result<PairReport<T>, PairError> {
        match &self.0 {
            Kind::Huber(solver) => solver.report(pairs),
            Kind::Robust(solver) => solver.report(pairs),
        }
    }
}
