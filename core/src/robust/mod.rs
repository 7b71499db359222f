//! One pair among mismatches: graduated non-convexity on whitened residuals, one pass at a time.
//!
//! Geman-McClure's loss from a scale that covers the prior, halved each pass; then Tukey's biweight
//! at 4.685 times the noise, which is estimated on the way. Each pass is one Gauss-Newton step with
//! the factory extrinsics as prior. A correspondence that would carry many times its share of the
//! information is held down: a gross mismatch with a huge disparity near its epipolar line fits any
//! pose, and no residual tells it from a near point.

mod pass;

use nalgebra::{Vector2, Vector3, Vector5};

use crate::config::Config;
use crate::correspondence::RayPair;
use crate::error::PairError;
use crate::extrinsics::Extrinsics;
use crate::information::{BLOCK, Information};
use crate::loss::Redescending;
use crate::rectification::RectifyingRotations;
use crate::report::{PairReport, Stop};
use crate::scalar::Scalar;
use crate::whitening::{WhitenedRow, whitened};
use pass::{Leverage, Pass};

/// First scale of the loss, px: 5 degrees at a focal length of 1400 px.
const FIRST_SCALE_PX: f64 = 120.0;

/// The scale below which the noise takes over, px.
const LAST_SCALE_PX: f64 = 7.5;

/// Tukey's limit in standard deviations: 95 % efficient on Gaussian noise.
const TUKEY: f64 = 4.685;

/// Noise of a coordinate to begin with, which a consensus stays below, and at most, px.
const NOISE_PX: [f64; 2] = [1.5, 3.0];

/// Variance of a normal distribution cut off at two standard deviations.
const TRUNCATED_VARIANCE: f64 = 0.7737;

/// Disparity below which a match lies behind the cameras, px; noise may reach below 0.
const MIN_DISPARITY_PX: f64 = -4.0;

/// Converged when the step, in standard deviations of the estimate, squared, is below this.
const NEGLIGIBLE: f64 = 1e-4;

/// The noise has settled when it changes by no more than this share.
const SETTLED: f64 = 0.05;

/// Share of the correspondences that must fit.
const MIN_INLIERS: f64 = 0.15;

/// The loss of a pass.
#[derive(Debug, Clone, Copy)]
enum Stage<T> {
    /// Geman-McClure at this scale, px.
    Anneal(T),
    /// Tukey at the noise estimated so far.
    Polish,
}

/// A pair on its way to its optimum.
#[derive(Debug, Clone)]
pub(crate) struct RobustSolver<T: Scalar> {
    focal: T,
    prior: T,
    noise_floor: T,
    max_passes: u16,
    needed: u32,
    start: RectifyingRotations<T>,
    pose: RectifyingRotations<T>,
    /// Sum of the steps taken from the prior's mean.
    moved: Vector5<T>,
    stage: Stage<T>,
    noise: T,
    leverage: Option<Leverage<T>>,
    passes: u16,
    stop: Option<Stop>,
}

impl<T: Scalar> RobustSolver<T> {
    /// Takes the first pass, at the start.
    ///
    /// # Errors
    /// [`PairError::TooFew`], [`PairError::Unobservable`].
    pub(crate) fn begin(
        config: &Config,
        focal: T,
        start: &Extrinsics<T>,
        pairs: &[RayPair<T>],
    ) -> Result<Self, PairError> {
        let prior_sd = T::lit(config.prior_sd_rad.into());
        let mut solver = Self {
            focal,
            prior: T::ONE / (prior_sd * prior_sd),
            noise_floor: T::lit(config.noise_floor_px.into()),
            max_passes: config.max_passes,
            needed: config.min_correspondences.into(),
            start: RectifyingRotations::from(start),
            pose: RectifyingRotations::from(start),
            moved: Vector5::zeros(),
            stage: Stage::Anneal(T::lit(FIRST_SCALE_PX)),
            noise: T::lit(NOISE_PX[0]),
            leverage: None,
            passes: 0,
            stop: None,
        };
        let pass = solver.pass(pairs);
        if pass.usable < solver.needed {
            return Err(PairError::TooFew { usable: pass.usable, needed: solver.needed });
        }
        if !pass.uncapped.is_observable() {
            return Err(PairError::Unobservable);
        }
        solver.step(&pass);
        Ok(solver)
    }

    /// Takes one more pass and step. `Some` when done.
    pub(crate) fn advance(&mut self, pairs: &[RayPair<T>]) -> Option<Stop> {
        if self.stop.is_none() {
            let pass = self.pass(pairs);
            self.step(&pass);
        }
        self.stop
    }

    /// Whether [`RobustSolver::report`] is all that is left to do.
    pub(crate) fn is_done(&self) -> bool {
        self.stop.is_some()
    }

    /// One Gauss-Newton step from the sums at the pose, then the next, tighter stage.
    fn step(&mut self, pass: &Pass<T>) {
        self.passes = self.passes.saturating_add(1);
        let scale = self.scale();
        let inverse_square = T::ONE / (scale * scale);
        let information = pass.capped.scaled(inverse_square);
        let pull = self.moved * self.prior;
        let gradient = Vector5::from(pass.gradient) * inverse_square + pull;
        let step = information
            .plus_diagonal(self.prior)
            .damped_step(T::ZERO, &gradient.into())
            .and_then(|d| {
                let pose =
                    self.pose.stepped(&Vector3::new(d.x, d.y, d.z), &Vector2::new(d.w, d.a))?;
                Some((d, pose))
            });
        let Some((d, pose)) = step else {
            self.stop = Some(Stop::NoDescent);
            return;
        };
        self.pose = pose;
        self.moved += d;
        self.leverage = Leverage::of(pass, self.prior * scale * scale);
        let size = d.dot(&information.times(&d));
        let settled = self.tighten(pass);
        self.stop = if settled && size <= T::lit(NEGLIGIBLE) {
            Some(Stop::Converged)
        } else if self.passes >= self.max_passes {
            Some(Stop::PassLimit)
        } else {
            None
        };
    }

    /// Takes the next smaller scale, or a better estimate of the noise; whether that has settled.
    fn tighten(&mut self, pass: &Pass<T>) -> bool {
        match self.stage {
            Stage::Anneal(scale) => {
                let next = scale * T::HALF;
                let last = next <= T::lit(LAST_SCALE_PX);
                self.stage = if last { Stage::Polish } else { Stage::Anneal(next) };
                false
            }
            Stage::Polish if pass.near > 0 => {
                let mean = pass.near_squares / T::count(pass.near);
                let noise = (mean / T::lit(TRUNCATED_VARIANCE)).sqrt();
                let noise = noise.min(T::lit(NOISE_PX[1])).max(self.noise_floor);
                let change = (noise - self.noise).abs();
                self.noise = noise;
                change <= T::lit(SETTLED) * noise
            }
            Stage::Polish => false,
        }
    }

    /// Unit of the residual in the current stage, px.
    fn scale(&self) -> T {
        match self.stage {
            Stage::Anneal(scale) => scale,
            Stage::Polish => self.noise,
        }
    }

    fn loss(&self) -> Redescending<T> {
        match self.stage {
            Stage::Anneal(scale) => Redescending::GemanMcClure(scale),
            Stage::Polish => Redescending::Tukey(self.noise * T::lit(TUKEY)),
        }
    }

    fn pass(&self, pairs: &[RayPair<T>]) -> Pass<T> {
        let gauge_slope = self.pose.gauge_slope();
        let mut total = Pass::EMPTY;
        for block in pairs.chunks(BLOCK) {
            let mut sums = Pass::EMPTY;
            for pair in block {
                match whitened(&self.pose, gauge_slope, self.focal, pair) {
                    Some(row) => self.add(&mut sums, &row),
                    None => sums.skipped = sums.skipped.saturating_add(1),
                }
            }
            total.merge(&sums);
        }
        total
    }

    fn add(&self, sums: &mut Pass<T>, row: &WhitenedRow<T>) {
        let j = &row.row.jacobian;
        let r = row.row.offset;
        sums.usable = sums.usable.saturating_add(1);
        // While the estimate is loose its yaw moves all disparities.
        let polishing = matches!(self.stage, Stage::Polish);
        if polishing && row.disparity_px < T::lit(MIN_DISPARITY_PX) {
            return;
        }
        let w = self.loss().weight(r);
        if w > T::ZERO {
            sums.weighted = sums.weighted.saturating_add(1);
            sums.uncapped.add_outer(w, j);
            let w = self.leverage.as_ref().map_or(w, |leverage| leverage.hold_down(w, j));
            sums.capped.add_outer(w, j);
            sums.weight += w;
            let weighted = w * r;
            for (sum, j) in sums.gradient.iter_mut().zip(j) {
                *sum += weighted * *j;
            }
        }
        let size = r.abs() / self.noise;
        if size < T::lit(2.0) {
            sums.near = sums.near.saturating_add(1);
            sums.near_squares += r * r;
        } else if size < T::lit(4.0) {
            sums.beside = sums.beside.saturating_add(1);
        }
    }

    /// Takes the judging pass at the pose reached and reports.
    ///
    /// # Errors
    /// [`PairError::NoConsensus`] if the residuals have no peak at zero; [`PairError::Unobservable`] if
    /// what is left of the correspondences does not determine a pose.
    pub(crate) fn report(&self, pairs: &[RayPair<T>]) -> Result<PairReport<T>, PairError> {
        let extrinsics = self.pose.extrinsics().map_err(|_| PairError::Unobservable)?;
        let pass = self.pass(pairs);
        if !self.has_peak(&pass) {
            return Err(PairError::NoConsensus);
        }
        let information = pass
            .capped
            .less_disparity_noise(pass.weight, self.noise * self.noise)
            .filter(Information::is_observable)
            .ok_or(PairError::Unobservable)?;
        let inverse_square = T::ONE / (self.noise * self.noise);
        let score = pass.gradient.map(|g| -g * inverse_square);
        let rows = self.rows(pairs);
        Ok(PairReport {
            extrinsics,
            information: information.scaled(inverse_square),
            score,
            stop: self.stop.unwrap_or(Stop::PassLimit),
            passes: self.passes,
            usable: pass.usable,
            skipped: pass.skipped,
            screened: rows.screened,
            cost_before: rows.cost[0],
            cost_after: rows.cost[1],
            rms_px_before: rows.rms(rows.squares[0]),
            rms_px_after: rows.rms(rows.squares[1]),
            noise_px: self.noise,
        })
    }

    /// Whether the residuals gather at zero. Mismatches have about as many within two standard
    /// deviations as from two to four, and let the scale grow.
    fn has_peak(&self, pass: &Pass<T>) -> bool {
        let near = T::count(pass.near);
        pass.near >= self.needed
            && near >= T::lit(2.0) * T::count(pass.beside)
            && near >= T::lit(MIN_INLIERS) * T::count(pass.usable)
            && self.noise < T::lit(NOISE_PX[0])
    }

    /// Costs and row offsets of start and solution, over the same correspondences.
    fn rows(&self, pairs: &[RayPair<T>]) -> Rows<T> {
        let limit = self.noise * T::lit(TUKEY);
        let loss = Redescending::Tukey(limit);
        let [start_slope, slope] = [self.start.gauge_slope(), self.pose.gauge_slope()];
        let mut rows = Rows { screened: 0, cost: [T::ZERO; 2], squares: [T::ZERO; 2] };
        for pair in pairs {
            let before = whitened(&self.start, start_slope, self.focal, pair);
            let after = whitened(&self.pose, slope, self.focal, pair);
            let Some((before, after)) = before.zip(after) else {
                continue;
            };
            rows.cost[0] += loss.cost(before.row.offset);
            rows.cost[1] += loss.cost(after.row.offset);
            if after.row.offset.abs() <= limit {
                rows.screened = rows.screened.saturating_add(1);
                rows.squares[0] += before.offset_px * before.offset_px;
                rows.squares[1] += after.offset_px * after.offset_px;
            }
        }
        rows
    }
}

/// Sums over the correspondences that have a row both at the start and at the solution.
struct Rows<T> {
    screened: u32,
    cost: [T; 2],
    squares: [T; 2],
}

impl<T: Scalar> Rows<T> {
    fn rms(&self, squares: T) -> T {
        (squares / T::count(self.screened.max(1))).sqrt()
    }
}
