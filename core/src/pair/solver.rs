//! Gauss-Newton with a prior on one pair: one pass over the batch and one step at a time (`ESTIMATOR.md`, section 5).
//!
//! A *search* starts from afar: Geman-McClure's loss at a scale that covers the prior, halved each pass, then Tukey's
//! biweight at the noise, which each pass estimates. A *track* starts at a running estimate with its covariance, and
//! widens the loss of each correspondence by the uncertainty of its residual.
//!
//! Time: at most the given number of passes. Memory: constant, beside the batch.

use nalgebra::Vector5;

use super::iterate::Iterate;
use super::leverage::Leverage;
use super::pass::{PassOver, PassSums};
use super::survey::{scattered, survey};
use super::sweep;
use super::weighting::{Loss, Weighting};
use crate::algebra::information::Information;
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::Matches;
use crate::config::Config;
use crate::error::PairError;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::simd::{Lanes, Single};
use crate::state::Stop;
use crate::thresholds::{
    ANNEALING, FIRST_NOISE_PX, FIRST_SCALE_PX, LAST_SCALE_PX, MIN_DISPARITY_PX, NEGLIGIBLE,
    SETTLED, SLOW_ANNEALING, TRACK_PASSES, TRACKED, YAW_DEVIATIONS,
};

/// Schedule of the loss.
#[derive(Debug, Clone, Copy)]
pub(super) enum Schedule<T> {
    /// Geman-McClure at this scale, px.
    Anneal(T),
    /// Tukey, its limit widened by the covariance of the pose, rad^2.
    Track(Symmetric5<T>),
    /// Tukey at the estimated noise.
    Polish,
}

/// Start of a track.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrackStart<T: Scalar> {
    /// Running estimate.
    pub(crate) pose: RectifyingRotations<T>,
    /// Covariance of the estimate plus that of a pair about it, rad^2.
    pub(crate) covariance: Symmetric5<T>,
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Whether correspondences of high leverage were inliers in the last pairs.
    pub(crate) trusts_leverage: bool,
}

/// Solver of one pair, between two passes.
#[derive(Debug, Clone)]
pub(crate) struct PairSolver<T: Scalar> {
    pub(super) iterate: Iterate<T>,
    /// Information about the start, 1/rad^2.
    prior: Information<T>,
    /// Whether correspondences of high leverage were inliers in the last pairs.
    trusts_leverage: bool,
    /// Ratio of successive scales.
    annealing: T,
    /// Sum of the steps from the start, rad.
    moved: Vector5<T>,
    /// Loss of the next pass.
    pub(super) schedule: Schedule<T>,
    /// Passes taken, without that of the evaluation.
    passes: u16,
    max_passes: u16,
    /// Reason of the end; `None` while steps are left.
    stop: Option<Stop>,
}

impl<T: Scalar> PairSolver<T> {
    /// Starts a search, with the prior of the configuration.
    ///
    /// * `focal`: mean focal length, px; `max_passes`: with that of the evaluation.
    pub(crate) fn search(
        config: &Config,
        focal: T,
        start: RectifyingRotations<T>,
        max_passes: u16,
    ) -> Self {
        let iterate = Iterate {
            focal,
            noise_floor: T::single(config.noise_floor_px),
            needed: config.min_correspondences,
            start,
            pose: start,
            noise: T::lit(FIRST_NOISE_PX),
            leverage: None,
            fitted: T::ZERO,
            min_disparity: -T::lit(MIN_DISPARITY_PX) / focal,
        };
        Self {
            iterate,
            prior: Information(Symmetric5::of_diagonal([config.prior(); 5])),
            trusts_leverage: false,
            annealing: T::lit(ANNEALING),
            moved: Vector5::zeros(),
            schedule: Schedule::Anneal(T::lit(FIRST_SCALE_PX)),
            passes: 0,
            max_passes: max_passes.saturating_sub(1).max(1),
            stop: None,
        }
    }

    /// Anneals slower, in twice the passes: the sums of a small batch follow only small changes of the loss.
    pub(crate) fn among_few(self) -> Self {
        let max_passes = self.max_passes.saturating_mul(2).saturating_add(1);
        Self { annealing: T::lit(SLOW_ANNEALING), max_passes, ..self }
    }

    /// Starts a track; `None` if the covariance of the start has no inverse.
    pub(crate) fn track(config: &Config, focal: T, start: &TrackStart<T>) -> Option<Self> {
        let TrackStart { pose, covariance, noise, trusts_leverage } = start;
        let mut track = Self::search(config, focal, *pose, TRACK_PASSES);
        track.prior = Information(covariance.inverse()?);
        track.schedule = Schedule::Track(*covariance);
        track.iterate.noise = *noise;
        track.trusts_leverage = *trusts_leverage;
        Some(track)
    }

    /// Takes one more pass and step, unless only the evaluation is left.
    ///
    /// # Errors
    /// [`PairError::TooFew`] in front of both cameras.
    pub(crate) fn advance(&mut self, matches: Matches<'_, T>) -> Result<(), PairError> {
        match (&self.stop, &self.schedule) {
            (Some(_), _) => (),
            (None, Schedule::Track(covariance)) if self.passes == 0 => {
                self.iterate.leverage = self.survey(matches, covariance);
                self.passes = 1;
            }
            (None, Schedule::Track(_)) => {
                self.step(&self.pass(matches, TRACKED.max(matches.pairs.len() / 2)));
            }
            (None, Schedule::Anneal(_) | Schedule::Polish) => {
                let pass = self.pass(matches, usize::MAX);
                self.iterate.check(pass.usable)?;
                self.step(&pass);
            }
        }
        Ok(())
    }

    /// The pose reached, for the evaluation.
    pub(crate) fn iterate(&self) -> &Iterate<T> {
        &self.iterate
    }

    /// Reason of the end.
    pub(crate) fn stop(&self) -> Stop {
        self.stop.unwrap_or(Stop::PassesSpent)
    }

    /// Whether only the evaluation is left.
    pub(crate) fn is_done(&self) -> bool {
        self.stop.is_some()
    }

    /// First limit on leverage, at the start of a track. Out of line: bounds the stack of [`PairSolver::advance`].
    #[inline(never)]
    fn survey(&self, matches: Matches<'_, T>, covariance: &Symmetric5<T>) -> Option<Leverage<T>> {
        survey(&self.weighting(Single), scattered(matches.pairs), covariance)
    }

    /// Sums over the batch at the pose.
    ///
    /// * `most`: correspondences to read, evenly spread.
    #[inline(never)]
    fn pass(&self, matches: Matches<'_, T>, most: usize) -> PassSums<T> {
        let mut pass = PassOver { solver: self, sums: PassSums::ZERO };
        sweep::run(&mut pass, matches, most);
        pass.sums
    }

    /// Takes one Gauss-Newton step from the sums at the pose, then the next loss of the schedule.
    ///
    /// `(H + P) d = -(g + P m)` with the prior `P` and the sum `m` of the steps so far. No factor of `H + P`, or a step
    /// beyond the limits of a rig, ends the pair with [`Stop::NoDescent`] at the pose before.
    #[inline(never)]
    fn step(&mut self, pass: &PassSums<T>) {
        self.passes = self.passes.saturating_add(1);
        let mut joint = pass.normal.with(&self.prior);
        joint.gradient += self.prior.times(&self.moved);
        let factor = joint.information.0.factor(T::ZERO);
        let stepped = factor.and_then(|factor| {
            let d = -factor.solve(&joint.gradient);
            Some((d, self.iterate.pose.stepped_by(&d)?, factor.inverse()))
        });
        let Some((d, pose, covariance)) = stepped else {
            self.stop = Some(Stop::NoDescent);
            return;
        };
        self.iterate.pose = pose;
        self.moved += d;
        let size = d.dot(&pass.normal.information.times(&d));
        let before = self.variance();
        let settled = self.tighten(pass);
        let information = &pass.normal.information.0;
        self.iterate.fitted = covariance.dot(information);
        let growth = self.variance() / before;
        let limit = Leverage::of(information, pass.weighted, &covariance, growth);
        self.iterate.leverage = match (&self.schedule, &self.iterate.leverage) {
            (Schedule::Track(_), Some(last)) => limit.and_then(|limit| {
                limit.raised(information, last, &pass.high, self.trusts_leverage)
            }),
            _ => limit,
        };
        let [_, yaw, ..] = covariance.diagonal();
        self.iterate.min_disparity =
            -T::lit(MIN_DISPARITY_PX) / self.iterate.focal - T::lit(YAW_DEVIATIONS) * yaw.sqrt();
        if let Schedule::Track(of_pose) = &mut self.schedule {
            *of_pose = covariance;
        }
        self.stop = if settled && size <= T::lit(NEGLIGIBLE) {
            Some(Stop::Converged)
        } else if self.passes >= self.max_passes {
            Some(Stop::PassesSpent)
        } else {
            None
        };
    }

    /// Residual variance that the loss assumes, px^2.
    pub(super) fn variance(&self) -> T {
        match self.schedule {
            Schedule::Anneal(scale) => scale * scale,
            Schedule::Track(_) | Schedule::Polish => self.iterate.noise * self.iterate.noise,
        }
    }

    /// Takes the next scale, or the next estimate of the noise; true once the noise has settled.
    fn tighten(&mut self, pass: &PassSums<T>) -> bool {
        match self.schedule {
            Schedule::Anneal(scale) => {
                let next = scale * self.annealing;
                let last = next <= T::lit(LAST_SCALE_PX);
                self.schedule = if last { Schedule::Polish } else { Schedule::Anneal(next) };
                false
            }
            Schedule::Polish if pass.near > T::ZERO => {
                let noise = self.iterate.noise_of(pass.near_squares, pass.near);
                let change = (noise - self.iterate.noise).abs();
                self.iterate.noise = noise;
                change <= T::lit(SETTLED) * noise
            }
            Schedule::Track(_) | Schedule::Polish => false,
        }
    }

    /// Weighting of the next pass.
    #[inline(always)]
    pub(super) fn weighting<L: Lanes<T>>(&self, lanes: L) -> Weighting<L::Value> {
        let loss = match &self.schedule {
            Schedule::Anneal(scale) => Loss::Anneal(lanes.splat(T::ONE / (*scale * *scale))),
            Schedule::Track(covariance) => Loss::Track(covariance.0.map(|c| lanes.splat(c))),
            Schedule::Polish => Loss::Polish,
        };
        self.iterate.weighting(lanes, loss)
    }
}
