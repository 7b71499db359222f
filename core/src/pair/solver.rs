//! Levenberg-Marquardt with a prior on one pair: one pass over the batch and one step at a time (`ESTIMATOR.md`,
//! section 5).
//!
//! A *search* starts far from the solution. It begins with an annealing: Geman-McClure's loss, whose first scale is
//! twice the median residual at the start or more. The scale falls until it is at most the width of the peak that the
//! residuals of inliers form. Without a peak it falls to about [`LEAST_SCALE_PX`]. The polish follows: Tukey's biweight
//! at the noise level, which each pass estimates until the estimate settles. If the annealing ends without a clear peak
//! ([`super::scale::Peak::is_doubtful`]), a second start comes before the polish ([`Rounds`]).
//!
//! A *track* starts at a running estimate with its covariance. It widens the loss of each correspondence by the
//! uncertainty of its predicted residual.
//!
//! Time: at most the given number of passes. Memory: constant, in addition to the batch.

use nalgebra::Vector5;

use super::descent::{Descent, Point};
use super::iterate::Iterate;
use super::leverage::Leverage;
use super::pass::PassSums;
use super::phase::{AfterAnnealing, Phase};
use super::proposal::{Rounds, is_small, scale};
use super::survey::{first_scale, scattered, survey};
use super::weighting::Weighting;
use crate::algebra::information::Information;
use crate::algebra::normal_equations::NormalEquations;
use crate::algebra::symmetric5::Symmetric5;
use crate::batch::correspondence::RayPair;
use crate::config::Config;
use crate::error::Rejection;
use crate::geometry::rectification::RectifyingRotations;
use crate::scalar::Scalar;
use crate::state::Stop;
use crate::thresholds::{
    LEAST_SCALE_PX, MIN_DISPARITY_PX, NEGLIGIBLE, PEAK_OVER_NOISE, SETTLED, SIGNIFICANT,
    TIGHT_TUKEY, TRACK_PASSES, TUKEY,
};

/// Start of a track.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TrackStart<T: Scalar> {
    /// Running estimate.
    pub(crate) pose: RectifyingRotations<T>,
    /// Covariance of the estimate, plus the variances of a vibration and [`crate::thresholds::FREEDOM_RAD`] squared,
    /// rad^2.
    pub(crate) covariance: Symmetric5<T>,
    /// Noise of a coordinate, px.
    pub(crate) noise: T,
    /// Whether correspondences of high leverage were inliers in the last pairs.
    pub(crate) trusts_leverage: bool,
    /// Whether the last pairs had a second group of matches beside the inliers
    /// ([`super::evaluate::PairMeasurement::crowd`]).
    pub(crate) sees_crowd: bool,
}

/// Solver of one pair, between two passes.
#[derive(Debug, Clone)]
pub(crate) struct PairSolver<T: Scalar> {
    pub(super) iterate: Iterate<T>,
    /// Prior information on the unknowns, about the start, 1/rad^2.
    prior: Information<T>,
    /// Whether correspondences of high leverage were inliers in the last pairs.
    trusts_leverage: bool,
    /// Sum of the steps from the start, rad.
    moved: Vector5<T>,
    /// Phase of the next pass.
    pub(super) phase: Phase<T>,
    /// Descent at the scale of the polish.
    descent: Descent<T>,
    /// Passes taken, without the evaluation.
    passes: u16,
    /// Largest number of passes, without the evaluation.
    max_passes: u16,
}

impl<T: Scalar> PairSolver<T> {
    /// Starts a search, with the prior of the configuration.
    ///
    /// * `focal`: mean focal length, px; `max_passes`: largest number of passes, evaluation included, at least 2.
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
            noise: T::lit(LEAST_SCALE_PX),
            tukey: T::lit(TUKEY),
            leverage: None,
            fitted: T::ZERO,
            min_disparity: -T::lit(MIN_DISPARITY_PX) / focal,
        };
        Self {
            iterate,
            prior: Information(Symmetric5::of_diagonal([config.prior(); 5])),
            trusts_leverage: false,
            moved: Vector5::zeros(),
            phase: Phase::Start,
            descent: Descent::NEW,
            passes: 0,
            max_passes: max_passes.saturating_sub(1).max(1),
        }
    }

    /// Starts a track; `None` if the covariance of the start has no inverse.
    pub(crate) fn track(config: &Config, focal: T, start: &TrackStart<T>) -> Option<Self> {
        let TrackStart { pose, covariance, noise, trusts_leverage, sees_crowd } = start;
        let mut track = Self::search(config, focal, *pose, TRACK_PASSES);
        track.prior = Information(covariance.inverse()?);
        track.phase = Phase::Survey(*covariance);
        track.iterate.noise = *noise;
        if *sees_crowd {
            track.iterate.tukey = T::lit(TIGHT_TUKEY);
        }
        track.trusts_leverage = *trusts_leverage;
        Some(track)
    }

    /// Takes one more pass: the survey of a track, a round of the second start, or a pass with its step. Does nothing
    /// if only the evaluation is left.
    ///
    /// # Errors
    /// [`Rejection::TooFew`]: a search has too few correspondences in front of both cameras.
    pub(crate) fn advance(&mut self, matches: &[RayPair<T>]) -> Result<(), Rejection> {
        match self.phase {
            Phase::Survey(covariance) => {
                self.iterate.leverage = self.survey(matches, &covariance);
                self.phase = Phase::Track(covariance);
                self.passes = 1;
            }
            Phase::Track(_) => self.step(&self.pass(matches), matches.len()),
            Phase::Start => {
                let scale = self.first_scale(matches);
                self.phase = Phase::Anneal { scale, is_second: false };
                self.search_step(matches)?;
            }
            Phase::Anneal { .. } | Phase::Polish => self.search_step(matches)?,
            Phase::SecondStart(rounds) => self.take_round(rounds, matches),
            Phase::Done(_) => {}
        }
        Ok(())
    }

    /// Returns the iterate at the current pose, for the evaluation.
    pub(crate) fn iterate(&self) -> &Iterate<T> {
        &self.iterate
    }

    /// Returns the reason for the end; [`Stop::PassesSpent`] while steps are left.
    pub(crate) fn stop(&self) -> Stop {
        if let Phase::Done(stop) = self.phase { stop } else { Stop::PassesSpent }
    }

    /// Returns whether only the evaluation is left.
    pub(crate) fn is_done(&self) -> bool {
        matches!(self.phase, Phase::Done(_))
    }

    /// Returns the first limit on leverage, at the start of a track. Out of line, because this bounds the stack of
    /// [`PairSolver::advance`].
    #[inline(never)]
    fn survey(&self, matches: &[RayPair<T>], covariance: &Symmetric5<T>) -> Option<Leverage<T>> {
        survey(&self.weighting(), scattered(matches), covariance)
    }

    /// Returns the first scale of a search, px. Out of line for the same reason as [`PairSolver::survey`].
    #[inline(never)]
    fn first_scale(&self, matches: &[RayPair<T>]) -> T {
        first_scale(&self.weighting(), scattered(matches))
    }

    /// Returns the sums over the batch at the pose.
    fn pass(&self, matches: &[RayPair<T>]) -> PassSums<T> {
        PassSums::of(&self.iterate, &self.phase, matches)
    }

    /// Takes a pass of a search, and its step.
    ///
    /// # Errors
    /// [`Rejection::TooFew`]: too few correspondences in front of both cameras.
    fn search_step(&mut self, matches: &[RayPair<T>]) -> Result<(), Rejection> {
        let pass = self.pass(matches);
        self.iterate.check(pass.usable)?;
        self.step(&pass, matches.len());
        Ok(())
    }

    /// Takes one step from the sums at the pose, then sets the next phase.
    ///
    /// The step `d` solves `(A + damping diag A) d = -(g + P m)`, where `A = H + P`, `P` is the prior information, and
    /// `m` the sum of the previous steps. At a fixed scale, a point of clearly higher cost is rejected, and the next
    /// step starts at the last accepted point with more damping. If no step exists, the solver ends with
    /// [`Stop::NoDescent`] at the last accepted pose.
    #[inline(never)]
    fn step(&mut self, pass: &PassSums<T>, matches: usize) {
        self.passes = self.passes.saturating_add(1);
        // A match behind a camera has the cost of an outlier.
        let behind = T::count(u32::try_from(matches).unwrap_or(u32::MAX)) - pass.usable;
        let cost = pass.cost + behind * T::lit(TUKEY * TUKEY / 6.0);
        let Self { iterate, moved, prior, .. } = &*self;
        let here = Point::of(&iterate.pose, moved, &pass.normal, cost, prior);
        match self.descent.rejects(&here) {
            Some(best) => self.go_back(&best),
            None => self.descend(pass, here),
        }
    }

    /// Returns to the last accepted point, and takes a step with more damping if passes are left. Ends the solver if
    /// none are left, or if no step exists.
    fn go_back(&mut self, best: &Point<T>) {
        (self.iterate.pose, self.moved) = (best.pose, best.moved);
        self.descent.damp();
        if self.passes >= self.max_passes {
            self.phase = Phase::Done(Stop::PassesSpent);
        } else if self.take_step(&best.joint).is_none() {
            self.phase = Phase::Done(Stop::NoDescent);
        }
    }

    /// Takes the step from the current pose. Returns the step, rad, and the inverse of the damped information, rad^2;
    /// `None` if no step exists. Without damping this inverse is the covariance of the pose.
    ///
    /// * `joint`: normal equations at the current pose, prior included.
    fn take_step(&mut self, joint: &NormalEquations<T>) -> Option<(Vector5<T>, Symmetric5<T>)> {
        let factor = joint.information.0.factor(self.descent.damping)?;
        let d = -factor.solve(&joint.gradient);
        self.iterate.pose = self.iterate.pose.stepped_by(&d)?;
        self.moved += d;
        Some((d, factor.inverse()))
    }

    /// Takes a step from `here`, the point of the pass. Then sets the next phase, and ends the solver if it has
    /// converged, if no step exists, or if no passes are left.
    fn descend(&mut self, pass: &PassSums<T>, here: Point<T>) {
        let Some((d, covariance)) = self.take_step(&here.joint) else {
            self.phase = Phase::Done(Stop::NoDescent);
            return;
        };
        let before = self.variance();
        if self.tighten(pass) {
            self.descent.accept(here);
        } else {
            self.descent.restart();
        }
        self.follow(pass, &covariance, before);
        let is_fixed = self.descent.best.is_some();
        let size = d.dot(&pass.normal.information.times(&d));
        if is_fixed && size <= T::lit(NEGLIGIBLE) {
            self.phase = Phase::Done(Stop::Converged);
        } else if self.passes >= self.max_passes {
            self.phase = Phase::Done(Stop::PassesSpent);
        }
    }

    /// Updates the quantities that follow from the covariance, for the next pass: number of fitted unknowns, limit on
    /// leverage, smallest disparity, and the loss of a track.
    ///
    /// * `covariance`: covariance of the pose, rad^2; `before`: residual variance that the loss of the pass assumed,
    ///   px^2.
    fn follow(&mut self, pass: &PassSums<T>, covariance: &Symmetric5<T>, before: T) {
        let information = &pass.normal.information.0;
        self.iterate.fitted = covariance.dot(information);
        let growth = self.variance() / before;
        let limit = Leverage::of(information, pass.weighted, covariance, growth);
        self.iterate.leverage = match (&self.phase, &self.iterate.leverage) {
            (Phase::Track(_), Some(last)) => limit.and_then(|limit| {
                limit.raised(information, last, &pass.high, self.trusts_leverage)
            }),
            _ => limit,
        };
        let [_, yaw, ..] = covariance.diagonal();
        self.iterate.min_disparity =
            -T::lit(MIN_DISPARITY_PX) / self.iterate.focal - T::lit(SIGNIFICANT) * yaw.sqrt();
        if let Phase::Track(of_pose) = &mut self.phase {
            *of_pose = *covariance;
        }
    }

    /// Runs one round of the second start, from the pose of the previous round. After the last round the annealing
    /// continues if a round has moved the pose; otherwise the polish begins.
    #[inline(never)]
    fn take_round(&mut self, mut rounds: Rounds, matches: &[RayPair<T>]) {
        self.passes = self.passes.saturating_add(1);
        let (by, noise) = (self.weighting(), self.iterate.noise);
        let scale = scale(noise);
        if let Some((pose, d)) = rounds.take(&self.iterate.pose, &by, matches, scale, &self.prior) {
            self.iterate.pose = pose;
            self.moved += d;
            rounds.moved = true;
        }
        // The limit on leverage of the annealing belongs to a wider loss, or to another pose.
        self.iterate.leverage = None;
        self.phase = if rounds.left > 0 && self.has_passes() {
            Phase::SecondStart(rounds)
        } else if rounds.moved {
            Phase::Anneal { scale, is_second: true }
        } else {
            Phase::Polish
        };
    }

    /// Returns whether passes are left for a round of the second start, and for a step after it.
    fn has_passes(&self) -> bool {
        self.passes.saturating_add(1) < self.max_passes
    }

    /// Returns the residual variance that the loss assumes, px^2.
    pub(super) fn variance(&self) -> T {
        self.phase.variance(self.iterate.noise)
    }

    /// Sets the next scale of the annealing, or the next estimate of the noise. Begins the second start if the
    /// annealing ends without a clear peak and enough passes are left. Returns whether the noise has settled. If so, it
    /// keeps its value, so that the costs of passes can be compared.
    fn tighten(&mut self, pass: &PassSums<T>) -> bool {
        let floor = self.iterate.noise_floor;
        let seen = pass.levels.peak(self.iterate.needed, pass.usable);
        let peak = seen.map(|peak| peak.level.max(floor));
        match self.phase {
            Phase::Anneal { scale, is_second } => {
                self.phase = match AfterAnnealing::of(scale, peak) {
                    AfterAnnealing::Scale(scale) => Phase::Anneal { scale, is_second },
                    AfterAnnealing::Polish(noise) => {
                        self.iterate.noise = noise;
                        let is_small = is_small(pass.usable);
                        let is_doubtful = seen.is_none_or(|peak| peak.is_doubtful(is_small));
                        if is_doubtful && !is_second && self.has_passes() {
                            Phase::SecondStart(Rounds::after_annealing(seen.is_some()))
                        } else {
                            Phase::Polish
                        }
                    }
                };
                false
            }
            Phase::Polish if pass.near > T::ZERO => {
                let estimate = self.iterate.noise_of(pass.near_squares, pass.near);
                let noise = peak.filter(|peak| *peak < T::lit(PEAK_OVER_NOISE) * estimate);
                let noise = noise.unwrap_or(estimate);
                let settled = (noise - self.iterate.noise).abs() <= T::lit(SETTLED) * noise;
                self.iterate.noise = if settled { self.iterate.noise } else { noise };
                settled
            }
            _ => false,
        }
    }

    /// Returns the weighting of the next pass.
    #[inline(never)]
    pub(super) fn weighting(&self) -> Weighting<T> {
        self.iterate.weighting(self.phase.loss())
    }
}

#[cfg(test)]
mod tests;
