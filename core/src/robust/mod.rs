//! One pair among mismatches: whitened residuals under a redescending loss, one pass at a time.
//!
//! Two ways to the optimum, each pass one Gauss-Newton step with a prior. *Search* comes from afar:
//! Geman-McClure's loss from a scale that covers the prior, halved each pass, then Tukey's biweight at
//! the noise, which is estimated on the way. *Track* starts at a running estimate with its 5 x 5
//! information: the loss of each correspondence is as wide as that leaves its residual uncertain.
//! A correspondence that would carry many times its share of the information is held down: a gross
//! mismatch with a huge disparity near its epipolar line fits any pose, and no residual tells it from
//! a near point.

mod constraint;
mod hearing;
mod in_fours;
#[cfg(feature = "simd")]
mod judged_side_by_side;
mod judgement;
mod leverage;
mod outlook;
mod pass;
#[cfg(test)]
mod scenes;
#[cfg(feature = "simd")]
mod side_by_side;
mod tallies;
mod tally;
mod weighing;
mod weight;

pub(crate) use judgement::{Evidence, Judged};

use nalgebra::Vector5;

use crate::batch::Matches;
use crate::config::Config;
use crate::error::PairError;
use crate::information::Information;
use crate::rectification::RectifyingRotations;
use crate::report::Stop;
use crate::scalar::Scalar;
use crate::symmetric::Symmetric;
use leverage::Leverage;
use outlook::Outlook;
use pass::Pass;

/// First scale of the loss, px: 5 degrees at a focal length of 1400 px.
const FIRST_SCALE_PX: f64 = 120.0;

/// Each scale over the one before among few correspondences.
const SLOW_ANNEALING: f64 = 0.7;

/// The scale below which the noise takes over, px.
const LAST_SCALE_PX: f64 = 7.5;

/// Tukey's limit in standard deviations: 95 % efficient on Gaussian noise.
const TUKEY: f64 = 4.685;

/// Noise of a coordinate to begin with, which a consensus stays below, and at most, px.
const NOISE_PX: [f64; 2] = [1.5, 3.0];

/// A match this far behind infinity is none, px: noise may reach below a disparity of 0. While the
/// estimate is loose its yaw moves all disparities by more.
const MIN_DISPARITY_PX: f64 = 4.0;

/// Converged when the step, in standard deviations of the estimate, squared, is below this. The next ones
/// would be shorter by a factor of two to three each: what is left adds less than half a per cent to the variance.
const NEGLIGIBLE: f64 = 1e-2;

/// The noise has settled when it changes by no more than this share.
const SETTLED: f64 = 0.05;

/// Passes of a track: a survey, two steps and the judgement.
pub(crate) const TRACK_PASSES: u16 = 4;

/// Correspondences that each step of a track looks at where there are no more than twice as many: of a
/// larger batch every second one. The pose that they lead to decides weights only; what the batch says
/// is summed over all of it.
const TRACKED: usize = 128;

/// The loss of a pass.
#[derive(Debug, Clone, Copy)]
enum Stage<T> {
    /// Geman-McClure at this scale, px.
    Anneal(T),
    /// As wide as the estimate's own uncertainty (covariance, rad^2) asks for.
    Follow(Symmetric<T>),
    /// Tukey at the noise.
    Polish,
}

/// What is known before a pair is tracked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known<T: Scalar> {
    pub(crate) pose: RectifyingRotations<T>,
    /// Of the estimate, with what a pair may differ from it, rad^2.
    pub(crate) covariance: Symmetric<T>,
    /// Of a coordinate, px.
    pub(crate) noise: T,
}

/// A pair on its way to its optimum.
#[derive(Debug, Clone)]
pub(crate) struct Descent<T: Scalar> {
    at: Outlook<T>,
    /// About the start.
    prior: Information<T>,
    /// Each scale of the loss over the one before.
    annealing: T,
    /// Sum of the steps taken from the start.
    moved: Vector5<T>,
    stage: Stage<T>,
    passes: u16,
    max_passes: u16,
    stop: Option<Stop>,
}

impl<T: Scalar> Descent<T> {
    /// From afar.
    ///
    /// * `start`: known to the configuration's prior.
    /// * `max_passes`: the judging one included.
    pub(crate) fn search(
        config: &Config,
        focal: T,
        start: RectifyingRotations<T>,
        max_passes: u16,
    ) -> Self {
        let at = Outlook {
            focal,
            noise_floor: T::single(config.noise_floor_px),
            needed: config.min_correspondences.into(),
            start,
            pose: start,
            noise: T::lit(NOISE_PX[0]),
            leverage: None,
            fitted: T::ZERO,
            min_disparity: -T::lit(MIN_DISPARITY_PX) / focal,
        };
        Self {
            at,
            prior: Information(Symmetric::of_diagonal([config.prior(); 5])),
            annealing: T::HALF,
            moved: Vector5::zeros(),
            stage: Stage::Anneal(T::lit(FIRST_SCALE_PX)),
            passes: 0,
            max_passes: max_passes.saturating_sub(1).max(1),
            stop: None,
        }
    }

    /// The same among few correspondences, which follow only small changes of the loss: in twice the
    /// passes, which is no more work.
    pub(crate) fn among_few(self) -> Self {
        let max_passes = self.max_passes.saturating_mul(2).saturating_add(1);
        Self { annealing: T::lit(SLOW_ANNEALING), max_passes, ..self }
    }

    /// From a running estimate.
    ///
    /// `None` if the covariance has no inverse.
    pub(crate) fn track(config: &Config, focal: T, known: &Known<T>) -> Option<Self> {
        let Known { pose, covariance, noise } = known;
        let mut track = Self::search(config, focal, *pose, TRACK_PASSES);
        track.prior = Information(covariance.inverse()?);
        track.stage = Stage::Follow(*covariance);
        track.at.noise = *noise;
        Some(track)
    }

    /// Takes one more pass and step, unless all that is left to do is to judge.
    ///
    /// # Errors
    /// [`PairError::TooFew`] in front of both cameras.
    pub(crate) fn advance(&mut self, matches: Matches<'_, T>) -> Result<(), PairError> {
        match (&self.stop, &self.stage) {
            (Some(_), _) => (),
            (None, Stage::Follow(covariance)) if self.passes == 0 => {
                self.at.leverage = self.survey(matches.pairs, covariance);
                self.passes = 1;
            }
            (None, Stage::Follow(_)) => {
                self.step(&self.pass(matches, TRACKED.max(matches.pairs.len() / 2)));
            }
            (None, Stage::Anneal(_) | Stage::Polish) => {
                let pass = self.pass(matches, usize::MAX);
                self.at.check(pass.usable)?;
                self.step(&pass);
            }
        }
        Ok(())
    }

    /// What the pose reached is judged with.
    pub(crate) fn outlook(&self) -> &Outlook<T> {
        &self.at
    }

    /// Why it stopped.
    pub(crate) fn stop(&self) -> Stop {
        self.stop.unwrap_or(Stop::PassLimit)
    }

    /// Whether all that is left to do is to judge.
    pub(crate) fn is_done(&self) -> bool {
        self.stop.is_some()
    }

    /// One Gauss-Newton step from the sums at the pose, then the next, tighter stage.
    #[inline(never)]
    fn step(&mut self, pass: &Pass<T>) {
        self.passes = self.passes.saturating_add(1);
        let mut joint = pass.capped.with(&self.prior);
        joint.gradient += self.prior.times(&self.moved);
        let factor = joint.information.0.factor(T::ZERO);
        let stepped = factor.and_then(|factor| {
            let d = -factor.solve(&joint.gradient);
            Some((d, self.at.pose.stepped_by(&d)?, factor.inverse()))
        });
        let Some((d, pose, covariance)) = stepped else {
            self.stop = Some(Stop::NoDescent);
            return;
        };
        self.at.pose = pose;
        self.moved += d;
        let size = d.dot(&pass.capped.information.times(&d));
        let before = self.variance();
        let settled = self.tighten(pass);
        let held = &pass.capped.information.0;
        self.at.fitted = covariance.dot(held);
        let growth = self.variance() / before;
        self.at.leverage = Leverage::of(held, pass.weighted, &covariance, growth);
        let [_, yaw, ..] = covariance.diagonal();
        self.at.min_disparity =
            -T::lit(MIN_DISPARITY_PX) / self.at.focal - T::lit(3.0) * yaw.sqrt();
        if let Stage::Follow(uncertain) = &mut self.stage {
            *uncertain = covariance;
        }
        self.stop = if settled && size <= T::lit(NEGLIGIBLE) {
            Some(Stop::Converged)
        } else if self.passes >= self.max_passes {
            Some(Stop::PassLimit)
        } else {
            None
        };
    }

    /// What the loss of the current stage makes of a residual's variance, px^2.
    fn variance(&self) -> T {
        match self.stage {
            Stage::Anneal(scale) => scale * scale,
            Stage::Follow(_) | Stage::Polish => self.at.noise * self.at.noise,
        }
    }

    /// Takes the next smaller scale, or a better estimate of the noise; whether that has settled.
    fn tighten(&mut self, pass: &Pass<T>) -> bool {
        match self.stage {
            Stage::Anneal(scale) => {
                let next = scale * self.annealing;
                let last = next <= T::lit(LAST_SCALE_PX);
                self.stage = if last { Stage::Polish } else { Stage::Anneal(next) };
                false
            }
            Stage::Polish if pass.near > 0 => {
                let noise = self.at.noise_of(pass.near_squares, pass.near);
                let change = (noise - self.at.noise).abs();
                self.at.noise = noise;
                change <= T::lit(SETTLED) * noise
            }
            Stage::Follow(_) | Stage::Polish => false,
        }
    }
}
