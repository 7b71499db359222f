//! One pair among mismatches: whitened residuals under a redescending loss, one pass at a time.
//!
//! Two ways to the optimum, each pass one Gauss-Newton step with a prior. *Search* comes from afar:
//! Geman-McClure's loss from a scale that covers the prior, halved each pass, then Tukey's biweight at
//! the noise, which is estimated on the way. *Track* starts at a running estimate with its 5 x 5
//! information: the loss of each correspondence is as wide as that leaves its residual uncertain.
//! A correspondence that would carry many times its share of the information is held down: a gross
//! mismatch with a huge disparity near its epipolar line fits any pose, and no residual tells it from
//! a near point.

mod judgement;
mod pass;
mod weight;

pub(crate) use judgement::Judged;

use nalgebra::{Matrix5, Vector5};

use crate::config::Config;
use crate::correspondence::RayPair;
use crate::error::PairError;
use crate::information::{BLOCK, Information};
use crate::loss::Redescending;
use crate::rectification::RectifyingRotations;
use crate::report::Stop;
use crate::scalar::Scalar;
use crate::whitening::{WhitenedRow, whitened};
use pass::{Leverage, Pass, of_baseline, share};
use weight::Spread;

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

/// Variance of a normal distribution cut off at two standard deviations.
const TRUNCATED_VARIANCE: f64 = 0.7737;

/// A match this far behind infinity is none, px: noise may reach below a disparity of 0. While the
/// estimate is loose its yaw moves all disparities by more.
const MIN_DISPARITY_PX: f64 = 4.0;

/// Converged when the step, in standard deviations of the estimate, squared, is below this.
const NEGLIGIBLE: f64 = 1e-4;

/// The noise has settled when it changes by no more than this share.
const SETTLED: f64 = 0.05;

/// Passes of a track: three steps and the judgement.
pub(crate) const TRACK_PASSES: u16 = 4;

/// The loss of a pass.
#[derive(Debug, Clone, Copy)]
enum Stage<T> {
    /// Geman-McClure at this scale, px.
    Anneal(T),
    /// As wide as the estimate's own uncertainty (covariance, rad^2) asks for.
    Follow(Matrix5<T>),
    /// Tukey at the noise.
    Polish,
}

/// What is known before a pair is tracked.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Known<T: Scalar> {
    pub(crate) pose: RectifyingRotations<T>,
    /// Of the estimate, with what a pair may differ from it, rad^2.
    pub(crate) covariance: Matrix5<T>,
    /// Of a coordinate, px.
    pub(crate) noise: T,
}

/// A pair on its way to its optimum.
#[derive(Debug, Clone)]
pub(crate) struct Descent<T: Scalar> {
    focal: T,
    noise_floor: T,
    needed: u32,
    start: RectifyingRotations<T>,
    /// About the start.
    prior: Information<T>,
    /// Each scale of the loss over the one before.
    annealing: T,
    pose: RectifyingRotations<T>,
    /// Sum of the steps taken from the start.
    moved: Vector5<T>,
    stage: Stage<T>,
    noise: T,
    leverage: Option<Leverage<T>>,
    /// Unknowns that the correspondences determine rather than the prior, 0 to 5.
    fitted: T,
    min_disparity_px: T,
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
        Self {
            focal,
            noise_floor: T::lit(config.noise_floor_px.into()),
            needed: config.min_correspondences.into(),
            start,
            prior: config.prior(),
            annealing: T::HALF,
            pose: start,
            moved: Vector5::zeros(),
            stage: Stage::Anneal(T::lit(FIRST_SCALE_PX)),
            noise: T::lit(NOISE_PX[0]),
            leverage: None,
            fitted: T::ZERO,
            min_disparity_px: -T::lit(MIN_DISPARITY_PX),
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
        Some(Self {
            prior: Information::of_covariance(covariance)?,
            stage: Stage::Follow(*covariance),
            noise: *noise,
            ..Self::search(config, focal, *pose, TRACK_PASSES)
        })
    }

    /// Takes one more pass and step, unless [`Descent::judge`] is all that is left to do.
    ///
    /// # Errors
    /// [`PairError::TooFew`] in front of both cameras.
    pub(crate) fn advance(&mut self, pairs: &[RayPair<T>]) -> Result<(), PairError> {
        if self.stop.is_none() {
            let pass = self.pass(pairs);
            if pass.usable < self.needed {
                return Err(PairError::TooFew { usable: pass.usable, needed: self.needed });
            }
            self.step(&pass);
        }
        Ok(())
    }

    /// Why it stopped.
    pub(crate) fn stop(&self) -> Stop {
        self.stop.unwrap_or(Stop::PassLimit)
    }

    /// Whether [`Descent::judge`] is all that is left to do.
    pub(crate) fn is_done(&self) -> bool {
        self.stop.is_some()
    }

    /// One Gauss-Newton step from the sums at the pose, then the next, tighter stage.
    fn step(&mut self, pass: &Pass<T>) {
        self.passes = self.passes.saturating_add(1);
        let mut joint = pass.capped.with(&self.prior);
        joint.gradient += self.prior.times(&self.moved);
        let Some((d, pose)) = joint.step().and_then(|d| Some((d, self.pose.stepped_by(&d)?)))
        else {
            self.stop = Some(Stop::NoDescent);
            return;
        };
        // The first pass of a track only learns what leverage is usual.
        if self.passes > 1 || !matches!(self.stage, Stage::Follow(_)) {
            self.pose = pose;
            self.moved += d;
        }
        let size = d.dot(&pass.capped.information.times(&d));
        let before = self.variance();
        let settled = self.tighten(pass);
        if let Some(covariance) = joint.information.covariance() {
            self.fitted = covariance.dot(&pass.capped.information.matrix());
            self.leverage = match &self.stage {
                Stage::Follow(prior) if self.passes == 1 => Leverage::first(pass, prior),
                _ => Leverage::of(pass, &covariance, before, self.variance()),
            };
            self.min_disparity_px =
                -T::lit(MIN_DISPARITY_PX) - T::lit(3.0) * self.focal * covariance.m22.sqrt();
            if matches!(self.stage, Stage::Follow(_)) {
                self.stage = Stage::Follow(covariance);
            }
        }
        self.stop = if settled && size <= T::lit(NEGLIGIBLE) {
            Some(Stop::Converged)
        } else if self.passes >= self.max_passes {
            Some(Stop::PassLimit)
        } else {
            None
        };
    }

    /// Noise of a coordinate, px, by the squares of so many residuals within 2 standard deviations.
    fn noise_of(&self, near_squares: T, near: u32) -> T {
        let count = T::count(near.max(1));
        // The fit has taken up as much of them as it has freedom.
        let free = (count - self.fitted).max(count * T::HALF);
        let floor = self.noise_floor * self.noise_floor;
        let noise = (near_squares / free).max(floor).sqrt();
        noise.min(T::lit(NOISE_PX[1])).max(self.noise_floor)
    }

    /// What the loss of the current stage makes of a residual's variance, px^2.
    fn variance(&self) -> T {
        match self.stage {
            Stage::Anneal(scale) => scale * scale,
            Stage::Follow(_) | Stage::Polish => self.noise * self.noise,
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
                let noise = self.noise_of(pass.near_squares, pass.near);
                let change = (noise - self.noise).abs();
                self.noise = noise;
                change <= T::lit(SETTLED) * noise
            }
            Stage::Follow(_) | Stage::Polish => false,
        }
    }

    fn pass(&self, pairs: &[RayPair<T>]) -> Pass<T> {
        let gauge_slope = self.pose.gauge_slope();
        let mut total = Pass::EMPTY;
        for block in pairs.chunks(BLOCK) {
            let mut sums = Pass::EMPTY;
            for pair in block {
                if let Some(row) = whitened(&self.pose, gauge_slope, self.focal, pair) {
                    self.add(&mut sums, &row, pair.grid_step());
                }
            }
            total.merge(&sums);
        }
        total
    }

    fn add(&self, sums: &mut Pass<T>, row: &WhitenedRow<T>, grid_step: T) {
        sums.usable = sums.usable.saturating_add(1);
        let spread = Spread::of(self.noise, grid_step);
        let Some(w) = self.weight(row, &spread) else {
            return;
        };
        let j = &row.row.jacobian;
        let r = row.row.offset;
        if w > T::ZERO {
            sums.weighted = sums.weighted.saturating_add(1);
            if let (Stage::Follow(covariance), 0) = (&self.stage, self.passes) {
                sums.roots += share(&of_baseline(covariance), w, j).sqrt();
            }
            let w = self.leverage.as_ref().map_or(w, |leverage| leverage.hold_down(w, j));
            sums.capped.add_row(w, r, j);
        }
        if spread.is_within(T::lit(2.0), r) {
            sums.near = sums.near.saturating_add(1);
            sums.near_squares += r * r / T::lit(TRUNCATED_VARIANCE) - spread.of_grid;
        }
    }

    /// Weight of a row in the normal equations, 1/px^2; `None` for a point behind the cameras.
    fn weight(&self, row: &WhitenedRow<T>, spread: &Spread<T>) -> Option<T> {
        let r = row.row.offset;
        Some(match &self.stage {
            Stage::Anneal(scale) => {
                Redescending::GemanMcClure(*scale).weight(r) / (*scale * *scale)
            }
            _ if row.disparity_px < self.min_disparity_px => return None,
            Stage::Follow(covariance) => {
                let j = Vector5::from(row.row.jacobian);
                let wide = (spread.unit_squared + j.dot(&(covariance * j))).sqrt() * T::lit(TUKEY);
                let loss = if self.passes == 0 {
                    Redescending::GemanMcClure(wide)
                } else {
                    Redescending::Tukey(wide)
                };
                loss.weight(r) / spread.variance
            }
            Stage::Polish => return self.polished(row, spread),
        })
    }

    /// The same at the noise alone, whatever the stage.
    fn polished(&self, row: &WhitenedRow<T>, spread: &Spread<T>) -> Option<T> {
        (row.disparity_px >= self.min_disparity_px)
            .then(|| spread.tukey(row.row.offset) / spread.variance)
    }
}
